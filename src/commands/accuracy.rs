//! `raybudget verify accuracy`: the default rung of fidelity held against the simulated one.

use super::compare::check_scenes;
use crate::Outcome;
use crate::args::{AccuracyArgs, Format};
use crate::console;
use crate::meter::{self, Meter};
use crate::output::OutputFolder;
use crate::report::TOOL;
use crate::settings::start_threads;
use crate::verify::accuracy::{self as measure, OURS, REFERENCE, Rungs, Walk};
use reports::accuracy::{self, Accuracy, LIMITS};
use reports::text::Style;
use serde_json::json;

/// Those that the limits were found on. They ask for primary and shadow rays alone.
const SCENES: [&str; 6] = ["cornell", "teapot", "stadium", "figure", "atrium", "soup"];

/// What is measured unless something else is asked for.
struct Defaults {
    scenes: Vec<&'static str>,
    traversals: &'static [&'static str],
    gpus: &'static [&'static str],
    size: &'static str,
}

impl Defaults {
    fn whole() -> Self {
        Self {
            scenes: SCENES.to_vec(),
            traversals: &["bvh-parent-link", "bvh-restart-trail", "kd-push-down", "kd-backtrack"],
            gpus: &["adreno-540", "adreno-640", "mali-g78", "mali-g715"],
            size: "256x256",
        }
    }

    fn quick() -> Self {
        Self {
            scenes: vec!["cornell", "teapot"],
            traversals: &["bvh-parent-link", "kd-backtrack"],
            gpus: &["adreno-540", "mali-g715"],
            size: "128x128",
        }
    }
}

pub(super) fn run(args: &AccuracyArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    if args.samples {
        return super::sampling::run(args, meter);
    }
    let defaults = if args.quick { Defaults::quick() } else { Defaults::whole() };
    let scenes = given_or(&args.scene, &defaults.scenes);
    let size = args.size.as_deref().unwrap_or(defaults.size);
    let walks = given_or(&args.traversal, defaults.traversals)
        .iter()
        .map(|name| Walk::named(name, size))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let gpus = given_or(&args.gpu, defaults.gpus)
        .iter()
        .map(|name| Rungs::of(name))
        .collect::<anyhow::Result<Vec<_>>>()?;
    check_scenes(&scenes)?;
    start_threads(args.run.threads)?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["accuracy.txt", "accuracy.json", "accuracy.csv"])?;
    }

    let accuracy = Accuracy {
        ours: OURS.name().to_owned(),
        reference: REFERENCE.name().to_owned(),
        points: measure::all(&scenes, &walks, &gpus)?,
        limits: LIMITS,
    };
    let run = json!({
        "tool": TOOL,
        "image": size,
        "traces": scenes.len() * walks.len(),
        "replays": 2 * accuracy.points.len(),
        "threads": rayon::current_num_threads(),
        "wall_s": meter.wall_s(),
        "peak_rss_bytes": meter::peak_rss_bytes(),
    });
    let footer = format!(
        "{} frames of {size}, each on both rungs, in {:.0} s of wall time on {} threads.\n",
        accuracy.points.len(),
        meter.wall_s(),
        rayon::current_num_threads()
    );
    let text = |style: Style| format!("{}{footer}", accuracy::text(&accuracy, style));
    let (json, csv) = (accuracy::json_text(&accuracy, &run), accuracy::csv_text(&accuracy));
    if let Some(folder) = folder {
        let mut files: Vec<(String, Vec<u8>)> = vec![
            ("accuracy.txt".to_owned(), text(Style::Plain).into()),
            ("accuracy.json".to_owned(), json.clone().into()),
            ("accuracy.csv".to_owned(), csv.clone().into()),
        ];
        let (matrix, bars) = accuracy::charts(&accuracy, &format!("frames of {size}"));
        files.push(("errors.svg".to_owned(), matrix.svg()?.into()));
        files.push(("errors.png".to_owned(), matrix.png()?));
        if let Some(bars) = bars {
            files.push(("mean-errors.svg".to_owned(), bars.svg()?.into()));
            files.push(("mean-errors.png".to_owned(), bars.png()?));
        }
        folder.write_all(&files)?;
    }
    console::print(&match args.format {
        Format::Text => text(console::style()),
        Format::Json => json,
        Format::Csv => csv,
    })?;
    Ok(Outcome::Done)
}

/// What was given, each once, or else the defaults.
pub(super) fn given_or(given: &[String], defaults: &[&str]) -> Vec<String> {
    if given.is_empty() {
        return defaults.iter().map(|&name| name.to_owned()).collect();
    }
    let mut names: Vec<String> = Vec::new();
    for name in given {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}
