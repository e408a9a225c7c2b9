//! Two eyes, one after the other: the left one is traced, and kernels find out what the right one can reuse (Lee et al. 2017).
//!
//! | frame | dispatches |
//! |---|---|
//! | left eye | every pixel is traced, and its G-buffer kept; *reprojection* finds where the right eye sees it |
//! | right eye | *error detection* sorts the pixels of its image into those that are traced and those that are answered; one dispatch takes both lists |
//!
//! The sorting is the inspector, and the last dispatch the executor, so that warps have pixels of one sort; without it, they take them as they lie. What is where, and which pixels are answered, is
//! executed ([`Reprojection`]); what that costs goes through the same warps, caches and queues as every other frame. Each eye begins with cold caches.

mod buffers;
mod error_detection;
mod eye;
mod left;
mod right;
#[cfg(test)]
mod tests;

pub use self::error_detection::Window;

use self::eye::Eye;
use crate::config::{Atomics, Attachments, Stereo, StereoCosts, StereoLaunch};
use crate::error::Error;
use crate::replay::{Fidelity, ReplayConfig, Replayed};
use tracer::TileSource;
use tracer::stereo::Reprojection;

/// The pixels of the right image in the order in which they are shaded, in tiles of 32x32 pixels: all of them, or first those that are traced, then
/// those that the left eye answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelOrder {
    /// Their numbers, in rows of the image.
    pub pixels: Vec<u32>,
    /// Of each, whether the left eye answers it.
    pub known: Vec<bool>,
}

impl PixelOrder {
    /// Of a right image.
    pub fn new(known: &Reprojection, launch: StereoLaunch) -> Self {
        let [width, height] = known.size();
        let frame = tracer::Frame::Image { width, height };
        let of_tile = |index: u32| {
            let rect = frame.tile(index);
            (rect.y..rect.y + rect.height)
                .flat_map(move |y| (rect.x..rect.x + rect.width).map(move |x| y * width + x))
        };
        let is_known = |pixel: u32| known.left_pixel(pixel).is_some();
        let mut pixels: Vec<u32> = (0..frame.tiles()).flat_map(of_tile).collect();
        if launch == StereoLaunch::Lists {
            // Stable: neighbours stay together.
            pixels.sort_by_key(|&pixel| is_known(pixel));
        }
        let known = pixels.iter().map(|&pixel| is_known(pixel)).collect();
        Self { pixels, known }
    }
}

/// Replays the left eye's frame, of which `left` traces every pixel and `known` tells where the right eye sees them.
///
/// # Errors
/// When the configuration's technique is not of two eyes or cannot run on its GPU, or the trace contradicts itself.
pub fn replay_left<S: TileSource>(
    left: &S,
    known: &Reprojection,
    config: &ReplayConfig,
) -> Result<Replayed, Error> {
    let kernels = Kernels::of(known, config)?;
    left::replay(Eye::new(left, &kernels)?, &kernels)
}

/// Replays the right eye's frame, of which `right` traces the pixels of `order`.
///
/// # Errors
/// As [`replay_left`].
pub fn replay_right<S: TileSource>(
    right: &S,
    order: &PixelOrder,
    known: &Reprojection,
    config: &ReplayConfig,
) -> Result<Replayed, Error> {
    let kernels = Kernels::of(known, config)?;
    right::replay(Eye::new(right, &kernels)?, &kernels, order)
}

/// What the kernels of both eyes are run with.
#[derive(Clone, Copy)]
struct Kernels<'a> {
    config: &'a ReplayConfig,
    stereo: &'a Stereo,
    costs: &'a StereoCosts,
    atomics: &'a Atomics,
    known: &'a Reprojection,
}

impl<'a> Kernels<'a> {
    fn of(known: &'a Reprojection, config: &'a ReplayConfig) -> Result<Self, Error> {
        let gpu = &config.gpu;
        let refuse = |file: &str, problem: String, remedy: &str| Error::Config {
            file: file.to_owned(),
            line: None,
            key: String::new(),
            problem,
            remedy: remedy.to_owned(),
        };
        let technique = config.technique.name.as_str();
        let stereo =
            config.technique.stereo.as_ref().ok_or_else(|| {
                refuse(technique, "has no [stereo]".to_owned(), "use stereo or stereo-memory")
            })?;
        if config.fidelity == Fidelity::Timed {
            let problem = "has several shaders, which are not simulated event by event".to_owned();
            return Err(refuse(technique, problem, "use --fidelity replay"));
        }
        let costs = config.costs.stereo().ok_or_else(|| {
            refuse(
                "table of shader costs",
                "it has no [stereo]".to_owned(),
                "add it, as configs/costs.toml has",
            )
        })?;
        let atomics = gpu.atomics.as_ref().ok_or_else(|| {
            refuse(gpu.name(), "it has no [atomics]".to_owned(), "add it, as configs/gpus/mali-g715.toml has")
        })?;
        if stereo.gbuffer == Attachments::Tile {
            if gpu.internal_memory.is_none() {
                let problem = format!(
                    "keeps its G-buffer in internal memory, and no kernel of {} reaches any",
                    gpu.name()
                );
                return Err(refuse(technique, problem, "use stereo-memory, or --gpu sgrt"));
            }
            let (needed, there) = (Window::of(known, stereo).bytes, u64::from(gpu.tiler.tile_memory_bytes));
            if needed > there {
                let [width, height] = stereo.tile;
                let problem = format!(
                    "needs {needed} bytes of internal memory for tiles of {width}x{height} and what they see of their rows, and {} has {there}",
                    gpu.name()
                );
                return Err(refuse(
                    technique,
                    problem,
                    "use stereo-memory, smaller tiles, or eyes that are less far apart",
                ));
            }
        }
        Ok(Self { config, stereo, costs, atomics, known })
    }

    fn in_tiles(&self) -> bool {
        self.stereo.gbuffer == Attachments::Tile
    }
}
