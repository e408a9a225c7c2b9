//! Figures of a GPU that formulas can name.

use gpumodel::{CacheRole, Gpu};

/// A figure of a GPU.
#[derive(Clone, Copy, Debug)]
pub struct GpuFigure {
    /// What formulas call it.
    pub name: &'static str,
    /// What it is, with its unit.
    pub meaning: &'static str,
    value: fn(&Gpu) -> Option<f64>,
}

const fn figure(name: &'static str, meaning: &'static str, value: fn(&Gpu) -> Option<f64>) -> GpuFigure {
    GpuFigure { name, meaning, value }
}

/// All of them.
pub const GPU_FIGURES: &[GpuFigure] = &[
    figure("clock_hz", "cycles of the shader clock per second", |gpu| Some(gpu.clock.hz)),
    figure("cores", "shader cores", |gpu| Some(f64::from(gpu.cores.count))),
    figure("warp_width", "lanes of a warp", |gpu| Some(f64::from(gpu.cores.warp_width))),
    figure("warp_slots", "most warps resident in a core", |gpu| Some(f64::from(gpu.cores.warp_slots))),
    figure("alu_lanes", "full-precision operations per clock and core", |gpu| Some(gpu.cores.alu_lanes)),
    figure("efu_lanes", "elementary functions per clock and core", |gpu| Some(gpu.cores.efu_lanes)),
    figure("l2_line_bytes", "bytes of a line of the second level", |gpu| {
        let l2 = gpu.caches.iter().find(|cache| cache.role == CacheRole::L2)?;
        Some(l2.line_bytes as f64)
    }),
    figure("dram_bytes_per_second", "bytes per second of memory at best", |gpu| {
        Some(gpu.dram.peak_bytes_per_second)
    }),
];

/// The figure of that name.
///
/// # Errors
/// That the GPU does not have it.
pub(super) fn value(gpu: &Gpu, name: &str) -> Result<f64, String> {
    let figure = GPU_FIGURES.iter().find(|figure| figure.name == name);
    figure.and_then(|figure| (figure.value)(gpu)).ok_or_else(|| format!("the GPU has no {name}"))
}
