//! From whole numbers to time and a profiler's counters.

mod bounds;
mod contention;
mod forced;
mod in_flight;
mod time;
mod values;

pub use bounds::Bound;
pub use forced::ForcedCost;
pub use time::StackPart;

use crate::config::{Attachments, Gpu, RayScheduling, Stage, has_secondary};
use crate::counters::{BufferTraffic, CounterSet, Pass, PassCounters, TrafficCounters};
use crate::error::Error;
use crate::layout::{NodeRecords, PrimitiveOrder};
use crate::replay::{Fidelity, ReplayConfig, Replayed};
use crate::windows::PhaseWindows;
use bounds::{Demand, path};
use time::{PhaseTime, Record, add, phases};
use tracer::{Accel, LoopStructure, RayKind, Topology, TraceHeader};
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
/// [`Fidelity::Timed`], else that of closed queueing networks, see [`crate::queueing`]; it is never below the largest of its bounds,
/// each of which is a lower bound on its own. All bounds are sums over passes, and a pass's time is its share of the resource
/// whose bound is the largest of its phase.
///
/// # Errors
/// When figures of the GPU are so far apart that its queues cannot be solved.
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
        let time = PhaseTime::of((phase[0], &together), &Demand::sum(&of_phase), record, &config.gpu)?;
        let Some(time) = time else { continue };
        let PhaseTime { largest, place, .. } = time;
        for (&pass, demand) in phase.iter().zip(&of_phase) {
            deciding[pass as usize] = largest.name;
            let share = demand.bounds().get(place).map_or(0.0, |bound| bound.seconds / largest.seconds);
            seconds[pass as usize] = time.seconds * share;
        }
        if time.seconds > longest.0 {
            longest = (time.seconds, largest.name);
        }
        time.stack.iter().for_each(|part| add(&mut stack, part.name, part.seconds));
        residual = residual.max(time.residual);
    }

    let frame = FrameValues { replayed, header, topology, config };
    let total =
        PassValues { frame: &frame, pass: &counters.total(), seconds: seconds.iter().sum(), whole: true };
    let of_pass = |pass: Pass| {
        let seconds = seconds[pass as usize];
        let values = PassValues { frame: &frame, pass: counters.pass(pass), seconds, whole: false };
        PassEstimate { pass, deciding_bound: deciding[pass as usize], counters: values.set() }
    };
    Ok(Estimate {
        frame: total.set(),
        passes: passes(replayed, header, config).into_iter().map(of_pass).collect(),
        deciding_bound: longest.1,
        buffers: buffers(replayed, config),
        assumptions: assumptions(replayed, header, config),
        left_out: left_out(replayed, config),
        forced: forced::costs(&frame, &seconds),
        // What a frame does not use, such as a cache that the GPU does not have, bounds nothing.
        stack,
        residual,
        bounds: Demand::sum(&demands).bounds().into_iter().filter(|bound| bound.seconds > 0.0).collect(),
    })
}

