//! The unit of a core that walks acceleration structures, or tests their nodes for shaders that walk.

use super::gpu::CacheLevel;
use super::gpu_checks::{IN_FLIGHT, RATE, WIDEST_WARP, path};
use super::gpu_file::RayUnitFile;
use super::sourced::File;
use crate::error::Error;
use serde::Deserialize;
use tracer::TraceHeader;
use tracer::wide::NodeFormat;

/// Cycles of a return to the shader.
const RETURN_CYCLES: std::ops::RangeInclusive<f64> = 0.0..=1e6;

/// A ray unit: it tests boxes and triangles of a wide BVH, and walks it from a ray query to its answer, or leaves that to the shader.
#[derive(Clone, Debug, PartialEq)]
pub struct RayUnit {
    /// Which rays it tests together, and who walks.
    pub scheduling: RayScheduling,
    /// Ray-box tests per clock.
    pub boxes_per_clock: f64,
    /// Ray-triangle tests per clock.
    pub triangles_per_clock: f64,
    /// Rays of a warp that a test has places for where rays are scheduled by warps: a box or triangle that fewer rays meet takes as long.
    pub rays_together: u32,
    /// Lines that can be on their way to the unit at once, where its first cache is its own; else they are among those of the load/store unit.
    pub lines_in_flight: u32,
    /// Cycles from a hit that a shader decides about to the shader, and from there back into the unit; `None` where it is not known. One that is an
    /// instruction keeps no ray.
    pub return_cycles: Option<f64>,
    /// Caches that it reads through, as indices into [`Gpu::caches`](super::Gpu::caches), nearest first.
    pub path: Vec<usize>,
}

/// Which rays a ray unit tests together, and who walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayScheduling {
    /// The rays of a warp that are at the same node (Arm's first unit: Immortalis-G715, G720, G925).
    Warp,
    /// Each ray by itself (Arm's second unit: Mali G1-Ultra).
    Ray,
    /// Each ray by itself, at a node that the shader names in an instruction: loop and stack are the shader's (Adreno 7xx and 8xx, Mesa's
    /// `ray_intersection`).
    Instruction,
}

impl RayScheduling {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Warp, Self::Ray, Self::Instruction];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Warp => "warp",
            Self::Ray => "ray",
            Self::Instruction => "instruction",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scheduling| scheduling.name() == name)
    }
}

impl RayUnit {
    /// Whether it has a part in a trace: a unit that walks does so through any wide BVH; one that is an instruction knows one format of nodes, and gives the
    /// order of children and no distances, so that only a traversal that needs none can use it.
    pub(super) fn takes(&self, header: &TraceHeader) -> bool {
        match self.scheduling {
            RayScheduling::Warp | RayScheduling::Ray => header.node_format.is_some(),
            RayScheduling::Instruction => {
                header.node_format == Some(NodeFormat::Adreno8) && header.traversal == "short-stack"
            }
        }
    }

    /// Whether it walks, and keeps the stack.
    pub fn walks(&self) -> bool {
        self.scheduling != RayScheduling::Instruction
    }

    /// Rays that a test of a box or a triangle has places for.
    pub fn places(&self) -> u32 {
        match self.scheduling {
            RayScheduling::Warp => self.rays_together,
            RayScheduling::Ray | RayScheduling::Instruction => 1,
        }
    }
}

pub(super) fn ray_unit(file: &File<'_>, raw: &RayUnitFile, caches: &[CacheLevel]) -> Result<RayUnit, Error> {
    Ok(RayUnit {
        scheduling: *file.sourced("ray_unit.scheduling", &raw.scheduling)?,
        boxes_per_clock: file.within("ray_unit.boxes_per_clock", &raw.boxes_per_clock, RATE)?,
        triangles_per_clock: file.within("ray_unit.triangles_per_clock", &raw.triangles_per_clock, RATE)?,
        rays_together: file.within("ray_unit.rays_together", &raw.rays_together, 1..=WIDEST_WARP)?,
        lines_in_flight: file.within("ray_unit.lines_in_flight", &raw.lines_in_flight, IN_FLIGHT)?,
        return_cycles: raw
            .return_cycles
            .as_ref()
            .map(|raw| file.within("ray_unit.return_cycles", raw, RETURN_CYCLES))
            .transpose()?,
        path: path(file, "ray_unit.path", &raw.path, caches)?,
    })
}
