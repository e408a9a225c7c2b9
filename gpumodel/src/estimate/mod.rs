//! From whole numbers to time and a profiler's counters.

mod assumptions;
mod bounds;
mod contention;
mod dma;
mod forced;
mod in_flight;
mod time;
mod traffic;
mod values;

pub use bounds::Bound;
pub use forced::ForcedCost;
pub use time::StackPart;
pub use traffic::{LevelTraffic, TrafficEstimate};

use crate::config::Gpu;
use crate::counters::{BufferTraffic, CounterSet, Pass, PassCounters};
use crate::energy::{EnergyPrices, FrameEnergy, PassEnergy};
use crate::error::Error;
use crate::replay::{ReplayConfig, Replayed};
use crate::windows::PhaseWindows;
use assumptions::assumptions;
use bounds::{Demand, path};
use time::{PhaseTime, Record, add, phases};
use tracer::{RayKind, Topology, TraceHeader};
use values::{FrameValues, PassValues};

/// What a frame costs.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Of the whole frame.
    pub frame: CounterSet,
    /// Of each of its passes. Their times add up to the frame's.
    pub passes: Vec<PassEstimate>,
    /// What the frame's time is made of; adds up to it.
    pub stack: Vec<StackPart>,
    /// Largest relative residual of the networks that were solved; 0 if none was.
    pub residual: f64,
    /// What the frame needs of each resource if that were the only limit.
    pub bounds: Vec<Bound>,
    /// The resource that decides the longest of the frame's phases.
    pub deciding_bound: &'static str,
    /// What each kind of buffer takes and moves; those that the frame does not touch are left out.
    pub buffers: Vec<BufferEstimate>,
    /// What each pass asks of each level of the memory system for each kind of buffer; what moves nothing is left out.
    pub traffic: Vec<TrafficEstimate>,
    /// What the frame takes by cause and by pass; `None` where the GPU's description names no process.
    pub energy: Option<FrameEnergy>,
    /// What was assumed, in sentences.
    pub assumptions: Vec<String>,
    /// What was not modelled, or not needed.
    pub left_out: Vec<LeftOut>,
    /// What was forced in or out, and what it costs or saves.
    pub forced: Vec<ForcedCost>,
}

/// What the buffers of one kind take and move, in the whole frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferEstimate {
    /// What they hold.
    pub name: &'static str,
    /// Bytes that they take.
    pub bytes: u64,
    /// Lines that loads and stores touched in the first cache of their path: distinct ones per instruction of a warp.
    pub line_accesses: u64,
    /// Lines of the last cache that were not there.
    pub line_misses: u64,
    /// Bytes read from memory.
    pub dram_read_bytes: u64,
    /// Bytes written to memory by lines that these accesses drove out, whoever wrote them.
    pub dram_write_bytes: u64,
}

/// What a pass costs.
#[derive(Clone, Debug)]
pub struct PassEstimate {
    /// Which.
    pub pass: Pass,
    /// The resource that decides the phase that it belongs to.
    pub deciding_bound: &'static str,
    /// Its counters; per-fragment values are per fragment of the frame.
    pub counters: CounterSet,
}

