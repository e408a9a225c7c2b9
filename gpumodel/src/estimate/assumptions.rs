//! What an estimate assumes, in sentences.

use super::has_rays;
use crate::config::{
    Atomics, Attachments, HitShading, Launch, RayPipeline, RayScheduling, RayUnit, Reflections, Stage,
    Stereo, Tag, has_secondary,
};
use crate::counters::Pass;
use crate::energy::{FrameEnergy, Supply};
use crate::layout::{Instances, NodeRecords, PrimitiveOrder};
use crate::reflections::pipeline::{Binding, Pipeline};
use crate::replay::{Fidelity, ReplayConfig, Replayed};
use tracer::{Accel, AlphaMode, AlphaTests, LoopStructure, MicromapFormat, NodeFetch, RayKind, TraceHeader};

/// Bits of the trail in `docs/shaders/bvh-restart-trail.glsl`.
const COMPILED_TRAIL_BITS: u32 = 32;

pub(super) fn assumptions(
    replayed: &Replayed,
    header: &TraceHeader,
    config: &ReplayConfig,
    energy: Option<&FrameEnergy>,
) -> Vec<String> {
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
        resident(replayed, config),
    ];
    sentences.extend(technique_assumptions(replayed, header, config));
    sentences.extend(energy.map(energy_assumption));
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
    if gpu.ray_unit_for(header).is_none()
        && let Some(unit) = &gpu.ray_unit
    {
        let needs = if unit.walks() {
            "walks wide BVHs alone, of one or two levels: --accel wide-bvh, or --accel two-level with --node-format"
        } else {
            "is an instruction that tests nodes of adreno-8 and gives no distances: --accel wide-bvh or two-level with --traversal short-stack"
        };
        sentences.push(format!("The ray unit of the GPU has no part in it: it {needs}."));
    }
    if let Some(unit) = gpu.ray_unit_for(header) {
        let together = match unit.scheduling {
            RayScheduling::Warp => {
                format!("the rays of a warp that are at one node together, {} at a time", unit.rays_together)
            }
            RayScheduling::Ray | RayScheduling::Instruction => "each ray by itself".to_owned(),
        };
        let estimated = gpu.estimates().iter().any(|key| key.starts_with("ray_unit."));
        let part = if unit.walks() {
            "walks the structure and keeps the stacks; it tests"
        } else {
            "reads and tests a node or a triangle at an instruction of the shader, which walks and keeps the stack;"
        };
        sentences.push(format!(
            "A ray unit of each core {part} {together}, {} boxes or {} triangles per clock{}.",
            unit.boxes_per_clock,
            unit.triangles_per_clock,
            if estimated { ", of which some figures are estimates" } else { "" }
        ));
        sentences.push(if unit.walks() {
            "A ray in the unit takes one step, then at most one triangle, before the next step of any ray of its warp; what it reads holds the \
             load/store port for a cycle per line."
                .to_owned()
        } else {
            "Lanes at nodes and lanes at triangles issue the instruction one after the other; what it reads holds the load/store port for a cycle per \
             line. A parent link that is read where the stack has lost entries is no access."
                .to_owned()
        });
        let estimates = config.costs.ray_intersection_estimates();
        if !unit.walks() && !estimates.is_empty() {
            sentences.push(format!(
                "Estimated figures of the cost table, for the shader around the instruction: {}.",
                estimates.join(", ")
            ));
        }
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
    if let Some(alpha) = &header.alpha {
        sentences.extend(alpha_assumptions(alpha, replayed, header, config));
    }
    if header.accel == Accel::TwoLevel {
        sentences.extend(level_assumptions(header, config));
    }
    if has_secondary(header) {
        let estimates = config.costs.secondary_estimates();
        if !estimates.is_empty() {
            sentences.push(format!(
                "Estimated operation counts of the cost table, for rays that start at a hit: {}.",
                estimates.join(", ")
            ));
        }
        if config.technique.reflections.is_none() {
            sentences.push(
            "All rays of a pixel are one shader, set after set; its registers are those of a shader of primary and hard shadow rays, the \
             only one that was compiled. What reflection and diffuse rays hit is shaded as primary hits are."
                .to_owned(),
        );
        }
    }
    if !has_rays(header, RayKind::Shadow) && !has_secondary(header) {
        sentences.push(
            "The built-in register counts are those of a shader that also traces shadow rays; none without was compiled.".to_owned(),
        );
    }
    sentences
}

