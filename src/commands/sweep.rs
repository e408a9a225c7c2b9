//! `raybudget sweep`: what many frames cost that differ in their options.

use super::compare::check_there;
use crate::Outcome;
use crate::args::{Format, SweepArgs};
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::output::read_text;
use crate::report::{self, Before};
use crate::settings::start_threads;
use crate::sweep::{Plan, ReadyPoint, Store, scene_key};
use anyhow::bail;
use gpumodel::Maps;
use reports::Report;
use reports::sweep::{Figures, Sweep, SweptPoint, charts, csv_table, json, text};
use std::collections::{BTreeMap, BTreeSet};

/// Points of one traced frame that are replayed together, for each thread: a thread replays a point while others trace.
const POINTS_PER_THREAD: usize = 2;

pub(crate) fn run(args: &SweepArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let shown = args.plan.display().to_string();
    let plan = Plan::parse(&read_text(&args.plan, "a sweep (.toml)")?, &shown)?;
    let checked = ReadyPoint::all(&plan, &shown)?;
    let ready: Vec<&ReadyPoint> = checked.iter().filter_map(|point| point.as_ref().ok()).collect();
    let scenes = distinct(ready.iter().map(|point| point.scene.clone()));
    check_there(&scenes)?;
    start_threads(args.run.threads)?;
    let store = Store::open(&args.out, args.resume)?;
    let charts = plan.axes.iter().map(|axis| charts::effect_stem(&plan.axes, axis));
    store.check(charts)?;

    let mut run = Run { store: &store, meter, ids: BTreeMap::new(), failures: BTreeMap::new() };
    for scene in scenes {
        let points: Vec<&ReadyPoint> = ready.iter().copied().filter(|point| point.scene == scene).collect();
        run.scene(&scene, &points)?;
    }

    let Run { ids, failures, .. } = run;
    let options = plan.options();
    let mut points = Vec::new();
    for ((index, point), checked) in plan.points.iter().enumerate().zip(&checked) {
        let id = ids.get(&index).cloned().unwrap_or_default();
        let outcome = match (checked, failures.get(&id)) {
            (Err(reason), _) => Err(format!("not replayed, for {reason}")),
            (_, Some(reason)) => Err(reason.clone()),
            // Read again even where they were just found: a sweep that was resumed has the same bytes.
            (Ok(_), None) => {
                store.figures(&id).ok_or_else(|| "its file has gone; resume the sweep".to_owned())
            }
        };
        let values = options.iter().map(|name| point.options.get(name).map(str::to_owned)).collect();
        points.push(SweptPoint { id, values, place: point.place.clone(), outcome });
    }
    let title = args.plan.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or(shown);
    let sweep = Sweep { title, options, axes: plan.axes, objectives: plan.objectives, points };
    store.finish(&files(&sweep)?)?;
    console::print(&match args.format {
        Format::Text => text::write(&sweep, console::style()),
        Format::Json => json::write(&sweep),
        Format::Csv => csv_table::write(&sweep),
    })?;
    match failures.len() {
        0 => Ok(Outcome::Done),
        failed => bail!("{failed} points or more have no figures; the table and the warnings above say why"),
    }
}

fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    for name in names {
        if !distinct.contains(&name) {
            distinct.push(name);
        }
    }
    distinct
}

/// A sweep at work.
struct Run<'a> {
    store: &'a Store,
    meter: &'a Meter,
    /// Hashes of the inputs of points, by their number in the plan.
    ids: BTreeMap<usize, String>,
    /// Why inputs have no figures.
    failures: BTreeMap<String, String>,
}

impl Run<'_> {
    /// Replays what is not known of the points of one scene, those of the same traced frame together.
    fn scene(&mut self, spec: &str, points: &[&ReadyPoint]) -> anyhow::Result<()> {
        let scene = LoadedScene::load(spec)?;
        let key = scene_key(&scene.scene);
        let mut unknown: Vec<&ReadyPoint> = Vec::new();
        let mut seen: BTreeSet<String> = BTreeSet::new();
        for &point in points {
            let id = point.id(key);
            if seen.insert(id.clone()) && self.store.figures(&id).is_none() {
                unknown.push(point);
            }
            self.ids.insert(point.index, id);
        }
        let mut groups: Vec<Vec<&ReadyPoint>> = Vec::new();
        for point in unknown {
            match groups.iter_mut().find(|group| group[0].frame == point.frame) {
                Some(group) => group.push(point),
                None => groups.push(vec![point]),
            }
        }
        groups.iter().try_for_each(|group| self.trace(&scene, group))
    }

    /// Replays points of one traced frame, as many at once as threads are busy with.
    fn trace(&mut self, scene: &LoadedScene, points: &[&ReadyPoint]) -> anyhow::Result<()> {
        let frame = match Frame::build(scene, &points[0].settings) {
            Ok(frame) => frame,
            Err(error) => {
                points.iter().for_each(|point| self.fail(point, &error));
                return Ok(());
            }
        };
        let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
        for batch in points.chunks(POINTS_PER_THREAD * rayon::current_num_threads()) {
            let (first, last) = (batch[0].index + 1, batch[batch.len() - 1].index + 1);
            console::status(&format!("{}: points {first} to {last}", scene.scene.name));
            match self.replay(&frame, batch, &before) {
                Ok(reports) => self.keep(batch, &reports)?,
                Err(error) if batch.len() == 1 => self.fail(batch[0], &error),
                // One of them fails: which?
                Err(_) => {
                    for point in batch {
                        match self.replay(&frame, &[point], &before) {
                            Ok(reports) => self.keep(&[point], &reports)?,
                            Err(error) => self.fail(point, &error),
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn replay(
        &self,
        frame: &Frame<'_>,
        points: &[&ReadyPoint],
        before: &Before,
    ) -> anyhow::Result<Vec<Report>> {
        let machines: Vec<Machine> = points.iter().map(|point| point.machine.clone()).collect();
        let answers = report::frame_answers(frame, &machines, Maps::Dropped, before, self.meter)?;
        Ok(answers.into_iter().map(|answer| answer.report).collect())
    }

    fn keep(&self, points: &[&ReadyPoint], reports: &[Report]) -> anyhow::Result<()> {
        let keep = |(point, report): (&&ReadyPoint, &Report)| {
            self.store.keep(&Figures::of(&self.ids[&point.index], report))
        };
        points.iter().zip(reports).try_for_each(keep)
    }

    fn fail(&mut self, point: &ReadyPoint, error: &anyhow::Error) {
        console::warn(&format!("point {}: {error}", point.index + 1));
        self.failures.insert(self.ids[&point.index].clone(), error.to_string());
    }
}

/// The table, the front, and charts.
fn files(sweep: &Sweep) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("sweep.csv".to_owned(), csv_table::write(sweep).into()),
        ("columns.csv".to_owned(), csv_table::columns_text(sweep).into()),
        ("pareto.csv".to_owned(), csv_table::front_text(sweep).into()),
    ];
    // Too many scenes or values to tell apart are not drawn; the tables have them all.
    let mut picture = |stem: &str, svg: Result<String, _>, png: Result<Vec<u8>, _>| {
        if let (Ok(svg), Ok::<_, reports::Error>(png)) = (svg, png) {
            files.push((format!("{stem}.svg"), svg.into()));
            files.push((format!("{stem}.png"), png));
        }
    };
    if let Some(chart) = charts::pareto(sweep) {
        picture("pareto", chart.svg(), chart.png());
    }
    for (stem, chart) in charts::effects_of_axes(sweep) {
        picture(&stem, chart.svg(), chart.png());
    }
    Ok(files)
}