/// Something that a frame has and this estimate does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// Estimates the frame that `replayed` counted; `header`, `topology` and `config` are those of the replay.
///
/// The phases follow each other without overlap, and their times add up. The time of a phase is simulated where the rung is
/// [`Fidelity::Timed`](crate::Fidelity::Timed), else that of closed queueing networks, see [`crate::queueing`]; it is never below the largest of its bounds,
/// each of which is a lower bound on its own. All bounds are sums over passes, and a pass's time is its share of the resource
/// whose bound is the largest of its phase.
///
/// # Errors
/// When figures of the GPU are so far apart that its queues cannot be solved, or the table of energies does not know its process or memory.
pub fn estimate(
    replayed: &Replayed,
    header: &TraceHeader,
    topology: &Topology,
    config: &ReplayConfig,
) -> Result<Estimate, Error> {
    let counters = &replayed.counters;
    let mut demands = Pass::ALL.map(|pass| {
        let resident_warps = replayed.resident_warps[pass as usize];
        Demand::of(pass, counters.pass(pass), resident_warps, &config.gpu)
    });
    demands[config.technique.last_shading() as usize].add_flush(&counters.flush, &config.gpu);
    let mut seconds = [0.0; Pass::COUNT];
    let mut deciding = [NO_BOUND; Pass::COUNT];
    let mut longest = (0.0, NO_BOUND);
    let (mut stack, mut residual) = (Vec::new(), 0.0_f64);
    for phase in phases(&config.technique) {
        let of_phase: Vec<Demand> = phase.iter().map(|&pass| demands[pass as usize]).collect();
        let mut together = PassCounters::default();
        phase.iter().for_each(|&pass| together += *counters.pass(pass));
        let record = Record::of(replayed, phase);
        let demand = Demand::sum(&of_phase).without_dma();
        let time = PhaseTime::of((phase[0], &together), &demand, record, &config.gpu)?;
        let Some(mut time) = time else { continue };
        let exposed = dma::exposed_seconds(&together.issue, time.seconds, &config.gpu);
        time.seconds += exposed;
        add(&mut time.stack, "DMA", exposed);
        let PhaseTime { largest, place, .. } = time;
        for (&pass, demand) in phase.iter().zip(&of_phase) {
            deciding[pass as usize] = largest.name;
            let share =
                demand.bounds(&config.gpu).get(place).map_or(0.0, |bound| bound.seconds / largest.seconds);
            seconds[pass as usize] = time.seconds * share;
        }
        if time.seconds > longest.0 {
            longest = (time.seconds, largest.name);
        }
        time.stack.iter().for_each(|part| add(&mut stack, part.name, part.seconds));
        residual = residual.max(time.residual);
    }

    let prices = EnergyPrices::new(&config.energy, &config.gpu)?;
    let energy = prices.map(|prices| FrameEnergy::new(prices, replayed, config, &seconds));
    let frame = FrameValues { replayed, header, topology, config };
    let total = PassValues {
        frame: &frame,
        pass: &counters.total(),
        seconds: seconds.iter().sum(),
        energy: energy.as_ref().map(FrameEnergy::total),
        whole: true,
    };
    let of_pass = |pass: Pass| {
        let seconds = seconds[pass as usize];
        let energy: Option<PassEnergy> = energy.as_ref().map(|energy| energy.passes[pass as usize]);
        let values = PassValues { frame: &frame, pass: counters.pass(pass), seconds, energy, whole: false };
        PassEstimate { pass, deciding_bound: deciding[pass as usize], counters: values.set() }
    };
    Ok(Estimate {
        frame: total.set(),
        passes: passes(replayed, header, config).into_iter().map(of_pass).collect(),
        deciding_bound: longest.1,
        buffers: buffers(replayed, config),
        traffic: traffic::by_pass(counters, config),
        assumptions: assumptions(replayed, header, config, energy.as_ref()),
        left_out: left_out(replayed, config, energy.as_ref()),
        forced: forced::costs(&frame, &seconds),
        energy,
        stack,
        residual,
        bounds: largest_by_name(Demand::sum(&demands).bounds(&config.gpu)),
    })
}

/// One bound of each name, the largest. What a frame does not use, such as a cache without traffic, bounds nothing.
fn largest_by_name(bounds: Vec<Bound>) -> Vec<Bound> {
    let mut largest: Vec<Bound> = Vec::new();
    for bound in bounds.into_iter().filter(|bound| bound.seconds > 0.0) {
        match largest.iter_mut().find(|other| other.name == bound.name) {
            Some(other) => other.seconds = other.seconds.max(bound.seconds),
            None => largest.push(bound),
        }
    }
    largest
}

/// The passes that this frame has: those of its rays, and what its technique adds or does without them.
fn passes(replayed: &Replayed, header: &TraceHeader, config: &ReplayConfig) -> Vec<Pass> {
    let of_technique = config.technique.passes();
    let has = |pass: &Pass| match pass.rays() {
        Some(RayKind::Primary) | None => {
            let is_run = match pass {
                Pass::Binning => bins(replayed),
                // An eye has one of the two, and none where it is traced as any other image.
                Pass::ErrorDetection | Pass::Reprojection => {
                    replayed.counters.pass(*pass).issue.dispatches > 0
                }
                _ => true,
            };
            of_technique.contains(pass) && is_run
        }
        Some(kind) => has_rays(header, kind),
    };
    Pass::ALL.into_iter().filter(has).collect()
}

