//! A small frame on GPUs with figures at the ends of their ranges.

use crate::Size;
use crate::case::{Case, Limit};
use crate::structures::Watch;
use gpumodel::{
    EnergyTable, Estimate, Fidelity, GPUS, Gpu, Maps, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig,
    Replayed, ShaderCosts, Technique, Value, estimate, replay, replay_all,
};
use scenes::{Light, Triangle};
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Rays, SceneIdentity, TileSource, Traversal, View,
};

/// How well time under contention is known: the wait for a free place in flight is bracketed to a part in a million.
const CONTENTION: f64 = 2e-6;

/// By how much a faster figure may lengthen a frame since warps come in another order: as far as the order of warps changes
/// DRAM bytes between the rungs.
const ANOTHER_ORDER: f64 = 0.08;

/// A scene with a structure.
pub(super) struct Traced {
    scene: scenes::Scene,
    triangles: Vec<Triangle>,
    structure: AccelerationStructure,
}

impl Traced {
    pub(super) fn new() -> Self {
        let scene = scenes::load("cornell").expect("it is built in");
        let triangles = scene.triangles();
        let options = BuildOptions::default();
        let structure =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &options).expect("it is finite");
        Self { scene, triangles, structure }
    }

    /// A tracer of an image of `side` x `side` pixels.
    pub(super) fn frame(&self, side: u32) -> FrameTracer<'_> {
        let rays = Rays::View { view: View::new(&self.scene.camera, side, side), width: side, height: side };
        let lights = self.scene.lights.iter().map(|Light::Point { position }| *position).collect();
        let identity = SceneIdentity { name: self.scene.name.clone(), hash: 0 };
        FrameTracer::new(&self.structure, &BuildOptions::default(), &self.triangles, identity, rays, lights)
    }
}

/// A GPU with the plainest layouts.
pub(super) fn config(gpu: Gpu, fidelity: Fidelity) -> ReplayConfig {
    ReplayConfig {
        gpu,
        costs: ShaderCosts::builtin().expect("they are built in"),
        energy: EnergyTable::builtin().expect("it is built in"),
        technique: Technique::builtin("fragment").expect("it is built in").expect("it is sound"),
        primitive_layout: PrimitiveLayout::Padded,
        primitive_order: None,
        node_records: NodeRecords::Packed,
        node_order: NodeOrder::DepthFirst,
        fidelity,
        keeps_misses: false,
    }
}

pub(super) fn gpu(name: &str) -> Gpu {
    Gpu::builtin(name).expect("it is built in").expect("it is sound")
}

/// Seconds of the frame.
pub(super) fn seconds(estimate: &Estimate) -> f64 {
    estimate.frame.get("frame_time_ms").and_then(Value::number).unwrap_or(f64::NAN) * 1e-3
}

pub(super) fn estimated(frame: &FrameTracer<'_>, replayed: &Replayed, config: &ReplayConfig) -> Estimate {
    estimate(replayed, frame.header(), frame.topology(), config).expect("the figures are within their limits")
}

/// The estimate of each configuration.
fn all(frame: &FrameTracer<'_>, configs: &[ReplayConfig]) -> Vec<Estimate> {
    let replayed = replay_all(frame, configs, Maps::Dropped, &|_, _| ()).expect("the frame can be replayed");
    replayed.iter().zip(configs).map(|(replayed, config)| estimated(frame, replayed, config)).collect()
}

pub(crate) fn cases(size: Size, _: &Watch) -> Vec<Case> {
    let traced = Traced::new();
    let frame = traced.frame(size.of(32, 64));
    let mut cases: Vec<Case> = FIGURES.iter().flat_map(|figure| swept(&frame, figure)).collect();
    cases.extend(rescaled(&frame));
    cases.extend(threads(&traced));
    cases
}

/// A figure of a GPU.
struct Figure {
    id: &'static str,
    about: &'static str,
    /// Lowest and highest value that a description may give, in the unit of the description.
    range: [f64; 2],
    /// More of it is faster.
    faster: bool,
    set: fn(&mut Gpu, f64),
}

const FIGURES: [Figure; 7] = [
    Figure {
        id: "clock",
        about: "clock in MHz",
        range: [1e-6, 1e7],
        faster: true,
        set: |gpu, mhz| gpu.clock.hz = mhz * 1e6,
    },
    Figure {
        id: "memory-bandwidth",
        about: "bandwidth of memory in GB/s",
        range: [1e-9, 1e7],
        faster: true,
        set: |gpu, gbs| gpu.dram.peak_bytes_per_second = gbs * 1e9,
    },
    Figure {
        id: "memory-latency",
        about: "latency of memory in ns",
        range: [1e-9, 1e9],
        faster: false,
        set: |gpu, ns| gpu.dram.latency_seconds = ns * 1e-9,
    },
    Figure {
        id: "cache-bandwidth",
        about: "bytes per clock of every cache",
        range: [1e-9, 1e9],
        faster: true,
        set: |gpu, bytes| gpu.caches.iter_mut().for_each(|cache| cache.bytes_per_clock = bytes),
    },
    Figure {
        id: "cache-latency",
        about: "cycles of latency of every cache",
        range: [1e-9, 1e9],
        faster: false,
        set: |gpu, cycles| gpu.caches.iter_mut().for_each(|cache| cache.latency_cycles = cycles),
    },
    Figure {
        id: "alu",
        about: "ALU lanes",
        range: [1e-9, 1e9],
        faster: true,
        set: |gpu, lanes| gpu.cores.alu_lanes = lanes,
    },
    Figure {
        id: "efu",
        about: "elementary function lanes",
        range: [1e-9, 1e9],
        faster: true,
        set: |gpu, lanes| gpu.cores.efu_lanes = lanes,
    },
];

