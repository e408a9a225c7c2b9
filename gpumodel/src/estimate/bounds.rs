//! Lower bounds on time, one per resource.

use crate::config::{CacheRole, Gpu, RayUnit};
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
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Demand {
    /// ALU operations issued / (cores x ALU lanes x clock).
    pub(super) alu: f64,
    /// Elementary functions issued / (cores x EFU lanes x clock).
    pub(super) efu: f64,
    /// Cycles of the load/store ports / (cores x clock).
    pub(super) load_store: f64,
    /// Lines x line size / (copies x bytes per clock x clock), by role; caches of one role add up.
    l1: f64,
    cluster: f64,
    l2: f64,
    slc: f64,
    /// Bytes to and from DRAM / (peak x efficiency).
    dram: f64,
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
            l1: 0.0,
            cluster: 0.0,
            l2: 0.0,
            slc: 0.0,
            dram: (issue.output_bytes + issue.bin_list_bytes) as f64 / dram_bandwidth(gpu),
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

    /// What several passes need together.
    pub(super) fn sum(demands: &[Self]) -> Self {
        let mut sum = Self::default();
        for demand in demands {
            let Self {
                alu,
                efu,
                load_store,
                l1,
                cluster,
                l2,
                slc,
                dram,
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
            sum.l1 += l1;
            sum.cluster += cluster;
            sum.l2 += l2;
            sum.slc += slc;
            sum.dram += dram;
            sum.setup += setup;
            sum.pixels += pixels;
            sum.latency += latency;
        }
        sum
    }

    /// One bound per resource, always in the same order.
    pub(super) fn bounds(&self) -> Vec<Bound> {
        let Self {
            alu,
            efu,
            load_store,
            l1,
            cluster,
            l2,
            slc,
            dram,
            unit_port,
            unit_boxes,
            unit_triangles,
            atomics,
            dispatch,
            setup,
            pixels,
            latency,
        } = *self;
        [
            ("ALU issue", alu),
            ("EFU issue", efu),
            ("load/store port", load_store),
            ("L1 bandwidth", l1),
            ("cluster cache bandwidth", cluster),
            ("L2 bandwidth", l2),
            ("SLC bandwidth", slc),
            ("DRAM bandwidth", dram),
            ("ray unit: port", unit_port),
            ("ray unit: boxes", unit_boxes),
            ("ray unit: triangles", unit_triangles),
            ("atomics", atomics),
            ("dispatches", dispatch),
            ("triangle setup", setup),
            ("pixel rate", pixels),
            ("latency and concurrency", latency),
        ]
        .map(|(name, seconds)| Bound { name, seconds })
        .into()
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

fn dram_bandwidth(gpu: &Gpu) -> f64 {
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