fn has_rays(header: &TraceHeader, kind: RayKind) -> bool {
    header.ray_sets.iter().any(|set| set.kind == kind)
}

/// Whether the frame is larger than one bin.
fn bins(replayed: &Replayed) -> bool {
    replayed.counters.pass(Pass::Binning).issue.vertices > 0
}

/// Seconds under contention of a phase that is one pass; where it touches no memory, its longest bound.
///
/// # Errors
/// As [`estimate`].
pub(crate) fn phase_seconds(
    pass: Pass,
    counters: &PassCounters,
    phases: &[PhaseWindows],
    resident_warps: u32,
    gpu: &Gpu,
) -> Result<f64, Error> {
    let demand = Demand::of(pass, counters, resident_warps, gpu);
    let windows = phases.first().map(|of| of.windows.as_slice());
    let time = PhaseTime::of((pass, counters), &demand, Record::Windows(windows), gpu)?;
    Ok(time.map_or(0.0, |time| time.seconds))
}

fn buffers(replayed: &Replayed, config: &ReplayConfig) -> Vec<BufferEstimate> {
    let [node, primitive, index, normal, stack, vertex, image, record] =
        replayed.counters.total().traffic.named();
    let bytes = &replayed.buffers;
    let paths = &config.gpu.paths;
    let total = replayed.counters.total();
    let traversal = path(Pass::Primary, &total, &config.gpu);
    let of = |(name, traffic): (_, BufferTraffic), bytes: u64, path: &[usize]| {
        let ends = path.first().zip(path.last());
        let (line_accesses, line_misses) = ends
            .map_or((0, 0), |(&first, &last)| (traffic.levels[first].accesses, traffic.levels[last].misses));
        let BufferTraffic { dram_read_bytes, dram_write_bytes, .. } = traffic;
        BufferEstimate { name, bytes, line_accesses, line_misses, dram_read_bytes, dram_write_bytes }
    };
    let all = [
        of(node, bytes.node, traversal),
        of(primitive, bytes.primitive + bytes.micromap, traversal),
        of(index, bytes.index, &paths.ssbo),
        of(normal, bytes.normal, &paths.ssbo),
        of(stack, bytes.stack, &paths.private),
        of(vertex, bytes.vertex, &paths.vertex),
        of(image, bytes.image + bytes.mask, &paths.texture),
        of(record, bytes.record, &paths.ssbo),
    ];
    all.into_iter().filter(|buffer| buffer.line_accesses > 0).collect()
}

/// Of a phase that does nothing.
const NO_BOUND: &str = "none";

fn left_out(replayed: &Replayed, config: &ReplayConfig, energy: Option<&FrameEnergy>) -> Vec<LeftOut> {
    let mut entries = vec![
        ("building the tree", "it is taken to be built before the frame"),
        ("instruction cache, command processing, display", "no figures are known for them"),
    ];
    match energy {
        None => entries.push(("energy", values::NO_PROCESS)),
        Some(_) => {
            entries.push((
                "energy of rasterisation, texture filtering, and the ray unit's stacks and control",
                "no figures are known for them",
            ));
            if replayed.timed.is_none() {
                entries.push((
                    "energy of DRAM rows opened beyond those of a stream",
                    "only --fidelity timed counts them",
                ));
            }
        }
    }
    if config.gpu.translation.is_none() {
        entries.push(("address translation", "no figures of this GPU's pages and page walks are known"));
    }
    if config.technique.raster.is_some() {
        entries.push((
            "low-resolution depth of the binning pass",
            "hidden triangles could be dropped earlier than by the early depth test",
        ));
        if !bins(replayed) {
            entries.push(("binning", "not needed: the frame fits into one bin"));
        }
    }
    entries.into_iter().map(|(what, why)| LeftOut { what: what.to_owned(), why: why.to_owned() }).collect()
}
