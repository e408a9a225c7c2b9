//! Lower bounds on time, one per resource.

use crate::config::{CacheRole, Gpu, RayUnit};
use crate::counters::{BufferTraffic, Pass, PassCounters};
use cachesim::MAX_LEVELS;

/// The least time that one resource allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The resource.
    pub name: &'static str,
    /// Seconds.
    pub seconds: f64,
}

/// Seconds that a pass needs of each resource.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Demand {
    /// ALU operations issued / (cores x ALU lanes x clock).
    pub(super) alu: f64,
    /// Elementary functions issued / (cores x EFU lanes x clock).
    pub(super) efu: f64,
    /// Cycles of the load/store ports / (cores x clock).
    pub(super) load_store: f64,
    /// By index into [`Gpu::caches`]: lines x line size / (copies x bytes per clock x clock). 0 for a ray unit's own, which its port stands for.
    caches: [f64; MAX_LEVELS],
    /// Bytes to and from DRAM / (peak x efficiency).
    dram: f64,
    /// Bytes that DMA reads ahead of kernels / (peak x efficiency).
    dma: f64,
    /// Cycles of the ray units' own ports / (cores x clock).
    pub(super) unit_port: f64,
    /// Places for rays in ray-box tests / (cores x tests per clock x clock).
    pub(super) unit_boxes: f64,
    /// As `unit_boxes`, of ray-triangle tests.
    pub(super) unit_triangles: f64,
    /// Clocks of atomics on counters / clock.
    pub(super) atomics: f64,
    /// Dispatches x the time that each takes to begin.
    pub(super) dispatch: f64,
    /// Triangles set up / (triangles per clock x clock).
    pub(super) setup: f64,
    /// Covered fragments / (pixels per clock x clock).
    pub(super) pixels: f64,
    /// Little's law: the seconds of all warps, each run alone, shared out over the warps that are resident together.
    latency: f64,
}

impl Demand {
    pub(super) fn of(pass: Pass, counters: &PassCounters, resident_warps: u32, gpu: &Gpu) -> Self {
        let issue = &counters.issue;
        let core_cycles = f64::from(gpu.cores.count) * gpu.clock.hz;
        let traffic = counters.traffic.total();
        let path = path(pass, counters, gpu);
        let of_unit = |places: u64, per_clock: fn(&RayUnit) -> f64| {
            gpu.ray_unit.as_ref().map_or(0.0, |unit| places as f64 / (core_cycles * per_clock(unit)))
        };
        let waits = waits(counters, &traffic, path, gpu);
        let unit_port_cycles = issue.unit_port_lines as f64 * gpu.unit_port_line_cycles();
        let port_cycles = issue.load_store_cycles as f64 + unit_port_cycles;
        let issue_seconds = (issue.alu_issued as f64 / gpu.cores.alu_lanes + port_cycles) / gpu.clock.hz;
        let mut demand = Self {
            alu: issue.alu_issued as f64 / (core_cycles * gpu.cores.alu_lanes),
            efu: issue.efu_issued as f64 / (core_cycles * gpu.cores.efu_lanes),
            load_store: issue.load_store_cycles as f64 / core_cycles,
            caches: [0.0; MAX_LEVELS],
            dram: (issue.output_bytes + issue.bin_list_bytes + issue.dma_write_bytes) as f64
                / dram_bandwidth(gpu),
            dma: issue.dma_read_bytes as f64 / dram_bandwidth(gpu),
            unit_port: unit_port_cycles / core_cycles,
            unit_boxes: of_unit(issue.unit_box_places, |unit| unit.boxes_per_clock),
            unit_triangles: of_unit(issue.unit_triangle_places, |unit| unit.triangles_per_clock),
            atomics: issue.atomic_clocks as f64 / gpu.clock.hz,
            dispatch: gpu.atomics.map_or(0.0, |atomics| issue.dispatches as f64 * atomics.dispatch_seconds),
            setup: issue.setup_triangles as f64 / (gpu.tiler.triangles_per_clock * gpu.clock.hz),
            pixels: issue.covered_fragments as f64 / (gpu.tiler.pixels_per_clock * gpu.clock.hz),
            latency: if waits > 0.0 {
                (waits + issue_seconds) / f64::from(gpu.cores.count * resident_warps)
            } else {
                0.0
            },
        };
        demand.add_traffic(&traffic, gpu);
        demand
    }

    fn add_traffic(&mut self, traffic: &BufferTraffic, gpu: &Gpu) {
        for (level, (cache, served)) in gpu.caches.iter().zip(traffic.levels).enumerate() {
            if gpu.through_unit_port(&[level]) {
                continue;
            }
            let bytes = (served.accesses * cache.line_bytes) as f64;
            let bandwidth = f64::from(cache.copies) * cache.bytes_per_clock * gpu.clock.hz;
            self.caches[level] += bytes / bandwidth;
        }
        self.dram += (traffic.dram_read_bytes + traffic.dram_write_bytes) as f64 / dram_bandwidth(gpu);
    }

    /// Adds the write-back at the end of the frame.
    pub(super) fn add_flush(&mut self, flush: &BufferTraffic, gpu: &Gpu) {
        self.add_traffic(flush, gpu);
    }

    /// Without what DMA reads while kernels compute.
    pub(super) fn without_dma(self) -> Self {
        Self { dma: 0.0, ..self }
    }

