//! The unit of a core that walks acceleration structures.

use super::gpu::CacheLevel;
use super::gpu_checks::{IN_FLIGHT, RATE, WIDEST_WARP, path};
use super::gpu_file::RayUnitFile;
use super::sourced::File;
use crate::error::Error;
use serde::Deserialize;

/// A ray unit: it walks a wide BVH from a ray query to its answer, tests boxes and triangles, and keeps the stack.
#[derive(Clone, Debug, PartialEq)]
pub struct RayUnit {
    /// Which rays it tests together.
    pub scheduling: RayScheduling,
    /// Ray-box tests per clock.
    pub boxes_per_clock: f64,
    /// Ray-triangle tests per clock.
    pub triangles_per_clock: f64,
    /// Rays of a warp that a test has places for where rays are scheduled by warps: a box or triangle that fewer rays meet takes as long.
    pub rays_together: u32,
    /// Lines that can be on their way to the unit at once, where its first cache is its own; else they are among those of the load/store unit.
    pub lines_in_flight: u32,
    /// Caches that it reads through, as indices into [`Gpu::caches`](super::Gpu::caches), nearest first.
    pub path: Vec<usize>,
}

/// Which rays a ray unit tests together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayScheduling {
    /// The rays of a warp that are at the same node (Arm's first unit: Immortalis-G715, G720, G925).
    Warp,
    /// Each ray by itself (Arm's second unit: Mali G1-Ultra).
    Ray,
}

impl RayScheduling {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Warp, Self::Ray];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Warp => "warp",
            Self::Ray => "ray",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scheduling| scheduling.name() == name)
    }
}

impl RayUnit {
    /// Rays that a test of a box or a triangle has places for.
    pub fn places(&self) -> u32 {
        match self.scheduling {
            RayScheduling::Warp => self.rays_together,
            RayScheduling::Ray => 1,
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
        path: path(file, "ray_unit.path", &raw.path, caches)?,
    })
}
