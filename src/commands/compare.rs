//! `raybudget compare`: several frames side by side, each trace made once.

use super::{is_report, read_report};
use crate::Outcome;
use crate::args::{CompareArgs, Format, FrameArgs, MachineArgs};
use crate::console;
use crate::frame::{Frame, LoadedScene};
use crate::machine::Machine;
use crate::meter::Meter;
use crate::output::OutputFolder;
use crate::pictures::{MOST_PANELS, Mapped, panels};
use crate::report::{self, Answer, Before};
use crate::settings::{FrameSettings, start_threads};
use crate::vary::{Axis, Point, Variation, meaningless};
use anyhow::bail;
use gpumodel::Maps;
use reports::chart::MatrixChart;
use reports::comparison::{self, Comparison, Variant};
use reports::{Report, html};
use std::collections::BTreeMap;
use std::path::Path;

pub(crate) fn run(args: &CompareArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let reports = args.subjects.iter().filter(|subject| is_report(Path::new(subject))).count();
    if reports > 0 {
        return of_reports(args, reports == args.subjects.len());
    }
    if args.vary.is_empty() {
        bail!(
            "compare: nothing varies; add --vary, such as --vary traversal, or give finished reports (.json)"
        );
    }
    let variations =
        args.vary.iter().map(|text| Variation::parse(text)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut points = Variation::points(&variations, &args.frame, &args.machine)?;
    let reasons: Vec<Option<&str>> = points.iter().map(meaningless).collect();
    if let Some(reason) = reasons[0].filter(|_| reasons.iter().all(Option::is_some)) {
        bail!(
            "--vary {}: no combination is left to compare, for {reason}; choose or vary another traversal",
            args.vary.join(",")
        );
    }
    for (point, reason) in points.iter().zip(&reasons).filter_map(|(point, reason)| Some((point, (*reason)?)))
    {
        console::warn(&format!("left out {}: {reason}", point.values.join(" ")));
    }
    points.retain(|point| meaningless(point).is_none());
    let groups = by_trace(&points)?;
    check_scenes(&args.subjects)?;
    start_threads(args.run.threads)?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&TABLES)?;
    }

    let several_scenes = args.subjects.len() > 1;
    let mut variants: Vec<(usize, usize, Variant)> = Vec::new();
    let mut maps: Vec<Mapped> = Vec::new();
    for (scene_index, spec) in args.subjects.iter().enumerate() {
        let scene = LoadedScene::load(spec)?;
        for group in &groups {
            console::status(&format!("{spec}: {}", group.settings.traversal.name()));
            let frame = Frame::build(&scene, &group.settings)?;
            let before = Before { load_s: scene.load_s, build_s: Some(frame.build_s) };
            let kept = if folder.is_some() { Maps::Kept } else { Maps::Dropped };
            let answers = report::frame_answers(&frame, &group.machines, kept, &before, meter)?;
            for (place, (&index, answer)) in group.points.iter().zip(answers).enumerate() {
                let Answer { report, replayed, reflections, .. } = answer;
                let scene_value = several_scenes.then(|| report.inputs.scene.clone());
                let values: Vec<String> =
                    scene_value.into_iter().chain(points[index].values.clone()).collect();
                // The machine changes few maps, one for each trace is enough; but it decides how reflections are traced.
                let differs = reflections.is_some() && points.len() <= MOST_PANELS;
                if folder.is_some() && (place == 0 || differs) {
                    let (inputs, label) = (report.inputs.clone(), values.join(" "));
                    maps.push(Mapped { inputs, label, heat: replayed.maps, reflections });
                }
                variants.push((scene_index, index, Variant { values, report, ratios_ci95: BTreeMap::new() }));
            }
        }
    }
    variants.sort_by_key(|&(scene, point, _)| (scene, point));
    let axes = several_scenes.then(|| "scene".to_owned());
    let comparison = Comparison {
        title: args.subjects.join(", "),
        axes: axes.into_iter().chain(variations.iter().map(|v| v.axis.name().to_owned())).collect(),
        variants: variants.into_iter().map(|(_, _, variant)| variant).collect(),
        remarks: Vec::new(),
    };
    if let Some(folder) = folder {
        folder.write_all(&files(&comparison, &maps, &variations)?)?;
    }
    print(&comparison, args.format)?;
    Ok(Outcome::Done)
}

/// Tables, and the page.
const TABLES: [&str; 4] = ["comparison.html", "comparison.md", "comparison.csv", "comparison.json"];

/// Finished reports, side by side.
fn of_reports(args: &CompareArgs, only: bool) -> anyhow::Result<Outcome> {
    let has_options = args.frame != FrameArgs::default() || args.machine != MachineArgs::default();
    if !only || has_options || !args.vary.is_empty() {
        bail!(
            "compare: finished reports (.json) are compared as they are; leave out scenes, --vary and options of a frame or a machine"
        );
    }
    let mut reports: Vec<(String, Report)> = Vec::new();
    for path in &args.subjects {
        if reports.iter().any(|(name, _)| name == path) {
            bail!("{path}: given twice; give each report once");
        }
        reports.push((path.clone(), read_report(Path::new(path))?));
    }
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    let comparison = Comparison::of_reports(reports);
    if let Some(folder) = folder {
        folder.write_all(&files(&comparison, &[], &[])?)?;
    }
    print(&comparison, args.format)?;
    Ok(Outcome::Done)
}

