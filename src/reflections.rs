//! Frames of reflections: what each machine's technique makes of the rays of one G-buffer, or of those that a trace has kept.

use crate::frame::Frame;
use crate::machine::Machine;
use crate::meter::{Meter, timed};
use crate::progress::Progress;
use crate::report::{Answer, Before, no_divergence_map, of_frame};
use anyhow::bail;
use gpumodel::reflections::{ListTracer, ReflectionFrame, ReplayedReflections, Shadows, replay_reflections};
use gpumodel::{Maps, QueryOrigin, Reflections as Technique, ScreenSpace};
use reports::LeftOut;
use scenes::{Scene, Vec3};
use tracer::reflections::{
    GBuffer, March, Outcome, RecordedReflections, ReflectionList, ReflectionSettings, Reflections,
};
use tracer::{Aabb, Omission, ReflectionRecord, SceneRemarks, TileSource, Topology, TraceFile};

/// Left out where a pipeline's shadow rays are sent by hit shaders.
const HIT_QUERIES: [&str; 2] = [
    "divergence of ray queries in hit shaders",
    "shadow rays of a warp are traced together, as if its closest-hit shaders met for that",
];

/// Shaders of a scene whose triangles all have one material.
const ASSIGNED_SHADERS: u32 = 32;
/// Cells of the scene's box along each axis, whose triangles are given one shader.
const CELLS: f32 = 8.0;

/// What other frames leave out of a scene, and these do not.
const MODELLED: [&str; 1] = ["several_materials"];

/// What these frames leave out.
fn omissions() -> [Omission; 2] {
    [
        ("the G-buffer", "it is in memory, from a pass before: depth, normal, roughness and colour"),
        ("the pyramid of depths", "a renderer that has one for other effects makes it before"),
    ]
    .map(|(what, why)| Omission { what: what.to_owned(), why: why.to_owned() })
}

/// What decides which rays are left for ray queries, and where they start.
type Rays = (ScreenSpace, QueryOrigin);

