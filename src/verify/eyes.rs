//! What claims about two eyes measure. The metrics' definitions are in the claim file.

use crate::args::EyesArgs;
use crate::frame::Frame;
use crate::machine::Machine;
use crate::meter::Meter;
use crate::report::{Answer, Before};
use crate::two_eyes::{self, TwoEyes};
use anyhow::bail;
use gpumodel::stereo::Window;
use gpumodel::{BufferTraffic, Gpu, IssueCounters, Pass, PassCounters, Stereo};
use reports::two_eyes::ray_unit_seconds;
use tracer::reflections::GBuffer;
use tracer::stereo::{Reprojection, TraversalWork};
use tracer::{TileSource, View};

/// How the right eye is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Eyes {
    /// As any other image.
    Traced,
    /// With what it reuses of the left one.
    Reusing,
}

impl Eyes {
    /// Of the axis `eyes` of claim files.
    pub(super) fn named(name: &str) -> anyhow::Result<Self> {
        match name {
            "traced" => Ok(Self::Traced),
            "reuse" => Ok(Self::Reusing),
            _ => bail!("eyes={name}: expected traced or reuse"),
        }
    }
}

/// A metric's name and figure, or why there is none.
pub(super) type Figures = Vec<(String, Result<f64, String>)>;

/// Two eyes that see a scene, on whatever machine.
pub(super) struct Pair<'a> {
    frame: &'a Frame<'a>,
    views: [View; 2],
    known: Reprojection,
    /// Of the left and of the right eye.
    work: [TraversalWork; 2],
    hit_errors: u64,
}

impl<'a> Pair<'a> {
    pub(super) fn new(frame: &'a Frame<'a>) -> anyhow::Result<Self> {
        let views = two_eyes::eyes(&EyesArgs::default(), frame)?.views(&frame.view());
        let [width, height] = frame.size();
        let [left, right] =
            views.map(|view| GBuffer::trace(&frame.structure, frame.triangles(), view, width, height));
        let known = Reprojection::new(&left, &views[1]);
        let work = [
            TraversalWork::of(&frame.tracer_from(views[0]), None)?,
            TraversalWork::of(&frame.tracer_from(views[1]), Some(&known))?,
        ];
        let hit_errors = hit_errors(frame, views[1], &known, &right)?;
        Ok(Self { frame, views, known, work, hit_errors })
    }

    /// Figures of both ways of rendering the right eye, on a machine.
    pub(super) fn on(
        &self,
        machine: &Machine,
        before: &Before,
        meter: &Meter,
    ) -> anyhow::Result<[Figures; 2]> {
        let eyes = TwoEyes::new(self.frame, self.views, &self.known, machine, (before, meter))?;
        let gpu = &machine.config.gpu;
        let mut reusing = of_both(&eyes.reusing, gpu);
        reusing.extend(self.of_reuse(&eyes, machine));
        Ok([of_both(&eyes.traced, gpu), reusing])
    }

    fn of_reuse(&self, eyes: &TwoEyes, machine: &Machine) -> Figures {
        let mut figures = Figures::new();
        let mut say = |name: &str, figure: Option<f64>, reason: &str| {
            figures.push((name.to_owned(), figure.ok_or_else(|| reason.to_owned())));
        };
        let [answered, missing, covered] = self.known.counts().map(|count| count as f64);
        let pixels = answered + missing + covered;
        say("reused_share", Some(answered / pixels), "");
        say("hit_errors", Some(self.hit_errors as f64), "");

        let [left, right] = &self.work;
        let (whole, with_reuse) = (left.whole() + right.whole(), left.whole() + right.with_reuse());
        let speed_up = (with_reuse > 0).then(|| whole as f64 / with_reuse as f64);
        say("step_speed_up", speed_up, "no ray takes a step");
        let gap = speed_up.map(|speed_up| {
            let reusable = right.reusable as f64 / right.whole() as f64;
            (speed_up * (2.0 - reusable * answered / pixels) / 2.0 - 1.0).abs()
        });
        say("step_model_gap", gap, "no ray takes a step");

        let no_unit = "no ray unit walks the structure";
        let saving = |kept: f64, all: f64| (all > 0.0).then(|| 1.0 - kept / all);
        let unit = |answer: &Answer| ray_unit_seconds(&answer.report);
        let of_both = |answers: &[Answer; 2]| answers.iter().map(unit).sum::<f64>();
        say("unit_saving", saving(of_both(&eyes.reusing), of_both(&eyes.traced)), no_unit);
        say("right_unit_saving", saving(unit(&eyes.reusing[1]), unit(&eyes.traced[1])), no_unit);

        let [left, right] = &eyes.reusing;
        let ms = |answer: &Answer, pass: Pass| pass_figure(answer, pass, "frame_time_ms");
        let shading = (ms(right, Pass::Output) - ms(&eyes.traced[1], Pass::Output)).max(0.0);
        let errors = ms(right, Pass::ErrorDetection);
        let kernels = ms(left, Pass::Reprojection) + errors + shading;
        let seconds = left.seconds + right.seconds;
        say("kernel_share", (seconds > 0.0).then(|| kernels / (1e3 * seconds)), "it takes no time");
        say("executor_ms", Some(1e3 * right.seconds - errors), "");
        let counters = &right.replayed.counters;
        let operations = |of: fn(&IssueCounters) -> u64| {
            (of(&counters.total().issue) - of(&counters.pass(Pass::ErrorDetection).issue)) as f64
        };
        let active = operations(|issue| issue.alu_active);
        let issued = operations(|issue| issue.alu_issued);
        say("executor_simt_efficiency", (issued > 0.0).then(|| active / issued), "nothing is issued");

        let waits: f64 =
            right.report.stack.iter().filter(|part| part.name == "DMA").map(|part| 1e3 * part.seconds).sum();
        say("dma_wait_share", (errors > 0.0).then(|| waits / errors), "it takes no time");
        for (answer, pass) in
            [(left, Pass::Reprojection), (right, Pass::ErrorDetection), (right, Pass::Output)]
        {
            let bytes = record_bytes(answer.replayed.counters.pass(pass));
            say(&format!("record_bytes:{}", pass.name()), Some(bytes as f64), "");
        }
        if let Some(stereo) = &machine.config.technique.stereo {
            let there = f64::from(machine.config.gpu.tiler.tile_memory_bytes);
            let gbuffer = pixels * f64::from(stereo.fields.bytes());
            say("gbuffer_share", Some(gbuffer / there), "");
            say("window_share", Some(self.window_bytes(stereo) as f64 / there), "");
        }
        figures
    }