/// Refuses scenes that cannot be told from another by their names, and those that are not there.
pub(super) fn check_scenes(specs: &[String]) -> anyhow::Result<()> {
    let name = |spec: &str| Path::new(spec).file_name().map(|name| name.to_string_lossy().into_owned());
    for (index, spec) in specs.iter().enumerate() {
        if specs[..index].iter().any(|other| name(other) == name(spec)) {
            bail!("{spec}: two scenes of this name cannot be told apart; give each once, or rename one");
        }
    }
    check_there(specs)
}

/// Refuses a scene that is not there, which would else only be found after the work on those before.
pub(super) fn check_there(specs: &[String]) -> anyhow::Result<()> {
    let is_there =
        |spec: &str| scenes::BUILTINS.iter().any(|scene| scene.name == spec) || Path::new(spec).exists();
    specs.iter().filter(|spec| !is_there(spec)).try_for_each(|spec| LoadedScene::load(spec).map(drop))
}

/// Prints a comparison.
pub(super) fn print(comparison: &Comparison, format: Format) -> anyhow::Result<()> {
    console::print(&match format {
        Format::Text => comparison::text::write(comparison, console::style()),
        Format::Json => comparison::json::write(comparison),
        Format::Csv => comparison::csv_table::write(comparison),
    })
}

/// Points that share a trace.
struct Group {
    frame: FrameArgs,
    settings: FrameSettings,
    /// Of the points, in order.
    machines: Vec<Machine>,
    points: Vec<usize>,
}

fn by_trace(points: &[Point]) -> anyhow::Result<Vec<Group>> {
    let mut groups: Vec<Group> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let machine = Machine::of_whole_frames(&point.machine)?;
        match groups.iter_mut().find(|group| group.frame == point.frame) {
            Some(group) => {
                group.machines.push(machine);
                group.points.push(index);
            }
            None => groups.push(Group {
                frame: point.frame.clone(),
                settings: FrameSettings::new(&point.frame)?,
                machines: vec![machine],
                points: vec![index],
            }),
        }
    }
    Ok(groups)
}

/// Tables, charts and heat maps.
fn files(
    comparison: &Comparison,
    maps: &[Mapped],
    variations: &[Variation],
) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut drawn: Vec<html::Chart> = Vec::new();
    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("comparison.md".to_owned(), comparison::markdown::write(comparison).into()),
        ("comparison.csv".to_owned(), comparison::csv_table::write(comparison).into()),
        ("comparison.json".to_owned(), comparison::json::write(comparison).into()),
    ];
    let mut picture = |title: &str, stem: &str, svg: String, png: Vec<u8>| {
        drawn.push(html::Chart { title: title.to_owned(), svg: svg.clone() });
        files.push((format!("{stem}.svg"), svg.into_bytes()));
        files.push((format!("{stem}.png"), png));
    };
    let costs = variations.iter().position(|variation| variation.axis == Axis::CtCi);
    if let (Some(axis), [_]) = (costs, variations) {
        let scene_axes = comparison.axes.len() - variations.len();
        for (stem, chart) in cost_matrices(comparison, scene_axes + axis) {
            picture(&chart.title, &stem, chart.svg()?, chart.png()?);
        }
    }
    for (stem, chart) in comparison.charts() {
        // A comparison of many values has too many bars to draw; its tables have them all.
        if let (Ok(svg), Ok(png)) = (chart.svg(), chart.png()) {
            picture(&chart.title, &stem, svg, png);
        }
    }
    files.push(("comparison.html".to_owned(), html::comparison(comparison, &drawn).into()));
    files.extend(panels(maps)?);
    Ok(files)
}

/// Frames per second over Ct and Ci, one matrix for each scene.
fn cost_matrices(comparison: &Comparison, axis: usize) -> Vec<(String, MatrixChart)> {
    let mut scenes: Vec<&str> = Vec::new();
    let (mut xs, mut ys): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for variant in &comparison.variants {
        let Some((ct, ci)) = variant.values[axis].split_once(':') else { continue };
        for (list, value) in [(&mut xs, ct), (&mut ys, ci)] {
            if !list.iter().any(|known| known == value) {
                list.push(value.to_owned());
            }
        }
        let scene = variant.report.inputs.scene.as_str();
        if !scenes.contains(&scene) {
            scenes.push(scene);
        }
    }
    for list in [&mut xs, &mut ys] {
        list.sort_by(|a, b| a.parse::<f64>().unwrap_or(0.0).total_cmp(&b.parse().unwrap_or(0.0)));
    }
    let matrix = |scene: &str| {
        let at = |ct: &str, ci: &str| {
            let value = format!("{ct}:{ci}");
            let of_costs =
                |variant: &&Variant| variant.report.inputs.scene == scene && variant.values[axis] == value;
            comparison.variants.iter().find(of_costs)?.report.counters.get("fps")?.value.as_f64()
        };
        MatrixChart {
            title: format!("{scene}: frames per second by SAH costs"),
            subtitle: comparison.variants.first().map_or(String::new(), |variant| {
                let inputs = &variant.report.inputs;
                format!("{}, {} {}, {}", inputs.gpu, inputs.accel, inputs.traversal, inputs.technique)
            }),
            x_label: "Ct, cost of visiting a node".to_owned(),
            y_label: "Ci, cost of testing a triangle".to_owned(),
            value_label: "frames per second (1/s)".to_owned(),
            xs: xs.clone(),
            ys: ys.clone(),
            values: ys.iter().map(|ci| xs.iter().map(|ct| at(ct, ci)).collect()).collect(),
        }
    };
    let number = |index: usize| if index == 0 { String::new() } else { format!("-{}", index + 1) };
    let named = |(index, scene): (usize, &&str)| (format!("fps-by-costs{}", number(index)), matrix(scene));
    scenes.iter().enumerate().map(named).collect()
}