/// The passes that this frame has: those of its rays, and what its technique adds or does without them.
fn passes(replayed: &Replayed, header: &TraceHeader, config: &ReplayConfig) -> Vec<Pass> {
    let of_technique = config.technique.passes();
    let has = |pass: &Pass| match pass.rays() {
        Some(RayKind::Primary) | None => {
            of_technique.contains(pass) && (*pass != Pass::Binning || bins(replayed))
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
    let TrafficCounters { node, primitive, index, normal, stack, vertex, image, record } =
        replayed.counters.total().traffic;
    let bytes = &replayed.buffers;
    let paths = &config.gpu.paths;
    let total = replayed.counters.total();
    let traversal = path(Pass::Primary, &total, &config.gpu);
    let of = |name, bytes: u64, traffic: BufferTraffic, path: &[usize]| {
        let ends = path.first().zip(path.last());
        let (line_accesses, line_misses) = ends
            .map_or((0, 0), |(&first, &last)| (traffic.levels[first].accesses, traffic.levels[last].misses));
        let BufferTraffic { dram_read_bytes, dram_write_bytes, .. } = traffic;
        BufferEstimate { name, bytes, line_accesses, line_misses, dram_read_bytes, dram_write_bytes }
    };
    let all = [
        of("nodes", bytes.node, node, traversal),
        of("triangles", bytes.primitive, primitive, traversal),
        of("triangle indices", bytes.index, index, &paths.ssbo),
        of("normals", bytes.normal, normal, &paths.ssbo),
        of("stacks", bytes.stack, stack, &paths.private),
        of("vertices", bytes.vertex, vertex, &paths.vertex),
        of("images", bytes.image, image, &paths.texture),
        of("records", bytes.record, record, &paths.ssbo),
    ];
    all.into_iter().filter(|buffer| buffer.line_accesses > 0).collect()
}

/// Bits of the trail in `docs/shaders/bvh-restart-trail.glsl`.
const COMPILED_TRAIL_BITS: u32 = 32;

/// Of a phase that does nothing.
const NO_BOUND: &str = "none";

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
        match config.fidelity {
            Fidelity::Replay => "Time comes from queues: the warps of a core take turns at its ALU, EFU and load/store port, and all cores at \
                                 shared caches and memory, by what each 256th of the frame asks of them on average; phases follow each other."
                .to_owned(),
            Fidelity::Timed => "Time is simulated event by event; instructions of a warp follow each other without a gap, and a turn computes \
                                without interruption; fixed-function units enter by their rates; phases follow each other."
                .to_owned(),
        },
        "Operation counts are those of the cost table, every step at its full path; the built-in table counts what a compiler made of the \
         shaders for the Adreno 540.".to_owned(),
        "A node fetch reads the whole record in 16-byte loads.".to_owned(),
        format!("The traversal loops {loops}."),
        format!("Nodes lie in {} order.", config.node_order.name()),
        format!(
            "{} warps of {} lanes are resident per core, from the register count of the cost table.",
            replayed.resident_warps[Pass::Output as usize],
            gpu.cores.warp_width
        ),
    ];
    sentences.extend(technique_assumptions(header, config));
    match config.node_records {
        NodeRecords::Packed => {}
        NodeRecords::Padded => {
            sentences.push("Node records are padded to a power of two bytes.".to_owned());
        }
        NodeRecords::ChildBoxes => sentences.push(
            "A node record of 64 bytes holds the boxes of both children; leaves have none, and the root's box is a constant."
                .to_owned(),
        ),
    }
    match config.primitive_order.unwrap_or_else(|| PrimitiveOrder::of(header.accel)) {
        PrimitiveOrder::Leaf => sentences.push("Triangles lie in the order of the leaves.".to_owned()),
        PrimitiveOrder::Indexed => {
            sentences.push("Triangles lie in file order and are found through an index list.".to_owned());
        }
    }
    if let Some(unit) = gpu.ray_unit_for(header) {
        let together = match unit.scheduling {
            RayScheduling::Warp => {
                format!("the rays of a warp that are at one node together, {} at a time", unit.rays_together)
            }
            RayScheduling::Ray => "each ray by itself".to_owned(),
        };
        let estimated = gpu.estimates().iter().any(|key| key.starts_with("ray_unit."));
        sentences.push(format!(
            "A ray unit of each core walks the structure and keeps the stacks; it tests {together}, {} boxes or {} triangles per clock{}.",
            unit.boxes_per_clock,
            unit.triangles_per_clock,
            if estimated { ", of which some figures are estimates" } else { "" }
        ));
        sentences.push(
            "A ray in the unit takes one step, then at most one triangle, before the next step of any ray of its warp; what it reads holds the \
             load/store port for a cycle per line."
                .to_owned(),
        );
    } else if header.stack_entries > 0 {
        sentences.push(format!(
            "The stack of {} entries of 8 bytes is in private memory, interleaved by lane, and passes the caches.",
            header.stack_entries
        ));
    }
    if header.short_stack > 0 {
        sentences.push(format!("The short stack of {} entries is in registers.", header.short_stack));
    }
    if header.trail_bits.is_some_and(|bits| bits > COMPILED_TRAIL_BITS) {
        sentences.push(format!(
            "The built-in operation counts and registers are those of a trail of {COMPILED_TRAIL_BITS} bits, the only one that was compiled: \
             a longer one costs more."
        ));
    }
    if !header.normals {
        sentences.push(
            "Triangles have no normals, so records of all layouts are 48 bytes; shading reads their vertices and is charged as with normals, \
             since no shader of it was compiled."
                .to_owned(),
        );
    }
    if header.accel == Accel::TwoLevel {
        sentences.push(
            "Records of instances, 128 bytes each, lie behind the TLAS, and each BLAS begins at a multiple of 256 bytes; a ray reads 64 bytes of \
             an instance's record."
                .to_owned(),
        );
        let estimates = config.costs.two_level_estimates();
        if gpu.ray_unit_for(header).is_some() {
            sentences.push(
                "The ray unit transforms rays at no cost of its own, and walks a binary TLAS, as the trace has it.".to_owned(),
            );
        } else if !estimates.is_empty() {
            sentences.push(format!(
                "Estimated figures of the cost table, for two levels: {}.",
                estimates.join(", ")
            ));
        }
    }
    if has_secondary(header) {
        let estimates = config.costs.secondary_estimates();
        if !estimates.is_empty() {
            sentences.push(format!(
                "Estimated operation counts of the cost table, for rays that start at a hit: {}.",
                estimates.join(", ")
            ));
        }
        sentences.push(
            "All rays of a pixel are one shader, set after set; its registers are those of a shader of primary and hard shadow rays, the \
             only one that was compiled. What reflection and diffuse rays hit is shaded as primary hits are."
                .to_owned(),
        );
    }
    if !has_rays(header, RayKind::Shadow) && !has_secondary(header) {
        sentences.push(
            "The built-in register counts are those of a shader that also traces shadow rays; none without was compiled.".to_owned(),
        );
    }
    sentences
}

