//! Two eyes on a GPU: each traced as a whole, against the right one with what it reuses of the left one.

use crate::report::Report;
use crate::units::{digits, grouped};
use std::fmt::Write;

/// Names of the passes between the eyes.
const KERNELS: [gpumodel::Pass; 2] = [gpumodel::Pass::Reprojection, gpumodel::Pass::ErrorDetection];

/// Reports of the left and the right eye.
#[derive(Clone, Copy, Debug)]
pub struct TwoEyes<'a> {
    /// Traced as any other image.
    pub traced: [&'a Report; 2],
    /// With reprojection and reuse.
    pub reusing: [&'a Report; 2],
}

impl TwoEyes<'_> {
    /// Milliseconds of both eyes: traced, and with reuse.
    pub fn milliseconds(&self) -> [f64; 2] {
        [self.traced, self.reusing].map(|eyes| sum(eyes, "frame_time_ms").unwrap_or(0.0))
    }

    /// How many times as fast both eyes are with reuse; none where they take no time.
    pub fn speed_up(&self) -> Option<f64> {
        let [traced, reusing] = self.milliseconds();
        (reusing > 0.0).then(|| traced / reusing)
    }

    /// Energy of both eyes with reuse over that without; none where the GPU's description names no process.
    pub fn energy_ratio(&self) -> Option<f64> {
        let traced = sum(self.traced, "energy_mj").filter(|&traced| traced > 0.0)?;
        Some(sum(self.reusing, "energy_mj")? / traced)
    }

    /// Part of the time with reuse that reprojection and error detection take, waits for DMA among them, from 0 to 1.
    pub fn overhead(&self) -> Option<f64> {
        let [_, reusing] = self.milliseconds();
        let kernels: f64 = KERNELS.map(|pass| pass_ms(self.reusing, pass.name())).into_iter().sum();
        (reusing > 0.0).then(|| kernels / reusing)
    }

    /// As a table.
    pub fn text(&self) -> String {
        let [left, _] = self.reusing;
        let mut text = format!(
            "\non {}, {}\n{:<34} {:>14} {:>14}\n",
            left.inputs.gpu, left.inputs.technique, "both eyes", "traced", "with reuse"
        );
        let mut row = |name: &str, unit: &str, figures: [Option<f64>; 2]| {
            if let [Some(traced), Some(reusing)] = figures {
                let label = format!("{name}, {unit}");
                let _ = writeln!(text, "{label:<34} {:>14} {:>14}", digits(traced), digits(reusing));
            }
        };
        let times = self.milliseconds();
        row("time", "ms", times.map(Some));
        row("pairs of images", "1/s", times.map(|time| (time > 0.0).then(|| 1e3 / time)));
        let of_both = |counter: &str, scale: f64| {
            [self.traced, self.reusing].map(|eyes| sum(eyes, counter).map(|value| value * scale))
        };
        row("rays", "millions", of_both("rays", 1e-6));
        row("read from DRAM", "MB", of_both("dram_read_bytes", 1e-6));
        row("written to DRAM", "MB", of_both("dram_write_bytes", 1e-6));
        row("energy", "mJ", of_both("energy_mj", 1.0));
        for pass in gpumodel::Pass::ALL {
            let of_pass = [self.traced, self.reusing].map(|eyes| pass_ms(eyes, pass.name()));
            if of_pass.iter().any(|&time| time > 0.0) {
                row(&format!("  {}", pass.name()), "ms", of_pass.map(Some));
            }
        }
        if let (Some(speed_up), Some(overhead)) = (self.speed_up(), self.overhead()) {
            let energy =
                self.energy_ratio().map_or(String::new(), |ratio| format!(", {ratio:.3} times the energy"));
            let _ = writeln!(
                text,
                "with reuse {speed_up:.3} times as fast{energy}; reprojection and its errors take {:.1} % of that time",
                100.0 * overhead
            );
        }
        let [_, right] = self.reusing;
        let waits = right.stack.iter().filter(|part| part.name == "DMA").map(|part| part.seconds);
        if let Some(seconds) = waits.reduce(|sum, seconds| sum + seconds) {
            let _ = writeln!(text, "of which kernels wait {} us for DMA", digits(1e6 * seconds));
        }
        text
    }
}

/// What is in internal memory while errors are detected tile by tile, as a table: width and height of tiles, columns of a row that they see, bytes in
/// internal memory, and bytes that DMA reads for them.
pub fn tile_table(rows: &[([u32; 2], u32, u64, u64)], there: u64, used: [u32; 2]) -> String {
    let mut text = format!(
        "\n{:<14} {:>14} {:>24} {:>16}\n",
        "tile", "left columns", "bytes in internal memory", "DMA reads, MB"
    );
    for &([width, height], columns, bytes, dma_bytes) in rows {
        let mark = match (bytes > there, [width, height] == used) {
            (true, _) => "  more than there is",
            (false, true) => "  as modelled",
            (false, false) => "",
        };
        let _ = writeln!(
            text,
            "{:<14} {columns:>14} {:>24} {:>16.1}{mark}",
            format!("{width}x{height}"),
            grouped(bytes),
            dma_bytes as f64 / 1e6
        );
    }
    text
}

/// A counter of both eyes; none where one of them lacks it.
fn sum(eyes: [&Report; 2], counter: &str) -> Option<f64> {
    let [left, right] = eyes.map(|report| report.counters.get(counter)?.value.as_f64());
    Some(left? + right?)
}

fn pass_ms(eyes: [&Report; 2], pass: &str) -> f64 {
    let of = |report: &Report| report.pass(pass)?.counters.get("frame_time_ms")?.value.as_f64();
    eyes.into_iter().filter_map(of).sum()
}

/// Seconds for which the busiest part of a frame's ray units works, its port, boxes or triangles; 0 without a ray unit.
pub fn ray_unit_seconds(report: &Report) -> f64 {
    let parts = report.bounds.iter().filter(|bound| bound.name.starts_with("ray unit"));
    parts.map(|bound| bound.seconds).fold(0.0, f64::max)
}