    fn window_bytes(&self, stereo: &Stereo) -> u64 {
        Window::of(&self.known, stereo).bytes
    }
}

/// What both eyes take together.
fn of_both(eyes: &[Answer; 2], gpu: &Gpu) -> Figures {
    let both = |figure: &dyn Fn(&Answer) -> Option<f64>| Some(figure(&eyes[0])? + figure(&eyes[1])?);
    let counter =
        |name: &'static str| both(&|answer: &Answer| answer.report.counters.get(name)?.value.as_f64());
    let seconds = eyes[0].seconds + eyes[1].seconds;
    let unit = both(&|answer| Some(1e3 * ray_unit_seconds(&answer.report)));
    let no_process = "the GPU's description names no process";
    let mut figures = Figures::new();
    let mut say = |name: &str, figure: Option<f64>, reason: &str| {
        figures.push((name.to_owned(), figure.ok_or_else(|| reason.to_owned())));
    };
    say("eyes_ms", Some(1e3 * seconds), "");
    say("pairs_per_second", (seconds > 0.0).then(|| 1.0 / seconds), "it takes no time");
    say("unit_ms", unit.filter(|&unit| unit > 0.0), "no ray unit walks the structure");
    say("eyes_energy_mj", counter("energy_mj"), no_process);
    say("unit_energy_mj", both(&|answer| unit_energy_mj(answer, gpu)), no_process);
    let dram = counter("dram_read_bytes").zip(counter("dram_write_bytes"));
    say("eyes_dram_bytes", dram.map(|(read, written)| read + written), "");
    figures
}

/// Of the tests of ray units and of their own caches.
fn unit_energy_mj(answer: &Answer, gpu: &Gpu) -> Option<f64> {
    let energy = answer.report.energy.as_ref()?;
    let own = gpu.ray_unit.as_ref().filter(|unit| unit.path.first() != gpu.paths.ssbo.first());
    let cache = own.map(|unit| format!("cache {}", gpu.caches[unit.path[0]].name));
    let of_unit = |cause: &str| cause.starts_with("ray unit") || cache.as_deref() == Some(cause);
    Some(energy.causes.iter().filter(|cause| of_unit(&cause.cause)).map(|cause| cause.mj).sum())
}

fn pass_figure(answer: &Answer, pass: Pass, counter: &str) -> f64 {
    let found = answer.report.pass(pass.name()).and_then(|pass| pass.counters.get(counter)?.value.as_f64());
    found.unwrap_or(0.0)
}

/// What moves from and to memory of buffers between the kernels.
fn record_bytes(PassCounters { issue, traffic }: &PassCounters) -> u64 {
    let BufferTraffic { dram_read_bytes, dram_write_bytes, .. } = traffic.record;
    dram_read_bytes + dram_write_bytes + issue.dma_read_bytes + issue.dma_write_bytes
}

/// Pixels that are traced one by one and hit another triangle than in `whole`, the right eye's image.
fn hit_errors(
    frame: &Frame<'_>,
    right: View,
    known: &Reprojection,
    whole: &GBuffer<'_>,
) -> anyhow::Result<u64> {
    let traced: Vec<u32> = (0..whole.pixels()).filter(|&pixel| known.left_pixel(pixel).is_none()).collect();
    let tracer = frame.tracer_of_pixels(right, traced.clone(), vec![false; traced.len()]);
    let mut errors = 0;
    let mut tile = tracer::Tile::default();
    for index in 0..tracer.header().frame.tiles() {
        tracer.trace_tile(index, &mut tile, |pixel, hit| {
            let hit = hit.is_hit().then_some(hit.primitive);
            errors += u64::from(hit != whole.triangle(pixel as u32));
        })?;
    }
    Ok(errors)
}