fn technique_assumptions(header: &TraceHeader, config: &ReplayConfig) -> Vec<String> {
    let mut sentences = Vec::new();
    let estimates = config.technique.estimates();
    if !estimates.is_empty() {
        sentences.push(format!("Estimated figures of the technique: {}.", estimates.join(", ")));
    }
    match config.technique.stage {
        Stage::Fragment if config.technique.raster.is_none() => sentences.push(
            "The hit, its shading and all rays of a pixel are one fragment shader; primary rays are traced, not rasterised."
                .to_owned(),
        ),
        Stage::Fragment => {}
        Stage::Compute { workgroup: [width, height] } => sentences.push(format!(
            "A compute shader in workgroups of {width}x{height} traces and writes an image of 4 bytes per pixel, 4x4 pixels side by side; a \
             full-screen quad reads it as a texture."
        )),
    }
    if let Some(raster) = config.technique.raster {
        sentences.push(format!(
            "The geometry is drawn without back-face culling, as three vertices of {} bytes per triangle: positions once for binning, all \
             again for every bin that a triangle touches; early depth test in file order.",
            raster.vertex_stride(header.normals)
        ));
        sentences.push(
            "All bins are rasterised before the first shadow ray; the GPU goes bin by bin, which moves the same bytes.".to_owned(),
        );
        sentences.push(match raster.attachments {
            Attachments::Tile => {
                "Normal and depth, 4 bytes per pixel each, stay in tile memory and are read back by framebuffer fetch.".to_owned()
            }
            Attachments::Memory => {
                "Normal and depth, 4 bytes per pixel each, are written to DRAM and read as textures.".to_owned()
            }
        });
    }
    sentences
}

fn left_out(replayed: &Replayed, config: &ReplayConfig) -> Vec<LeftOut> {
    let mut entries = vec![
        ("energy", "no energy table is applied"),
        ("building the tree", "it is taken to be built before the frame"),
        ("instruction cache, command processing, display", "no figures are known for them"),
    ];
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
