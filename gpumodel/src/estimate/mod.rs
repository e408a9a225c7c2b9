//! From whole numbers to time and a profiler's counters.

mod bounds;
mod values;

pub use bounds::Bound;

use crate::counters::{CounterSet, FrameCounters};
use crate::replay::{ReplayConfig, Replayed};
use bounds::Demand;
use tracer::{LoopStructure, Topology, TraceHeader};
use values::{FrameValues, PassValues};

/// What a frame costs.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Of the whole frame.
    pub frame: CounterSet,
    /// Of each part of its shader. Times of the parts add up to the frame's.
    pub passes: Vec<PassEstimate>,
    /// What the frame needs of each resource if that were the only limit.
    pub bounds: Vec<Bound>,
    /// The largest of the bounds: the frame time.
    pub deciding_bound: &'static str,
    /// What was assumed, in sentences.
    pub assumptions: Vec<String>,
    /// What was not modelled.
    pub left_out: Vec<LeftOut>,
}

/// What a part of the frame costs.
#[derive(Clone, Debug)]
pub struct PassEstimate {
    /// Its name.
    pub name: String,
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
/// Frame time = the largest of the bounds, each of which is a lower bound on its own: the resources are assumed to overlap perfectly.
/// All bounds are sums over passes, so a pass's time is its share of the deciding resource.
pub fn estimate(
    replayed: &Replayed,
    header: &TraceHeader,
    topology: &Topology,
    config: &ReplayConfig,
) -> Estimate {
    let counters = &replayed.counters;
    let demand = |pass| Demand::of(pass, replayed.resident_warps, &config.gpu);
    let [primary, shadow, mut output] = counters.passes().map(demand);
    output.add_flush(&counters.flush, &config.gpu);
    let demands = [primary, shadow, output];
    let bounds = Demand::total(&demands);
    let deciding = bounds.iter().enumerate().max_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
    let (deciding, deciding_bound) = deciding.map_or((0, "none"), |(index, bound)| (index, bound.name));

    let frame = FrameValues { replayed, header, topology, config };
    let seconds = bounds.get(deciding).map_or(0.0, |bound| bound.seconds);
    let total = PassValues { frame: &frame, pass: &counters.total(), seconds, whole: true };
    let names = FrameCounters::PASSES.into_iter().zip(counters.passes()).zip(&demands);
    let passes = names.map(|((name, pass), demand)| {
        let seconds = demand.bounds().get(deciding).map_or(0.0, |bound| bound.seconds);
        let values = PassValues { frame: &frame, pass, seconds, whole: false };
        PassEstimate { name: name.to_owned(), counters: values.set() }
    });
    Estimate {
        frame: total.set(),
        passes: passes.collect(),
        deciding_bound,
        assumptions: assumptions(replayed, header, config),
        left_out: left_out(),
        // What a frame does not use, such as a cache that the GPU does not have, bounds nothing.
        bounds: bounds.into_iter().filter(|bound| bound.seconds > 0.0).collect(),
    }
}

fn assumptions(replayed: &Replayed, header: &TraceHeader, config: &ReplayConfig) -> Vec<String> {
    let gpu = &config.gpu;
    let provenance = gpu.provenance();
    let known = provenance.measured + provenance.vendor + provenance.driver;
    let loops = match header.loop_structure {
        LoopStructure::WhileWhile => "while-while: all lanes of a warp search, then all test triangles",
        LoopStructure::IfIf => "if-if: one search step, then at most one triangle, per trip",
        LoopStructure::SingleLoop => {
            "a single loop: one search step per trip, lanes in a leaf finish their triangles"
        }
    };
    let mut sentences = vec![
        format!(
            "{} figures of {} are estimates or from specification sites, {known} are measured or from its maker or driver.",
            provenance.estimate + provenance.aggregator,
            gpu.name()
        ),
        "The frame time is the largest of the bounds: resources overlap perfectly, nothing queues.".to_owned(),
        "Operation counts are taken from the formulae of the shader, every step at its full path.".to_owned(),
        "A node fetch reads the whole record in 16-byte loads.".to_owned(),
        format!("The traversal loops {loops}."),
        format!("Nodes lie in {} order.", config.node_order.name()),
        format!(
            "{} warps of {} lanes are resident per core, from an estimated register count.",
            replayed.resident_warps, gpu.cores.warp_width
        ),
        "The hit, its shading and all rays of a pixel are one fragment shader; primary rays are traced, not rasterised."
            .to_owned(),
    ];
    if header.stack_entries > 0 {
        sentences.push(format!(
            "The stack of {} entries of 8 bytes is in private memory, interleaved by lane, and passes the caches.",
            header.stack_entries
        ));
    }
    if header.short_stack > 0 {
        sentences.push(format!("The short stack of {} entries is in registers.", header.short_stack));
    }
    sentences
}

fn left_out() -> Vec<LeftOut> {
    [
        ("contention", "queueing at caches and DRAM is not in the bounds"),
        ("energy", "no energy table is applied"),
        ("building the tree", "it is taken to be built before the frame"),
        ("instruction cache, command processing, display", "no figures are known for them"),
    ]
    .map(|(what, why)| LeftOut { what: what.to_owned(), why: why.to_owned() })
    .into()
}