    /// What several passes need together.
    pub(super) fn sum(demands: &[Self]) -> Self {
        let mut sum = Self::default();
        for demand in demands {
            let Self {
                alu,
                efu,
                load_store,
                caches,
                dram,
                dma,
                unit_port,
                unit_boxes,
                unit_triangles,
                atomics,
                dispatch,
                setup,
                pixels,
                latency,
            } = *demand;
            sum.atomics += atomics;
            sum.dispatch += dispatch;
            sum.unit_port += unit_port;
            sum.unit_boxes += unit_boxes;
            sum.unit_triangles += unit_triangles;
            sum.alu += alu;
            sum.efu += efu;
            sum.load_store += load_store;
            sum.caches.iter_mut().zip(caches).for_each(|(sum, seconds)| *sum += seconds);
            sum.dram += dram;
            sum.dma += dma;
            sum.setup += setup;
            sum.pixels += pixels;
            sum.latency += latency;
        }
        sum
    }

    /// One bound per resource, always in the same order. Caches of one role have the same name, and work side by side.
    pub(super) fn bounds(&self, gpu: &Gpu) -> Vec<Bound> {
        let Self {
            alu,
            efu,
            load_store,
            caches,
            dram,
            dma,
            unit_port,
            unit_boxes,
            unit_triangles,
            atomics,
            dispatch,
            setup,
            pixels,
            latency,
        } = *self;
        let of_caches = gpu.caches.iter().zip(caches).map(|(cache, seconds)| {
            let name = match cache.role {
                CacheRole::L1 => "L1 bandwidth",
                CacheRole::Cluster => "cluster cache bandwidth",
                CacheRole::L2 => "L2 bandwidth",
                CacheRole::Slc => "SLC bandwidth",
            };
            (name, seconds)
        });
        let of_cores = [("ALU issue", alu), ("EFU issue", efu), ("load/store port", load_store)];
        let others = [
            ("DRAM bandwidth", dram + dma),
            ("ray unit: port", unit_port),
            ("ray unit: boxes", unit_boxes),
            ("ray unit: triangles", unit_triangles),
            ("atomics", atomics),
            ("dispatches", dispatch),
            ("triangle setup", setup),
            ("pixel rate", pixels),
            ("latency and concurrency", latency),
        ];
        let all = of_cores.into_iter().chain(of_caches).chain(others);
        all.map(|(name, seconds)| Bound { name, seconds }).collect()
    }
}

/// The way of a pass's loads through the caches.
pub(super) fn path<'a>(pass: Pass, counters: &PassCounters, gpu: &'a Gpu) -> &'a [usize] {
    let unit = gpu.ray_unit.as_ref().filter(|_| counters.issue.box_nodes > 0);
    match (pass, unit) {
        (Pass::Binning | Pass::Geometry, _) => &gpu.paths.vertex,
        (Pass::Present | Pass::ScreenSpace, _) => &gpu.paths.texture,
        (pass, Some(unit)) if pass.traces() => &unit.path,
        _ => &gpu.paths.ssbo,
    }
}

pub(super) fn dram_bandwidth(gpu: &Gpu) -> f64 {
    gpu.dram.peak_bytes_per_second * gpu.dram.efficiency
}

/// Seconds that all turns would wait if each of their lines came from where the phase's mean line does: at least the latency of
/// the first cache.
fn waits(counters: &PassCounters, traffic: &BufferTraffic, path: &[usize], gpu: &Gpu) -> f64 {
    let issue = &counters.issue;
    if issue.memory_waits == 0 || issue.line_requests == 0 {
        return 0.0;
    }
    let mut cycles = gpu.latency_cycles(path, 0);
    for (place, &level) in path.iter().enumerate() {
        let share = (traffic.levels[level].misses as f64 / issue.line_requests as f64).min(1.0);
        cycles += share * (gpu.latency_cycles(path, place + 1) - gpu.latency_cycles(path, place));
    }
    issue.memory_waits as f64 * cycles / gpu.clock.hz
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::largest_by_name;

    #[test]
    fn caches_of_one_role_work_side_by_side_and_a_ray_unit_s_own_is_its_port() {
        let gpu = Gpu::builtin("mali-g1-ultra").expect("it is built in").expect("it is valid");
        let [load_store, own, texture] =
            ["lsc", "rtu", "tex_l1"].map(|name| gpu.caches.iter().position(|cache| cache.name == name));
        let mut counters = PassCounters::default();
        for (level, accesses) in [(load_store, 500), (own, 4000), (texture, 3000)] {
            counters.traffic.node.levels[level.expect("it has one")].accesses = accesses;
        }
        counters.issue.unit_port_lines = 4000;
        let bounds = largest_by_name(Demand::of(Pass::Primary, &counters, 1, &gpu).bounds(&gpu));
        let cycles = |name: &str| {
            let found =
                bounds.iter().filter(|bound| bound.name == name).map(|bound| bound.seconds * 12.0 * 1e9);
            found.map(f64::round).collect::<Vec<_>>()
        };
        // A line of 64 bytes per clock in the load/store cache, four in that of textures.
        assert_eq!((cycles("L1 bandwidth"), cycles("ray unit: port")), (vec![750.0], vec![4000.0]));
    }
}
