//! Lower bounds on time, one per resource.

use crate::config::{CacheRole, Gpu};
use crate::counters::{BufferTraffic, Pass, PassCounters};

/// The least time that one resource allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The resource.
    pub name: &'static str,
    /// Seconds.
    pub seconds: f64,
}

/// Seconds that a pass needs of each resource.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    /// ALU operations issued / (cores x ALU lanes x clock).
    alu: f64,
    /// Elementary functions issued / (cores x EFU lanes x clock).
    efu: f64,
    /// Cycles of the load/store ports / (cores x clock).
    load_store: f64,
    /// Lines x line size / (copies x bytes per clock x clock), by role; caches of one role add up.
    l1: f64,
    cluster: f64,
    l2: f64,
    slc: f64,
    /// Bytes to and from DRAM / (peak x efficiency).
    dram: f64,
    /// Triangles set up / (triangles per clock x clock).
    setup: f64,
    /// Covered fragments / (pixels per clock x clock).
    pixels: f64,
    /// Little's law, see [`latency`].
    latency: f64,
}

impl Demand {
    pub(super) fn of(pass: Pass, counters: &PassCounters, resident_warps: u32, gpu: &Gpu) -> Self {
        let issue = &counters.issue;
        let core_cycles = f64::from(gpu.cores.count) * gpu.clock.hz;
        let traffic = counters.traffic.total();
        let path = match pass {
            Pass::Binning | Pass::Geometry => &gpu.paths.vertex,
            Pass::Present => &gpu.paths.texture,
            Pass::Primary | Pass::Shadow | Pass::Output => &gpu.paths.ssbo,
        };
        let mut demand = Self {
            alu: issue.alu_issued as f64 / (core_cycles * gpu.cores.alu_lanes),
            efu: issue.efu_issued as f64 / (core_cycles * gpu.cores.efu_lanes),
            load_store: issue.load_store_cycles as f64 / core_cycles,
            l1: 0.0,
            cluster: 0.0,
            l2: 0.0,
            slc: 0.0,
            dram: (issue.output_bytes + issue.bin_list_bytes) as f64 / dram_bandwidth(gpu),
            setup: issue.setup_triangles as f64 / (gpu.tiler.triangles_per_clock * gpu.clock.hz),
            pixels: issue.covered_fragments as f64 / (gpu.tiler.pixels_per_clock * gpu.clock.hz),
            latency: latency(counters, &traffic, path, resident_warps, gpu),
        };
        demand.add_traffic(&traffic, gpu);
        demand
    }

    fn add_traffic(&mut self, traffic: &BufferTraffic, gpu: &Gpu) {
        for (cache, served) in gpu.caches.iter().zip(traffic.levels) {
            let bytes = (served.accesses * cache.line_bytes) as f64;
            let bandwidth = f64::from(cache.copies) * cache.bytes_per_clock * gpu.clock.hz;
            *match cache.role {
                CacheRole::L1 => &mut self.l1,
                CacheRole::Cluster => &mut self.cluster,
                CacheRole::L2 => &mut self.l2,
                CacheRole::Slc => &mut self.slc,
            } += bytes / bandwidth;
        }
        self.dram += (traffic.dram_read_bytes + traffic.dram_write_bytes) as f64 / dram_bandwidth(gpu);
    }

    /// Adds the write-back at the end of the frame.
    pub(super) fn add_flush(&mut self, flush: &BufferTraffic, gpu: &Gpu) {
        self.add_traffic(flush, gpu);
    }

    /// One bound per resource, always in the same order.
    pub(super) fn bounds(&self) -> Vec<Bound> {
        let Self { alu, efu, load_store, l1, cluster, l2, slc, dram, setup, pixels, latency } = *self;
        [
            ("ALU issue", alu),
            ("EFU issue", efu),
            ("load/store port", load_store),
            ("L1 bandwidth", l1),
            ("cluster cache bandwidth", cluster),
            ("L2 bandwidth", l2),
            ("SLC bandwidth", slc),
            ("DRAM bandwidth", dram),
            ("triangle setup", setup),
            ("pixel rate", pixels),
            ("latency and concurrency", latency),
        ]
        .map(|(name, seconds)| Bound { name, seconds })
        .into()
    }

    /// The bounds of all passes together.
    pub(super) fn total(demands: &[Self]) -> Vec<Bound> {
        let mut total: Vec<Bound> = Vec::new();
        for bounds in demands.iter().map(Self::bounds) {
            if total.is_empty() {
                total = bounds;
                continue;
            }
            for (sum, bound) in total.iter_mut().zip(bounds) {
                sum.seconds += bound.seconds;
            }
        }
        total
    }
}

fn dram_bandwidth(gpu: &Gpu) -> f64 {
    gpu.dram.peak_bytes_per_second * gpu.dram.efficiency
}

/// Time by Little's law: the cycles of all warps, each run alone, shared out over the warps that are resident together.
///
/// A warp alone issues its ALU and load/store cycles and waits for its loads. Those of one record are in flight together: a
/// wait lasts the latency of the farthest place that any of its lines comes from. With `n` lines per wait, of which a share
/// `m` misses a level, some line misses it with probability `1 - (1 - m)^n`; misses are taken as independent.
fn latency(
    counters: &PassCounters,
    traffic: &BufferTraffic,
    path: &[usize],
    resident_warps: u32,
    gpu: &Gpu,
) -> f64 {
    let issue = &counters.issue;
    if issue.memory_waits == 0 || issue.line_accesses == 0 {
        return 0.0;
    }
    let lines = issue.line_accesses as f64;
    let lines_per_wait = lines / issue.memory_waits as f64;
    let mut wait_cycles = gpu.latency_cycles(path, 0);
    for (position, &level) in path.iter().enumerate() {
        let share = (traffic.levels[level].misses as f64 / lines).min(1.0);
        let some_line_misses = -f64::exp_m1(lines_per_wait * f64::ln_1p(-share));
        let beyond = gpu.latency_cycles(path, position + 1) - gpu.latency_cycles(path, position);
        wait_cycles += some_line_misses * beyond;
    }
    let issue_cycles = issue.alu_issued as f64 / gpu.cores.alu_lanes + issue.load_store_cycles as f64;
    let alone = issue.memory_waits as f64 * wait_cycles + issue_cycles;
    alone / (f64::from(gpu.cores.count) * f64::from(resident_warps) * gpu.clock.hz)
}
