//! `raybudget check`: holds the counters of frames against a budget.

use super::compare::check_there;
use super::{is_report, read_report};
use crate::Outcome;
use crate::args::{CheckArgs, CheckFormat, DEFAULT_SCENE, FrameArgs, MachineArgs, SampleArgs};
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::options::{Options, Request};
use crate::output::{OutputFile, read_text};
use crate::report::{self, Before, Sample};
use crate::sample::Plan;
use crate::settings::{FrameSettings, start_threads};
use anyhow::{anyhow, bail};
use gpumodel::{Fidelity, Maps};
use reports::Report;
use reports::budget::{self, Accepted, Baseline, Budget, Severity};
use std::path::Path;

pub(crate) fn run(args: &CheckArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let budget_text = read_text(&args.budget, "a budget file (.toml)")?;
    let budget = Budget::parse(&budget_text, &args.budget.display().to_string())?;
    let before = args.baseline.as_deref().map(Earlier::read).transpose()?.flatten();
    let subjects = subjects(args, &budget, meter)?;
    start_threads(args.run.threads)?;
    let accept = args.accept.as_deref().map(accepted_file).transpose()?;
    let count = subjects.count();
    let baseline_of = |name: &str| -> anyhow::Result<Option<Baseline>> {
        Ok(before.as_ref().map(|before| before.of(name, count)).transpose()?.flatten())
    };
    let decides = |name: &str, report: &Report| -> anyhow::Result<bool> {
        Ok(budget.check(name, report, baseline_of(name)?.as_ref())?.is_decided())
    };
    let frames = subjects.reports(&decides, meter)?;
    let mut accepted = Accepted::default();
    let mut checked = Vec::new();
    for (name, report) in &frames {
        let baseline = baseline_of(name)?;
        let mut frame = budget.check(name, report, baseline.as_ref())?;
        if before.is_some() && baseline.is_none() {
            frame
                .stale
                .push("the baseline has no such frame; its limits on changes are not compared".to_owned());
        }
        checked.push(if args.why { frame.explained(report, baseline.as_ref()) } else { frame });
        accepted.add(name, report, &budget);
    }
    let gone = before.iter().flat_map(|before| before.gone(&frames)).collect();
    let checked = budget.checked(checked, gone)?;
    if let Some(file) = accept {
        if let Some((name, _)) = frames.iter().find(|(_, report)| report.is_sampled()) {
            bail!("{name}: figures of a sample are no baseline; profile the whole frame");
        }
        file.written(accepted.text().as_bytes())?.finish()?;
    }
    for difference in checked.stale() {
        console::warn(&format!("stale baseline: {difference}"));
    }
    for (frame, row) in checked.open() {
        console::warn(&format!(
            "{}: the sample leaves open whether the limit on {} is kept; replay the whole frame",
            frame.name, row.limit.counter
        ));
    }
    console::print(&match args.format {
        CheckFormat::Text => budget::text(&checked, console::style()),
        CheckFormat::Json => budget::json_text(&checked),
        CheckFormat::Csv => budget::csv_text(&checked),
        CheckFormat::Markdown => budget::markdown(&checked),
        CheckFormat::Junit => budget::junit(&checked),
        CheckFormat::Github => budget::annotations(&checked),
    })?;
    Ok(if checked.failures(Severity::Hard) > 0 { Outcome::CheckFailed } else { Outcome::Done })
}

/// Opens the file for figures that are accepted; it takes the place of no other kind of file.
fn accepted_file(path: &Path) -> anyhow::Result<OutputFile> {
    let shown = path.display().to_string();
    if path.is_file() {
        let text = read_text(path, "figures that were accepted (.toml)")?;
        if Accepted::parse(&text, &shown).is_err() {
            bail!(
                "{shown}: this is no file of accepted figures, and would be lost; give another name to --accept"
            );
        }
    }
    OutputFile::create(path)
}

/// What is held against the budget.
enum Subjects {
    /// A finished report.
    Report(Box<Report>),
    /// Frames to profile, each with its name; of a single one that the budget does not name, the name is its scene's in the report.
    Frames(Vec<(Option<String>, Asked)>),
}

/// A frame to profile.
struct Asked {
    scene: String,
    settings: FrameSettings,
    machine: Machine,
    /// What is tried before all tiles are replayed.
    sample: Option<Plan>,
}

impl Asked {
    fn new(
        Request { scene, frame, machine }: Request,
        sample: &SampleArgs,
        meter: &Meter,
    ) -> anyhow::Result<Self> {
        let settings = FrameSettings::new(&frame)?;
        let machine = Machine::of_whole_frames(&machine)?;
        let config = &machine.config;
        let takes_samples = config.technique.reflections.is_none() && config.fidelity == Fidelity::Replay;
        let sample = if takes_samples { Plan::new(sample, &machine, meter)? } else { None };
        Ok(Self { scene, settings, machine, sample })
    }

    /// The report of a sample if it `decides` on all limits of the frame, else of all tiles.
    fn report(
        &self,
        scene: &LoadedScene,
        decides: impl Fn(&Report) -> anyhow::Result<bool>,
        meter: &Meter,
    ) -> anyhow::Result<Report> {
        let frame = Frame::build(scene, &self.settings)?;
        let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
        let machines = std::slice::from_ref(&self.machine);
        if let Some(plan) = &self.sample {
            let source = frame.tracer_for(machines);
            if let Sample::Variants(mut variants) = report::sample(&source, machines, plan, &before, meter)? {
                let report = variants.remove(0).answer.report;
                if decides(&report)? {
                    return Ok(report);
                }
            }
        }
        Ok(report::frame_answers(&frame, machines, Maps::Dropped, &before, meter)?.remove(0).report)
    }
}