/// Reports of one frame on machines whose techniques have reflections.
pub(crate) fn answers(
    frame: &Frame<'_>,
    machines: &[&Machine],
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Vec<Answer>> {
    let Some(surfaces) = frame.reflecting() else {
        bail!(
            "{}: no surface is smooth enough to reflect; add --force mirror or --force glossy, or choose another technique",
            frame.scene().name
        );
    };
    let gbuffer = {
        let _progress = Progress::spinner("tracing the G-buffer");
        let [width, height] = frame.size();
        GBuffer::trace(&frame.structure, frame.triangles(), frame.view(), width, height)
    };
    let topology = frame.structure.topology();
    let bounds = bounds(frame);
    let march = |(screen_space, origin): Rays| {
        let march = match screen_space {
            ScreenSpace::None => None,
            ScreenSpace::Linear => Some(March::LINEAR),
            ScreenSpace::Hierarchical => Some(March::HIERARCHICAL),
        };
        let origin = match origin {
            QueryOrigin::Surface => tracer::reflections::QueryOrigin::Surface,
            QueryOrigin::LastPosition => tracer::reflections::QueryOrigin::LastFree,
        };
        let seed = frame.reflection_seed();
        Reflections::new(&gbuffer, ReflectionSettings { surfaces: &surfaces, seed, march, origin })
    };
    let mut marched: Vec<(Rays, Reflections<'_>)> = Vec::new();
    let mut answers = Vec::new();
    for machine in machines {
        let Some(technique) = &machine.config.technique.reflections else { continue };
        let _progress = Progress::spinner("marching, tracing and replaying");
        let rays = (technique.screen_space, technique.query_origin);
        let (shaders, materials_note) =
            shaders(frame.scene(), frame.triangles(), &bounds, technique.materials);
        let (replayed, seconds) = timed(|| {
            let known = marched.iter().position(|(others, _)| *others == rays);
            let place = known.unwrap_or_else(|| {
                marched.push((rays, march(rays)));
                marched.len() - 1
            });
            let reflections = &marched[place].1;
            let list =
                |order: Vec<u32>, shadows: Shadows| -> Result<Box<dyn ReflectionList>, tracer::Error> {
                    let lights = if shadows == Shadows::Traced { frame.hit_lights() } else { Vec::new() };
                    Ok(Box::new(frame.reflection_tracer(reflections.rays(), order, lights)?))
                };
            let list: &ListTracer<'_> = &list;
            let of = ReflectionFrame { reflections, list, shaders: &shaders, bounds };
            replay_reflections(&of, &machine.config, maps)
                .map(|replayed| (replayed, coverage_note(reflections.outcomes())))
        });
        let (replayed, coverage) = replayed?;
        let notes = [coverage, materials_note];
        let remarks = frame.remarks(false);
        answers.push(answer(replayed, (remarks, notes), &topology, machine, (before, seconds), meter)?);
    }
    Ok(answers)
}

/// Reports of the reflections of a trace on machines whose techniques have some: those that leave all rays to ray queries from their surfaces.
pub(crate) fn recorded_answers(
    trace: &TraceFile,
    machines: &[&Machine],
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Vec<Answer>> {
    let recorded = {
        let _progress = Progress::spinner("reading reflection rays");
        RecordedReflections::read(trace)?
    };
    let header = trace.header();
    let Some(record) = &header.reflections else { return Ok(Vec::new()) };
    let [min, max] = record.bounds.map(Vec3::from_array);
    let reflections = recorded.reflections();
    let list = |order: Vec<u32>, shadows: Shadows| -> Result<Box<dyn ReflectionList>, tracer::Error> {
        Ok(Box::new(recorded.list(order, shadows == Shadows::Traced)?))
    };
    let list: &ListTracer<'_> = &list;
    let frame = ReflectionFrame { reflections, list, shaders: trace.shaders(), bounds: Aabb { min, max } };
    let mut answers = Vec::new();
    for machine in machines {
        let asked = machine.config.technique.reflections.as_ref().and_then(|technique| technique.materials);
        if let Some(materials) = asked {
            bail!(
                "--materials {materials}: the trace has told which shader each triangle has; profile the scene for other ones"
            );
        }
        let _progress = Progress::spinner("replaying");
        let (replayed, seconds) = timed(|| replay_reflections(&frame, &machine.config, maps));
        let notes = [coverage_note(reflections.outcomes()), record.shaders.clone()];
        let remarks = header.remarks.clone();
        let topology = trace.topology();
        answers.push(answer(replayed?, (remarks, notes), topology, machine, (before, seconds), meter)?);
    }
    Ok(answers)
}

/// What a trace keeps of a frame's reflections, if it has any, and the shader of each of its triangles.
pub(crate) fn record(frame: &Frame<'_>) -> Option<(ReflectionRecord, Vec<u32>)> {
    frame.reflecting()?;
    let bounds = bounds(frame);
    let (shaders, note) = shaders(frame.scene(), frame.triangles(), &bounds, None);
    let bounds = [bounds.min.to_array(), bounds.max.to_array()];
    Some((ReflectionRecord { bounds, shaders: note }, shaders))
}

fn bounds(frame: &Frame<'_>) -> Aabb {
    frame.triangles().iter().map(Aabb::of_triangle).fold(Aabb::EMPTY, Aabb::union)
}

fn answer(
    ReplayedReflections { replayed, mut header, maps }: ReplayedReflections,
    (remarks, notes): (SceneRemarks, [String; 2]),
    topology: &Topology,
    machine: &Machine,
    (before, seconds): (&Before, f64),
    meter: &Meter,
) -> anyhow::Result<Answer> {
    header.remarks = remarks;
    header.remarks.left_out.retain(|entry| !MODELLED.contains(&entry.what.as_str()));
    header.remarks.left_out.extend(omissions());
    header.remarks.notes.extend(notes);
    let technique = machine.config.technique.reflections.as_ref();
    if technique.is_some_and(Technique::sends_hit_queries) {
        let [what, why] = HIT_QUERIES.map(str::to_owned);
        header.remarks.left_out.push(Omission { what, why });
    }
    if maps.as_ref().is_some_and(|maps| maps.lane_slots.is_none()) {
        let LeftOut { what, why } = no_divergence_map();
        header.remarks.left_out.push(Omission { what, why });
    }
    let answer = of_frame(&header, topology, machine, replayed, (before, seconds), meter)?;
    Ok(Answer { reflections: maps, ..answer })
}

/// By triangle, the shader of its material or, where so many are `asked` for, one of these by its place, and what a report says of it.
fn shaders(
    scene: &Scene,
    triangles: &[scenes::Triangle],
    bounds: &Aabb,
    asked: Option<u32>,
) -> (Vec<u32>, String) {
    let meshes = scene.instances.iter().map(|instance| &scene.meshes[instance.mesh as usize]);
    let own: Vec<u32> = meshes.flat_map(|mesh| mesh.materials.iter().copied()).collect();
    if asked.is_none() && own.iter().any(|&material| material != own[0]) {
        return (own, "Every material has its own shader.".to_owned());
    }
    let shaders = asked.unwrap_or(ASSIGNED_SHADERS);
    let extent = bounds.extent().max(Vec3::splat(f32::MIN_POSITIVE));
    let shader = |triangle: &scenes::Triangle| {
        let middle = (triangle.v[0] + triangle.v[1] + triangle.v[2]) / 3.0;
        let cell = ((middle - bounds.min) / extent * CELLS).floor().min(Vec3::splat(CELLS - 1.0));
        // Three primes: neighbours differ, and which shaders meet says nothing of the scene.
        let [x, y, z] = cell.to_array().map(|cell| cell as u32);
        (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791)) % shaders
    };
    let note = format!(
        "{}: for reflections its box was cut into {CELLS}x{CELLS}x{CELLS} cells, and the triangles of each were given one of \
         {shaders} shaders by a hash of the cell.",
        if asked.is_some() { "The scene's materials were replaced" } else { "The scene has one material" }
    );
    (triangles.iter().map(shader).collect(), note)
}

/// Which part of the image is what.
fn coverage_note(outcomes: &[Outcome]) -> String {
    let share = |of: fn(&Outcome) -> bool| {
        100.0 * outcomes.iter().filter(|outcome| of(outcome)).count() as f64 / outcomes.len() as f64
    };
    format!(
        "Of the pixels, the screen answers {:.1} % and ray queries {:.1} %; {:.1} % are too rough to reflect, and {:.1} % are sky.",
        share(|outcome| matches!(outcome, Outcome::ScreenHit { .. })),
        share(|outcome| *outcome == Outcome::Query),
        share(|outcome| *outcome == Outcome::Fallback),
        share(|outcome| *outcome == Outcome::Sky),
    )
}
