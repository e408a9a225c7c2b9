//! Reflections over a G-buffer, by compute dispatches one after the other: a march through the depth buffer, ray queries for what the screen
//! does not show, and shading, by the shader that traces or sorted by material (Calvo Lista, Vulkanised 2026).
//!
//! What rays hit, and in which order they lie in lists, is executed ([`ordering`](crate::ordering)); what that costs goes through the same warps,
//! caches and queues as every other frame. The G-buffer is there already, in memory.

mod frame;
mod listing;
mod lists;
mod maps;
mod march;
pub(crate) mod pipeline;
#[cfg(test)]
mod pipeline_tests;
mod prices;
mod rays;
mod sort;
#[cfg(test)]
mod tests;

pub use self::maps::{Coverage, LaneSlots, ReflectionMaps};

use self::prices::Prices;
use crate::config::{Reflections as Technique, ScreenSpace};
use crate::error::Error;
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed};
use tracer::reflections::{ReflectionList, Reflections};
use tracer::{Aabb, TraceHeader};

/// A frame of reflections, as the tracer knows it.
pub struct ReflectionFrame<'a> {
    /// Its rays, and what becomes of them.
    pub reflections: &'a Reflections<'a>,
    /// Traces its rays in an order, with shadow rays from what they hit or without.
    pub list: &'a ListTracer<'a>,
    /// By triangle, the shader of its material, from 0.
    pub shaders: &'a [u32],
    /// The scene's box.
    pub bounds: Aabb,
}

/// Traces reflection rays in an order.
pub type ListTracer<'a> =
    dyn Fn(Vec<u32>, Shadows) -> Result<Box<dyn ReflectionList + 'a>, tracer::Error> + Sync + 'a;

/// Whether shadow rays are traced from what reflection rays hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// They are.
    Traced,
    /// They are not.
    None,
}

/// A frame of reflections that has been replayed.
#[derive(Clone, Debug)]
pub struct ReplayedReflections {
    /// Its counts. Of heat maps, those of warps tell of the dispatches that trace: a pixel's march belongs to none.
    pub replayed: Replayed,
    /// Over the pixels of the image.
    pub header: TraceHeader,
    /// What its pixels show, where that was asked for.
    pub maps: Option<ReflectionMaps>,
}

/// Replays a frame of reflections.
///
/// # Errors
/// When the configuration's technique has no reflections or cannot run on its GPU, or a list of rays cannot be traced.
pub fn replay_reflections(
    frame: &ReflectionFrame<'_>,
    config: &ReplayConfig,
    maps: Maps,
) -> Result<ReplayedReflections, Error> {
    let Some(technique) = &config.technique.reflections else {
        return Err(refuse(config, "has no [reflections]", "use one of reflections-*"));
    };
    if technique.screen_space != ScreenSpace::None && frame.reflections.depth().is_none() {
        let problem = "looks rays up on a screen whose depths the trace does not have";
        return Err(refuse(config, problem, "use --screen-space none, or profile the scene"));
    }
    if config.fidelity == Fidelity::Timed {
        let problem = "has several shaders, which are not simulated event by event";
        return Err(refuse(config, problem, "use --fidelity replay"));
    }
    let prices = Prices::of(&config.costs).ok_or_else(|| Error::Config {
        file: "table of shader costs".to_owned(),
        line: None,
        key: String::new(),
        problem: "it has no [secondary] or no [reflections]".to_owned(),
        remedy: "add them, as configs/costs.toml has".to_owned(),
    })?;
    let atomics = config.gpu.atomics.as_ref().ok_or_else(|| Error::Config {
        file: config.gpu.name().to_owned(),
        line: None,
        key: String::new(),
        problem: "it has no [atomics]".to_owned(),
        remedy: "add it, as configs/gpus/mali-g715.toml has".to_owned(),
    })?;
    if config.gpu.emulates(&config.technique) && config.gpu.ray_unit.is_some() {
        let problem = "sends ray queries from hit shaders, which its GPU emulates without its ray unit";
        return Err(refuse(config, problem, "take ray_unit away from its GPU"));
    }
    frame::Replay::new(frame, config, technique, (prices, atomics), maps).run()
}

fn refuse(config: &ReplayConfig, problem: &str, remedy: &str) -> Error {
    Error::Config {
        file: config.technique.name.clone(),
        line: None,
        key: String::new(),
        problem: problem.to_owned(),
        remedy: remedy.to_owned(),
    }
}

fn size(reflections: &Reflections<'_>) -> (u32, u32) {
    reflections.size().into()
}
