//! `raybudget verify accuracy --samples`: samples of frames held against their replays.

use super::accuracy::given_or;
use super::compare::check_scenes;
use crate::Outcome;
use crate::args::{AccuracyArgs, Format, FrameArgs, MachineArgs};
use crate::console;
use crate::machine::Machine;
use crate::meter::{self, Meter};
use crate::output::OutputFolder;
use crate::report::TOOL;
use crate::sample::fraction;
use crate::settings::start_threads;
use crate::verify::accuracy::Walk;

use crate::vary::Variation;
use crate::verify::sampling::{self as measure, Case};
use anyhow::bail;
use reports::sampling::{self, LIMITS, Sampling};
use reports::text::Style;
use serde_json::json;

/// What is measured unless something else is asked for.
struct Defaults {
    scene: &'static str,
    size: &'static str,
    parts: &'static [&'static str],
    seeds: u32,
    changes: &'static [&'static str],
}

const WHOLE: Defaults = Defaults {
    scene: "soup",
    size: "1024x1024",
    parts: &["6%", "7.5%", "12%", "25%"],
    seeds: 20,
    changes: &["layout=split", "node-order=breadth-first"],
};
const QUICK: Defaults = Defaults {
    scene: "atrium",
    size: "768x768",
    parts: &["12%", "25%"],
    seeds: 4,
    changes: &["layout=split"],
};

pub(super) fn run(args: &AccuracyArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let defaults = if args.quick { QUICK } else { WHOLE };
    let scenes = given_or(&args.scene, &[defaults.scene]);
    let size = args.size.as_deref().unwrap_or(defaults.size);
    let seeds = args.seeds.unwrap_or(defaults.seeds);
    let walks = given_or(&args.traversal, &["bvh-stack"])
        .iter()
        .map(|name| Walk::named(name, size))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let changes = given_or(&args.change, defaults.changes);
    let changes = changes.iter().map(|text| Variation::parse(text)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut cases = Vec::new();
    for gpu in given_or(&args.gpu, &["adreno-540"]) {
        let machine = MachineArgs { gpu: Some(gpu), ..MachineArgs::default() };
        cases.push(Case { machine: Machine::new(&machine)?, changed: None });
        for variation in &changes {
            for point in Variation::points(std::slice::from_ref(variation), &FrameArgs::default(), &machine)?
            {
                if point.frame != FrameArgs::default() {
                    bail!(
                        "--change {}: it changes what is traced, not how that is replayed",
                        variation.axis.name()
                    );
                }
                let change = format!("{} {}", variation.axis.name(), point.values.join(" "));
                let changed = Some((change, Machine::new(&point.machine)?));
                cases.push(Case { machine: Machine::new(&machine)?, changed });
            }
        }
    }
    let mut parts = given_or(&args.part, defaults.parts)
        .iter()
        .map(|part| fraction("--part", part))
        .collect::<anyhow::Result<Vec<_>>>()?;
    parts.sort_by(f64::total_cmp);
    check_scenes(&scenes)?;
    start_threads(args.run.threads)?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["sampling.txt", "sampling.json", "sampling.csv"])?;
    }

    let frames = measure::all(&scenes, &walks, &cases, &parts, seeds)?;
    let sampling = Sampling { frames, seeds, limits: LIMITS };
    let run = json!({
        "tool": TOOL,
        "image": size,
        "seeds": seeds,
        "threads": rayon::current_num_threads(),
        "wall_s": meter.wall_s(),
        "peak_rss_bytes": meter::peak_rss_bytes(),
    });
    let footer = format!(
        "\n{} frames of {size} in {:.0} s of wall time on {} threads.\n",
        sampling.frames.len(),
        meter.wall_s(),
        rayon::current_num_threads()
    );
    let text = |style: Style| format!("{}{footer}", sampling::text(&sampling, style));
    let (json, csv) = (sampling::json_text(&sampling, &run), sampling::csv_text(&sampling));
    if let Some(folder) = folder {
        let mut files: Vec<(String, Vec<u8>)> = vec![
            ("sampling.txt".to_owned(), text(Style::Plain).into()),
            ("sampling.json".to_owned(), json.clone().into()),
            ("sampling.csv".to_owned(), csv.clone().into()),
        ];
        for (name, chart) in sampling::charts(&sampling, &format!("frames of {size}")) {
            files.push((format!("{name}.svg"), chart.svg()?.into()));
            files.push((format!("{name}.png"), chart.png()?));
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
