//! A point with what it asks for, checked, and the name of its inputs.

use super::plan::PlannedPoint;
use crate::args::FrameArgs;
use crate::machine::Machine;
use crate::options::Request;
use crate::report::TOOL;
use crate::settings::FrameSettings;
use crate::vary::{self, meaningless};
use anyhow::anyhow;
use scenes::Scene;
use std::fmt::Write;
use xxhash_rust::xxh3::xxh3_128;

/// A point that can be replayed.
pub(crate) struct ReadyPoint {
    /// Number in the plan.
    pub(crate) index: usize,
    pub(crate) scene: String,
    pub(crate) frame: FrameArgs,
    pub(crate) settings: FrameSettings,
    pub(crate) machine: Machine,
}

impl ReadyPoint {
    /// Checks what a point asks for; where its options mean nothing together, why.
    ///
    /// # Errors
    /// On options that do not exist, or that contradict each other.
    pub(crate) fn new(index: usize, point: &PlannedPoint) -> anyhow::Result<Result<Self, &'static str>> {
        let told = || {
            let options = point.options.iter().map(|(key, value)| format!("{key} {value}"));
            options.collect::<Vec<_>>().join(", ")
        };
        let ready = || {
            let Request { scene, frame, machine } = point.options.request()?;
            let point = vary::Point { values: Vec::new(), frame, machine };
            if let Some(reason) = meaningless(&point) {
                return Ok(Err(reason));
            }
            let vary::Point { frame, machine, .. } = point;
            let settings = FrameSettings::new(&frame)?;
            let machine = Machine::of_whole_frames(&machine)?;
            Ok(Ok(Self { index, scene, frame, settings, machine }))
        };
        ready().map_err(|error: anyhow::Error| anyhow!("point {} ({}): {error}", index + 1, told()))
    }

    /// Hash of everything that its figures follow from, given that of its scene.
    pub(crate) fn id(&self, scene_key: u128) -> String {
        let inputs = format!("{TOOL}\n{scene_key:032x}\n{:?}\n{:?}", self.settings, self.machine.config);
        format!("{:032x}", xxh3_128(inputs.as_bytes()))
    }
}

/// Hash of all of a scene that a frame's figures follow from: its name, geometry, camera and lights, materials and rays, and how its
/// triangles are parted into meshes.
pub(crate) fn scene_key(scene: &Scene) -> u128 {
    let mut text =
        format!("{}\n{:016x}\n{:?}\n{:?}\n", scene.name, scene.hash(), scene.materials, scene.rays);
    for instance in &scene.instances {
        write!(text, "{} ", instance.mesh).expect("a string takes every write");
    }
    let mut bytes = text.into_bytes();
    for mesh in &scene.meshes {
        bytes.extend(mesh.materials.iter().flat_map(|&material| u64::from(material).to_le_bytes()));
        bytes.extend(u64::MAX.to_le_bytes());
    }
    xxh3_128(&bytes)
}