/// Every half decade of a figure's range: times are finite, and of one replay none is longer than that with a slower figure.
///
/// A replay of its own for each figure need not keep that: warps come in another order then, so other lines miss. By how much a
/// faster figure can lengthen the frame in this way is measured too.
fn swept(frame: &FrameTracer<'_>, figure: &Figure) -> [Case; 2] {
    let [low, high] = figure.range;
    let steps = (2.0 * (high / low).log10()).round() as i32;
    let values: Vec<f64> = (0..=steps).map(|step| low * 10.0_f64.powf(0.5 * f64::from(step))).collect();
    let mut configs: Vec<ReplayConfig> = values
        .iter()
        .map(|&value| {
            let mut gpu = gpu("adreno-540");
            (figure.set)(&mut gpu, value);
            config(gpu, Fidelity::Replay)
        })
        .collect();
    if !figure.faster {
        configs.reverse();
    }
    let described = config(gpu("adreno-540"), Fidelity::Replay);
    let once = replay(frame, &described, Maps::Dropped, &|_, _| ()).expect("the frame can be replayed");
    let of_one: Vec<Estimate> = configs.iter().map(|config| estimated(frame, &once, config)).collect();
    let of_each = all(frame, &configs);
    let case = |id: String, statement: String, limit: f64, found: &[Estimate]| {
        let residual = found.iter().map(|estimate| estimate.residual).fold(0.0, f64::max);
        let times: Vec<f64> = found.iter().map(seconds).collect();
        let odd = times.iter().filter(|time| !(time.is_finite() && **time > 0.0)).count();
        let slower = times.windows(2).map(|pair| pair[1] / pair[0] - 1.0).fold(0.0, f64::max);
        let (longest, shortest) = (times[0], times[times.len() - 1]);
        let found = if odd > 0 { f64::NAN } else { slower };
        Case::new(id, statement, "relative rise", Limit::AtMost(limit), found)
            .under("longest over shortest time", longest / shortest)
            .with_residual(residual)
            .because(format!(
                "{} times, {odd} that are no positive number, {shortest:.2e} to {longest:.2e} s",
                times.len()
            ))
    };
    let range = format!("{} from {low:e} to {high:e}", figure.about);
    [
        case(
            format!("frames/{}", figure.id),
            format!("{range}, one replay: no faster figure gives a longer frame"),
            CONTENTION,
            &of_one,
        ),
        case(
            format!("frames/{}/order", figure.id),
            format!("{range}, each replayed: another order of warps makes up for little of a faster figure"),
            ANOTHER_ORDER,
            &of_each,
        ),
    ]
}

/// Twice the clock and all bandwidths, half of all latencies: half the time.
fn rescaled(frame: &FrameTracer<'_>) -> [Case; 2] {
    let names: Vec<&str> = GPUS.iter().map(|gpu| gpu.name).collect();
    let plain: Vec<ReplayConfig> = names.iter().map(|name| config(gpu(name), Fidelity::Replay)).collect();
    let fast: Vec<ReplayConfig> = plain
        .iter()
        .map(|plain| {
            let mut fast = plain.clone();
            fast.gpu.clock.hz *= 2.0;
            fast.gpu.dram.peak_bytes_per_second *= 2.0;
            fast.gpu.dram.latency_seconds *= 0.5;
            fast.gpu.dram.row_open_seconds *= 0.5;
            fast.gpu.dram.row_cycle_seconds *= 0.5;
            if let Some(translation) = &mut fast.gpu.translation {
                translation.walk_seconds *= 0.5;
            }
            fast
        })
        .collect();
    let (before, after) = (all(frame, &plain), all(frame, &fast));
    let (mut worst, mut parts, mut residual) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (before, after) in before.iter().zip(&after) {
        worst = worst.max((2.0 * seconds(after) / seconds(before) - 1.0).abs());
        let sum: f64 = before.stack.iter().map(|part| part.seconds).sum();
        parts = parts.max((sum / seconds(before) - 1.0).abs());
        residual = residual.max(before.residual).max(after.residual);
    }
    let of = format!("{} GPUs", names.len());
    [
        Case::new(
            "frames/rescaled",
            "twice the clock and all bandwidths and half of all latencies give half the time",
            "relative error",
            Limit::AtMost(1e-12),
            worst,
        )
        .with_residual(residual)
        .because(&of),
        Case::new(
            "frames/parts",
            "what the time is made of adds up to the time",
            "relative error",
            Limit::AtMost(1e-12),
            parts,
        )
        .with_residual(residual)
        .because(of),
    ]
}

/// A structure, a replay and an estimate on one thread and on several.
fn threads(traced: &Traced) -> Vec<Case> {
    let counts = [1, 2, 3, 5];
    Fidelity::ALL
        .into_iter()
        .map(|fidelity| {
            let run = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.expect("threads can be started").install(|| {
                    let traced = Traced::new();
                    let frame = traced.frame(72);
                    let config = config(gpu("adreno-540"), fidelity);
                    let replayed =
                        replay(&frame, &config, Maps::Kept, &|_, _| ()).expect("it can be replayed");
                    let estimate = estimated(&frame, &replayed, &config);
                    format!("{:?}{replayed:?}{estimate:?}", frame.topology())
                })
            };
            let first = run(1);
            let differing = counts[1..].iter().filter(|&&threads| run(threads) != first).count();
            let of = traced.triangles.len();
            Case::none_of(
                format!("frames/threads/{}", fidelity.name()),
                format!(
                    "tree, counts and times on the rung '{}' are the same bytes on {counts:?} threads",
                    fidelity.name()
                ),
                "differing runs",
                differing as u64,
            )
            .because(format!("{of} triangles, {} bytes compared", first.len()))
        })
        .collect()
}
