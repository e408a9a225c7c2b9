//! From a source of tiles to a report, and the files that a report is written into.

use crate::console;
use crate::machine::Machine;
use crate::meter::{self, Meter, timed};
use crate::output::{OutputFile, OutputFolder};
use crate::pictures::{self, MOST_SAMPLED_PIXELS, Pictures};
use crate::progress::Progress;
use crate::reflections;
use crate::sample::Plan;
use crate::sustained::{self, Followed};
use gpumodel::energy::FrameEnergy;
use gpumodel::reflections::ReflectionMaps;
use gpumodel::{Attempt, Estimate, Goal, Maps, PrimitiveOrder, RayScheduling, Replayed, Sampled, Sampler};
use reports::lane_use::UnitOccupancy;
use reports::vendor::{Profiler, VendorView};
use reports::{
    Fidelity, Hashes, Inputs, LeftOut, Report, Run, SceneFacts, Within, csv_table, json, text, timeline,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use tracer::{
    Frame, Omission, Query, RaySample, RaySetId, Sampling, SceneRemarks, TileSource, Topology, TraceFile,
    TraceHeader,
};

/// Program and version.
pub(crate) const TOOL: &str = concat!("raybudget ", env!("CARGO_PKG_VERSION"));

/// A report with the counts behind it, and with what each pixel cost where that was kept.
pub(crate) struct Answer {
    pub(crate) report: Report,
    pub(crate) replayed: Replayed,
    /// Of a frame of reflections, where that was kept.
    pub(crate) reflections: Option<ReflectionMaps>,
    /// Of a ray unit that tests the rays of a warp together.
    pub(crate) occupancy: Option<UnitOccupancy>,
    /// Where the GPU's description names its process.
    pub(crate) energy: Option<FrameEnergy>,
    /// Time of the frame.
    pub(crate) seconds: f64,
    /// What becomes of it on a phone that warms, where that was asked.
    pub(crate) load: Option<Followed>,
    /// Of an image whose maps were kept: rays of a sample of its pixels, and their sets.
    pub(crate) rays: Option<(Arc<RaySample>, Vec<RaySetId>)>,
}

impl Answer {
    /// With what becomes of the frame on a phone.
    pub(crate) fn with_load(mut self, load: Followed) -> Self {
        self.report.assumptions.extend(load.assumptions.iter().cloned());
        self.report.sustained = Some(load.section.clone());
        Self { load: Some(load), ..self }
    }
}

/// What was measured before the replay.
#[derive(Clone, Copy)]
pub(crate) struct Before {
    pub(crate) load_s: f64,
    pub(crate) build_s: Option<f64>,
}

/// Replays all tiles and reports what they cost.
pub(crate) fn answer<S: TileSource>(
    source: &S,
    machine: &Machine,
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let mut answers = answers(source, std::slice::from_ref(machine), maps, before, meter)?;
    Ok(answers.remove(0))
}

/// Replays all tiles on every machine at once; [`answer`] for each.
pub(crate) fn answers<S: TileSource>(
    source: &S,
    machines: &[Machine],
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Vec<Answer>> {
    let header = source.header();
    let configs: Vec<_> = machines.iter().map(|machine| machine.config.clone()).collect();
    let progress = Progress::tiles("tracing and replaying", u64::from(header.frame.tiles()));
    let most = if maps == Maps::Kept { MOST_SAMPLED_PIXELS } else { 0 };
    let sampling = Sampling::new(source, most);
    let (replayed, replay_s) =
        timed(|| gpumodel::replay_all(&sampling, &configs, maps, &|done, _| progress.set(done)));
    drop(progress);
    let rays = sampling.finish().map(Arc::new);
    let of_machine = |(machine, replayed): (&Machine, Replayed)| {
        let answer = of_frame(header, source.topology(), machine, replayed, (before, replay_s), meter)?;
        let rays = rays.as_ref().map(|rays| (Arc::clone(rays), header.ray_sets.clone()));
        Ok(Answer { rays, ..answer })
    };
    machines.iter().zip(replayed?).map(of_machine).collect()
}

/// The report of a frame that was replayed as a whole, in so many seconds.
pub(crate) fn of_frame(
    header: &TraceHeader,
    topology: &Topology,
    machine: &Machine,
    replayed: Replayed,
    (before, replay_s): (&Before, f64),
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let estimate = gpumodel::estimate(&replayed, header, topology, &machine.config)?;
    let fidelity = match machine.config.fidelity {
        gpumodel::Fidelity::Replay => Fidelity::Replay,
        gpumodel::Fidelity::Timed => Fidelity::Timed,
    };
    let mut run = ran(fidelity, 1.0, before, replay_s, meter);
    run.within = Some(match fidelity {
        Fidelity::Timed => Within::simulated(),
        _ => Within::replayed(simulated(header, machine)),
    });
    let mut report = Report::new(TOOL, inputs(header, machine), facts(header, &replayed), &estimate, run);
    let images = machine.config.technique.reflections.is_none();
    if images && replayed.maps.as_ref().is_some_and(|maps| maps.wasted_slots.is_none()) {
        report.left_out.push(no_divergence_map());
    }
    let occupancy = occupancy(header, machine, &replayed);
    Ok(Answer {
        report: with_vendor(report, machine, &Profiler::all()?),
        replayed,
        reflections: None,
        occupancy,
        seconds: frame_seconds(&estimate),
        energy: estimate.energy,
        load: None,
        rays: None,
    })
}

/// Replays a scene's frame on every machine, those together that trace the same rays in the same order.
pub(crate) fn frame_answers(
    frame: &crate::frame::Frame<'_>,
    machines: &[Machine],
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Vec<Answer>> {
    let of_images =
        |machines: &[Machine]| answers(&frame.tracer_for(machines), machines, maps, before, meter);
    let of_lists = |machines: &[&Machine]| reflections::answers(frame, machines, maps, before, meter);
    by_frame(machines, of_images, of_lists)
}

/// Replays a recorded frame on every machine; where a technique has reflections, those of the trace.
pub(crate) fn trace_answers(
    trace: &TraceFile,
    machines: &[Machine],
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Vec<Answer>> {
    let of_images = |machines: &[Machine]| answers(trace, machines, maps, before, meter);
    let of_lists =
        |machines: &[&Machine]| reflections::recorded_answers(trace, machines, maps, before, meter);
    by_frame(machines, of_images, of_lists)
}

/// Answers of machines, in their order, of which some replay images and the others, whose techniques have reflections, lists of rays.
fn by_frame(
    machines: &[Machine],
    of_images: impl Fn(&[Machine]) -> anyhow::Result<Vec<Answer>>,
    of_lists: impl Fn(&[&Machine]) -> anyhow::Result<Vec<Answer>>,
) -> anyhow::Result<Vec<Answer>> {
    let (lists, images): (Vec<_>, Vec<_>) =
        (0..machines.len()).partition(|&index| machines[index].config.technique.reflections.is_some());
    let mut all: Vec<(usize, Answer)> = Vec::new();
    if !images.is_empty() {
        let machines: Vec<Machine> = images.iter().map(|&index| machines[index].clone()).collect();
        all.extend(images.into_iter().zip(of_images(&machines)?));
    }
    if !lists.is_empty() {
        let machines: Vec<&Machine> = lists.iter().map(|&index| &machines[index]).collect();
        all.extend(lists.into_iter().zip(of_lists(&machines)?));
    }
    all.sort_by_key(|&(index, _)| index);
    Ok(all.into_iter().map(|(_, answer)| answer).collect())
}

/// Samples the tiles and reports what they stand for; replays all of them where a sample is of no use.
pub(crate) fn sampled_answer<S: TileSource>(
    source: &S,
    machine: &Machine,
    plan: &Plan,
    maps: Maps,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Answer> {
    let machines = std::slice::from_ref(machine);
    let mut variants = match sample(source, machines, plan, before, meter)? {
        Sample::Variants(variants) => variants,
        Sample::Whole(reason) => {
            let mut answer = answer(source, machine, maps, before, meter)?;
            answer.report.notes.push(every_tile(&reason));
            return Ok(answer);
        }
    };
    let SampledVariant { mut answer, .. } = variants.remove(0);
    if maps == Maps::Kept {
        let why = "a sample has no figure for every pixel".to_owned();
        answer.report.left_out.push(LeftOut { what: "heat maps".to_owned(), why });
    }
    Ok(answer)
}

/// Why all tiles were replayed, in a sentence.
pub(crate) fn every_tile(reason: &str) -> String {
    format!("Every tile was replayed: {reason}.")
}

/// Of a sample that does not represent its frame.
const UNSEEN: &str =
    "the sample has not seen when most of the work is done, as some warps outlast hundreds of others";

/// What came of sampling a frame on several machines.
pub(crate) enum Sample {
    /// By machine.
    Variants(Vec<SampledVariant>),
    /// A sample is of no use, for this reason.
    Whole(String),
}

/// A machine's frame from a sample.
pub(crate) struct SampledVariant {
    pub(crate) answer: Answer,
    /// Intervals of how many times as large its counters are as those of the first machine.
    pub(crate) ratios_ci95: BTreeMap<String, [f64; 2]>,
}

/// Samples the tiles on every machine, the same for all.
pub(crate) fn sample<S: TileSource>(
    source: &S,
    machines: &[Machine],
    &Plan { ref goal, seed }: &Plan,
    before: &Before,
    meter: &Meter,
) -> anyhow::Result<Sample> {
    let whole = |reason: String| Ok(Sample::Whole(reason));
    if let Some(reason) = machines.iter().find_map(|machine| gpumodel::unsampled(&machine.config.technique)) {
        return whole(reason.to_owned());
    }
    let header = source.header();
    let profilers = Profiler::all()?;
    let configs: Vec<_> = machines.iter().map(|machine| machine.config.clone()).collect();
    let progress = Progress::spinner("sampling");
    let (attempt, replay_s) = timed(|| Sampler::new(source, &configs)?.reach(goal, seed));
    drop(progress);
    let mut notes = Vec::new();
    let sampled = match attempt? {
        Attempt::Whole(reason) => return whole(reason),
        Attempt::Sampled(sampled) => sampled,
        Attempt::TooLate(sampled) => {
            notes
                .push("The time limit was too short even for the smallest sample, which this is.".to_owned());
            sampled
        }
    };
    if !sampled.iter().all(Sampled::represents) {
        if !matches!(goal, Goal::By(_)) {
            return whole(UNSEEN.to_owned());
        }
        notes.push(format!("How far the figures are off is not known: {UNSEEN}."));
    }
    let variant = |(machine, sampled): (&Machine, &Sampled)| {
        let Sampled { replayed, estimate, intervals, tiles, .. } = sampled;
        let part = (f64::from(*tiles) / f64::from(header.frame.tiles())).min(1.0);
        let run = ran(Fidelity::Sampled, part, before, replay_s, meter);
        let mut report = Report::new(TOOL, inputs(header, machine), facts(header, replayed), estimate, run)
            .with_intervals(estimate, intervals);
        report.run.within = Some(Within::sampled(&report));
        report.inputs.seed = Some(seed);
        report.notes.extend(notes.iter().cloned());
        SampledVariant {
            answer: Answer {
                report: with_vendor(report, machine, &profilers),
                replayed: replayed.clone(),
                reflections: None,
                occupancy: occupancy(header, machine, replayed),
                seconds: frame_seconds(estimate),
                energy: estimate.energy.clone(),
                load: None,
                rays: None,
            },
            ratios_ci95: BTreeMap::new(),
        }
    };
    let mut variants: Vec<SampledVariant> = machines.iter().zip(&sampled).map(variant).collect();
    for (variant, of_variant) in variants.iter_mut().zip(&sampled).skip(1) {
        let ratios = of_variant.ratios_to(&sampled[0]).unwrap_or_default();
        let finite = ratios.into_iter().filter(|(_, ratio)| ratio.ci95.iter().all(|end| end.is_finite()));
        variant.ratios_ci95 = finite.map(|(id, ratio)| (id.to_owned(), ratio.ci95)).collect();
    }
    Ok(Sample::Variants(variants))
}

fn frame_seconds(estimate: &Estimate) -> f64 {
    estimate.stack.iter().map(|part| part.seconds).sum()
}

/// How many rays the machine's ray unit tested together, where it does so.
fn occupancy(header: &TraceHeader, machine: &Machine, replayed: &Replayed) -> Option<UnitOccupancy> {
    let gpu = &machine.config.gpu;
    let unit = gpu.ray_unit_for(header).filter(|unit| unit.scheduling == RayScheduling::Warp);
    unit.and_then(|_| UnitOccupancy::of(&replayed.counters, gpu.cores.warp_width))
}

/// What the run cost up to now.
fn ran(fidelity: Fidelity, sampled_fraction: f64, before: &Before, replay_s: f64, meter: &Meter) -> Run {
    Run {
        wall_s: meter.wall_s(),
        peak_rss_bytes: meter::peak_rss_bytes(),
        fidelity,
        sampled_fraction,
        threads: rayon::current_num_threads() as u32,
        load_s: before.load_s,
        build_s: before.build_s,
        replay_s,
        within: None,
    }
}

/// Whether the frame can be simulated event by event; otherwise why not.
fn simulated(header: &TraceHeader, machine: &Machine) -> Result<(), &'static str> {
    let config = &machine.config;
    if config.technique.reflections.is_some() {
        Err("chains of dispatches are not simulated event by event")
    } else if config.gpu.ray_unit_for(header).is_some() {
        Err("ray units are not simulated event by event")
    } else {
        Ok(())
    }
}

fn with_vendor(mut report: Report, machine: &Machine, profilers: &[Profiler]) -> Report {
    let gpu = &machine.config.gpu;
    let profiler = profilers.iter().find(|profiler| profiler.family == gpu.identity.family);
    report.vendor = profiler.map(|profiler| VendorView::new(profiler, &report, gpu));
    report
}

/// Of rays that a unit takes one by one.
pub(crate) fn no_divergence_map() -> LeftOut {
    LeftOut {
        what: "divergence map".to_owned(),
        why: "the ray unit takes each ray by itself, so that no lane waits for another".to_owned(),
    }
}

/// What the trace says of its scene, and what was noticed on the way.
fn facts(header: &TraceHeader, replayed: &Replayed) -> SceneFacts {
    let SceneRemarks { left_out, mut notes } = header.remarks.clone();
    let left_out = left_out.into_iter().map(|Omission { what, why }| LeftOut { what, why });
    let stalls = replayed.counters.stalls;
    if stalls > 0 {
        notes.push(format!("{stalls} traversals were ended by their loop bound: their hits may be wrong."));
    }
    SceneFacts { left_out: left_out.collect(), notes }
}

fn inputs(header: &TraceHeader, machine: &Machine) -> Inputs {
    let (width, height) = match header.frame {
        Frame::Image { width, height } => (Some(width), Some(height)),
        Frame::List { .. } => (None, None),
    };
    Inputs {
        scene: header.scene.clone(),
        gpu: machine.gpu_name.clone(),
        accel: header.accel.name().to_owned(),
        traversal: header.traversal.clone(),
        layout: machine.config.primitive_layout.name().to_owned(),
        technique: machine.config.technique.name.clone(),
        primitive_order: machine
            .config
            .primitive_order
            .unwrap_or_else(|| PrimitiveOrder::of(header.accel))
            .name()
            .to_owned(),
        node_records: machine.config.node_records.name().to_owned(),
        node_order: machine.config.node_order.name().to_owned(),
        ray_unit: machine.config.gpu.ray_unit_for(header).map(|unit| unit.scheduling.name().to_owned()),
        width,
        height,
        seed: None,
        hashes: Hashes {
            scene: header.scene_hash.clone(),
            gpu: machine.gpu_hash.clone(),
            costs: machine.costs_hash.clone(),
            energy: Some(machine.energy_hash.clone()),
        },
        triangles: header.triangles,
        ray_sets: of_first_sample(header).map(|set| set.kind.name().to_owned()).collect(),
        samples_per_pixel: samples_per_pixel(header),
        shadow_query: (header.shadow_query != Query::Any).then(|| header.shadow_query.name().to_owned()),
        sah_costs: header.sah_costs,
        short_stack: header.short_stack,
        trail_bits: header.trail_bits,
        node_format: header.node_format.map(|format| format.name().to_owned()),
    }
}

/// The ray sets of the first sample of each pixel.
pub(crate) fn of_first_sample(header: &TraceHeader) -> impl Iterator<Item = &RaySetId> {
    header.ray_sets.iter().filter(|set| set.sample == 0)
}

/// Samples of a pixel, where it has several of any kind of ray.
pub(crate) fn samples_per_pixel(header: &TraceHeader) -> Option<u32> {
    let samples = header.ray_sets.iter().map(|set| set.sample + 1).max();
    samples.filter(|&samples| samples > 1)
}

/// The files of a report, opened.
pub(crate) struct ReportFiles {
    // Fields drop in order: the unfinished files go before the folder that was made for them.
    text: OutputFile,
    json: OutputFile,
    csv: OutputFile,
    html: OutputFile,
    timeline: OutputFile,
    folder: OutputFolder,
}

impl ReportFiles {
    pub(crate) fn create(folder: &Path) -> anyhow::Result<Self> {
        let folder = OutputFolder::create(folder)?;
        pictures::names().iter().try_for_each(|name| folder.check(&[name]))?;
        folder.check(&sustained::FILES)?;
        Ok(Self {
            text: folder.file("report.txt")?,
            json: folder.file("report.json")?,
            csv: folder.file("counters.csv")?,
            html: folder.file("report.html")?,
            timeline: folder.file("timeline.json")?,
            folder,
        })
    }

    /// Writes all files. Of pictures those that the frame has: a list of rays has no pixels and so no heat maps.
    pub(crate) fn write(self, answer: &Answer) -> anyhow::Result<()> {
        // Bindings drop from the last to the first.
        let Self { folder, text, json, csv, html, timeline } = self;
        let Answer { report, .. } = answer;
        let wasted = pictures::wasted_by_reflections(answer);
        let pictures = Pictures::new(answer, wasted.as_deref());
        let mut ready = vec![
            text.written(text::write(report, text::Style::Plain).as_bytes())?,
            json.written(json::write(report).as_bytes())?,
            csv.written(csv_table::write(report).as_bytes())?,
            html.written(pictures.page(answer)?.as_bytes())?,
            timeline.written(timeline::write(&[("frame", report)]).as_bytes())?,
        ];
        if report.inputs.width.is_none() {
            console::warn("a list of rays has no pixels: no heat maps are written");
        }
        let of_load = match &answer.load {
            Some(load) => load.files(pictures.subtitle())?,
            None => Vec::new(),
        };
        for (name, bytes) in pictures.files()?.into_iter().chain(of_load) {
            ready.push(folder.file(&name)?.written(&bytes)?);
        }
        OutputFile::finish_all(ready)?;
        folder.keep();
        Ok(())
    }
}