/// What the command line or the budget asks for, checked before any work.
fn subjects(args: &CheckArgs, budget: &Budget, meter: &Meter) -> anyhow::Result<Subjects> {
    let sample = SampleArgs { sample: args.sample.clone(), seed: args.seed, ..SampleArgs::default() };
    let has_options = args.frame != FrameArgs::default() || args.machine != MachineArgs::default();
    if !budget.frames.is_empty() {
        if args.subject.is_some() || has_options {
            bail!(
                "{}: the budget names its frames; leave out the scene and options of a frame or a machine",
                budget.file
            );
        }
        return of_budget(budget, &sample, meter).map(Subjects::Frames);
    }
    let subject = args.subject.as_deref().unwrap_or(DEFAULT_SCENE);
    let path = Path::new(subject);
    if is_report(path) {
        if has_options {
            bail!(
                "{}: a finished report takes no options of a frame or a machine; leave them out",
                path.display()
            );
        }
        if args.sample.is_some() {
            bail!("{}: a finished report has no tiles to sample; leave out --sample", path.display());
        }
        return read_report(path).map(|report| Subjects::Report(Box::new(report)));
    }
    let request =
        Request { scene: subject.to_owned(), frame: args.frame.clone(), machine: args.machine.clone() };
    Ok(Subjects::Frames(vec![(None, Asked::new(request, &sample, meter)?)]))
}

/// The frames that the budget names.
fn of_budget(
    budget: &Budget,
    sample: &SampleArgs,
    meter: &Meter,
) -> anyhow::Result<Vec<(Option<String>, Asked)>> {
    let base = Options::read(&budget.base).map_err(|error| anyhow!("{}: base.{error}", budget.file))?;
    let frame = |frame: &budget::BudgetFrame| {
        let asked = Options::read(&frame.options)
            .and_then(|options| Asked::new(base.with(&options).request()?, sample, meter));
        let asked = asked
            .map_err(|error| anyhow!("{}:{}: frame '{}': {error}", budget.file, frame.line, frame.name))?;
        Ok((Some(frame.name.clone()), asked))
    };
    budget.frames.iter().map(frame).collect()
}

impl Subjects {
    fn count(&self) -> usize {
        match self {
            Self::Report(_) => 1,
            Self::Frames(frames) => frames.len(),
        }
    }

    /// The report of each, with its name; a scene is loaded once for all its frames. Of samples those will do that `decides`, of a
    /// frame of that name, accepts.
    fn reports(
        self,
        decides: &dyn Fn(&str, &Report) -> anyhow::Result<bool>,
        meter: &Meter,
    ) -> anyhow::Result<Vec<(String, Report)>> {
        let frames = match self {
            Self::Report(report) => return Ok(vec![(report.inputs.scene.clone(), *report)]),
            Self::Frames(frames) => frames,
        };
        let mut scenes: Vec<String> = frames.iter().map(|(_, asked)| asked.scene.clone()).collect();
        scenes.sort_unstable();
        scenes.dedup();
        check_there(&scenes)?;
        let mut reports: Vec<(usize, String, Report)> = Vec::new();
        for spec in &scenes {
            let scene = LoadedScene::load(spec)?;
            for (index, (name, asked)) in
                frames.iter().enumerate().filter(|(_, (_, asked))| asked.scene == *spec)
            {
                let called = |report: &Report| name.clone().unwrap_or_else(|| report.inputs.scene.clone());
                let report = asked.report(&scene, |report| decides(&called(report), report), meter)?;
                reports.push((index, called(&report), report));
            }
        }
        reports.sort_by_key(|&(index, ..)| index);
        Ok(reports.into_iter().map(|(_, name, report)| (name, report)).collect())
    }
}

/// What limits on changes are held against.
enum Earlier {
    Report(Box<Report>),
    Accepted(Accepted),
}

impl Earlier {
    /// `None`, with a warning, where there is no such file: the first run of a check has none.
    fn read(path: &Path) -> anyhow::Result<Option<Self>> {
        if !path.exists() {
            console::warn(&format!(
                "{}: there is no such baseline; limits on changes are not compared. To make one: raybudget check --accept",
                path.display()
            ));
            return Ok(None);
        }
        if path.extension().is_some_and(|extension| extension == "toml") {
            let text = read_text(path, "figures that were accepted (.toml)")?;
            return Ok(Some(Self::Accepted(Accepted::parse(&text, &path.display().to_string())?)));
        }
        Ok(Some(Self::Report(Box::new(read_report(path)?))))
    }

    /// The baseline of a frame, of so many: the one of its name, or of a single frame the only one.
    fn of(&self, name: &str, frames: usize) -> anyhow::Result<Option<Baseline>> {
        match self {
            Self::Report(report) if frames == 1 => Ok(Some(Baseline::Report(report.clone()))),
            Self::Report(_) => bail!(
                "a report is the baseline of one frame, and there are {frames}; give figures that were accepted (.toml)"
            ),
            Self::Accepted(accepted) => {
                let only = if frames == 1 { accepted.only() } else { None };
                let found = accepted.frame(name).or(only);
                Ok(found.map(|frame| Baseline::Accepted(Box::new(frame.clone()))))
            }
        }
    }

    /// Frames that only the baseline has, in sentences.
    fn gone(&self, frames: &[(String, Report)]) -> Vec<String> {
        match self {
            Self::Accepted(accepted) if frames.len() > 1 || accepted.only().is_none() => {
                let gone = accepted.names().filter(|name| frames.iter().all(|(known, _)| known != name));
                gone.map(|name| format!("the baseline has a frame '{name}', the budget has none")).collect()
            }
            _ => Vec::new(),
        }
    }
}