fn technique_assumptions(replayed: &Replayed, header: &TraceHeader, config: &ReplayConfig) -> Vec<String> {
    let mut sentences = Vec::new();
    let estimates = config.technique.estimates();
    if !estimates.is_empty() {
        sentences.push(format!("Estimated figures of the technique: {}.", estimates.join(", ")));
    }
    if let Some(reflections) = &config.technique.reflections {
        sentences.extend(reflections_assumptions(reflections, config));
        sentences.extend(pipeline_assumptions(reflections, replayed, config));
        return sentences;
    }
    if let Some(stereo) = config.technique.stereo.as_ref().filter(|_| is_of_two_eyes(replayed)) {
        sentences.extend(stereo_assumptions(stereo, config));
    }
    match config.technique.stage {
        Stage::Fragment if config.technique.raster.is_none() => sentences.push(
            "The hit, its shading and all rays of a pixel are one fragment shader; primary rays are traced, not rasterised."
                .to_owned(),
        ),
        Stage::Fragment => {}
        Stage::Compute { workgroup: [width, height] } if config.technique.present.is_none() => {
            sentences.push(format!(
                "A compute shader in workgroups of {width}x{height} traces; its colours stay in tiles until these are written out."
            ));
        }
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

/// Whether kernels between two eyes were run, and it is not an image like any other.
fn is_of_two_eyes(replayed: &Replayed) -> bool {
    let dispatches = |pass: Pass| replayed.counters.pass(pass).issue.dispatches;
    dispatches(Pass::Reprojection) + dispatches(Pass::ErrorDetection) > 0
}

fn stereo_assumptions(stereo: &Stereo, config: &ReplayConfig) -> Vec<String> {
    let [width, height] = stereo.tile;
    let bytes = stereo.fields.bytes();
    let mut sentences = vec![
        format!(
            "Each eye begins with cold caches. Of a pixel, the G-buffer has {bytes} bytes. Reprojection errors are detected in tiles of {width}x{height} pixels, in whose rows \
             all left pixels are tested that can land there, and those beside them."
        ),
        match stereo.gbuffer {
            Attachments::Tile => {
                "The G-buffer and the lists of pixels stay in internal memory, in which all cores work on one tile, and the left eye is so far ahead of the right one; what \
                 the row test needs is written to DRAM, and read back by DMA one tile ahead."
            }
            Attachments::Memory => "The G-buffer of the left image and the lists of pixels are in memory, each field by itself.",
        }
        .to_owned(),
        "Other rays from a pixel that the left eye answers than reflections, and what they found, are reused with it; its reflections start from what the right eye sees \
         there.".to_owned(),
    ];
    let estimates = config.costs.stereo_estimates();
    if !estimates.is_empty() {
        let keys = estimates.join(", ");
        sentences.push(format!("Estimated figures of the cost table, for two eyes: {keys}."));
    }
    sentences
}

fn reflections_assumptions(reflections: &Reflections, config: &ReplayConfig) -> Vec<String> {
    let [width, height] = reflections.workgroup;
    let mut sentences = vec![
        format!(
            "Compute shaders in workgroups of {width}x{height} lanes read a G-buffer that is in memory; images have 4 bytes per pixel, 4x4 pixels \
             side by side."
        ),
        "Hits are shaded by their materials, of which every second one has a specular part; no texture is read.".to_owned(),
    ];
    if let Some(Atomics { lane_clocks, warp_clocks, joins_uniform, dispatch_seconds, .. }) =
        config.gpu.atomics
    {
        let joined = if joins_uniform { "those of a warp on one address as one" } else { "lane by lane" };
        sentences.push(format!(
            "Dispatches follow each other, each {:.3} us after the one that it waits for; those of different materials do not wait for each other. \
             Atomics go to the cache that all cores share, {joined}, at {lane_clocks} clocks each and {warp_clocks} per instruction; barriers of a \
             workgroup cost nothing but the wait for its last warp.",
            dispatch_seconds * 1e6
        ));
    }
    if reflections.launch == Launch::Buffer {
        sentences.push(
            "Warps reach the counter of the list in the order in which they end their marches, each alone on its core: that is the order of the list."
                .to_owned(),
        );
    }
    sentences.extend((!config.costs.reflection_estimates().is_empty()).then(|| {
        let keys = config.costs.reflection_estimates().join(", ");
        format!("Estimated operation counts of the cost table, for passes of reflections: {keys}.")
    }));
    sentences
}

fn pipeline_assumptions(
    reflections: &Reflections,
    replayed: &Replayed,
    config: &ReplayConfig,
) -> Vec<String> {
    let of_pipeline = config.costs.reflections().and_then(|costs| {
        Pipeline::of(reflections, &config.gpu, costs.pipeline, replayed.counters.materials)
    });
    let Some(pipeline) = of_pipeline else { return Vec::new() };
    let why = match config.gpu.ray_pipeline {
        _ if reflections.hit_shading == HitShading::PipelineLibrary => {
            "as they come from libraries".to_owned()
        }
        None => "as nothing is known of what its driver links".to_owned(),
        Some(RayPipeline { linked_shaders, inlined_shaders, .. }) => {
            format!("as the driver links up to {linked_shaders} and inlines up to {inlined_shaders}")
        }
    };
    let bound = match pipeline.binding {
        Binding::Linked => format!(
            "are one shader, {why}: a switch that costs what an uber shader does, and the read of a shader record of each ray"
        ),
        Binding::Called => format!(
            "are called, {why}: ray generation keeps what it needs in stack memory, called shaders save registers there and leave the payload of {} bytes there",
            pipeline.payload_bytes
        ),
    };
    let mut sentences =
        vec![format!("The {} shaders of the ray-tracing pipeline {bound}.", pipeline.shaders)];
    if config.gpu.emulates(&config.technique) {
        sentences.push(
            "Hit shaders send ray queries, so the driver has shaders walk all rays of the pipeline, without the ray unit."
                .to_owned(),
        );
    }
    sentences
}

/// How many warps a core holds: of the frame's shader, or of that of each pass.
fn resident(replayed: &Replayed, config: &ReplayConfig) -> String {
    let width = config.gpu.cores.warp_width;
    let by_pass = &replayed.resident_warps;
    let number = if config.technique.reflections.is_none() {
        by_pass[Pass::Output as usize].to_string()
    } else {
        let named = |pass: Pass| format!("{} ({})", by_pass[pass as usize], pass.name());
        config.technique.passes().into_iter().map(named).collect::<Vec<_>>().join(", ")
    };
    format!(
        "{number} warps of {width} lanes are resident per core, from the register count of the cost table."
    )
}

fn alpha_assumptions(
    alpha: &AlphaTests,
    replayed: &Replayed,
    header: &TraceHeader,
    config: &ReplayConfig,
) -> Vec<String> {
    let count = alpha.tested.count(header.triangles);
    let how = match alpha.mode {
        AlphaMode::AnyHit => {
            "an any-hit shader decides about their hits, and all other triangles are marked opaque"
        }
        AlphaMode::Unmarked => {
            "no triangle is marked opaque, so an any-hit shader decides about every hit that is closer than those before"
        }
        AlphaMode::Opaque => "rays take all triangles as opaque",
        AlphaMode::Cull => "rays pass through them",
        AlphaMode::Micromap => {
            "opacity micromaps decide about their hits where they can, and an any-hit shader elsewhere"
        }
    };
    let mut sentences = vec![format!(
        "{count} of {} triangles are alpha-tested, by three opaque posts and the gaps between them along an edge, as no image is read: {how}.",
        header.triangles
    )];
    if config.technique.raster.is_some() && alpha.mode != AlphaMode::Opaque {
        sentences.push(
            "The rasteriser draws alpha-tested triangles whole, as an early depth test cannot.".to_owned(),
        );
    }
    if !alpha.run_shaders() {
        return sentences;
    }
    if let Some(MicromapFormat { level, states }) = alpha.micromap {
        sentences.push(format!(
            "Micromaps of level {level} and {} states take {} bytes among the triangles; shaders read and decode them, as drivers for Mali have them do \
             (Calvo Lista 2026): no unit described here reads them.",
            states.name(),
            replayed.buffers.micromap
        ));
    }
    match config.gpu.ray_unit_for(header) {
        Some(RayUnit { return_cycles: Some(cycles), .. }) => sentences.push(format!(
            "A ray with such a hit leaves the unit; its warp goes on when all of its rays have one or are done, and is away for {cycles} cycles."
        )),
        Some(_) => sentences.push("Lanes with such a hit wait until all of their warp have one or are done.".to_owned()),
        None => sentences.push("Such a hit is decided about in the loop over triangles.".to_owned()),
    }
    let estimates = config.costs.alpha_estimates();
    if !estimates.is_empty() {
        sentences
            .push(format!("Estimated figures of the cost table, for alpha tests: {}.", estimates.join(", ")));
    }
    sentences
}

fn level_assumptions(header: &TraceHeader, config: &ReplayConfig) -> Vec<String> {
    let Instances { layout, leaf_bytes, read_bytes } = Instances::of(header);
    let read_bytes = leaf_bytes + read_bytes;
    let layout = format!(
        "Records of instances, {} bytes each, lie behind the TLAS, and each BLAS begins at a multiple of 256 bytes; a ray reads \
         {read_bytes} bytes of an instance's record.",
        layout.bytes
    );
    let cost = if config.gpu.ray_unit_for(header).is_some_and(RayUnit::walks) {
        let tlas = match (header.node_fetch, header.node_format) {
            (NodeFetch::Pair, Some(_)) => ", and walks a binary TLAS, as the trace has it",
            _ => "",
        };
        Some(format!("The ray unit transforms rays at no cost of its own{tlas}."))
    } else {
        let costs = config.costs.two_level(header, &config.gpu).ok().flatten();
        costs.filter(|costs| !costs.estimates.is_empty()).map(|costs| {
            format!("Estimated figures of the cost table, for two levels: {}.", costs.estimates.join(", "))
        })
    };
    std::iter::once(layout).chain(cost).collect()
}

fn energy_assumption(energy: &FrameEnergy) -> String {
    let prices = &energy.prices;
    let origin = match prices.supply() {
        Supply::OperatingPoints(_) => "as its operating points have it at its clock",
        Supply::Process(_) => {
            "the reference voltage of the process at any clock, as its description gives no other"
        }
    };
    let estimated = energy.causes.iter().filter(|cause| cause.tag == Tag::Estimate).count();
    format!(
        "Energy is that of a chip in {} at {:.3} V, {origin}, and {} degrees Celsius; {estimated} of its {} causes rest on estimates. Boundaries: unit, arithmetic alone; \
         array, memory cells with their periphery; core, a shader core; GPU, all of it; DRAM rails, the devices' supplies; PHY rail, the interface's; \
         whole path, devices, interface and controller.",
        prices.process(),
        prices.supply().volts(),
        prices.leakage().reference_celsius(),
        energy.causes.len(),
    )
}
