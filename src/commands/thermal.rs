//! `raybudget verify thermal`: temperatures against closed forms, and integrators against each other.

use crate::Outcome;
use crate::args::{Format, ThermalArgs};
use crate::console;
use crate::meter::{self, Meter};
use crate::output::OutputFolder;
use crate::report::TOOL;
use reports::text::Style;
use reports::{stability as table, thermal as work};
use serde_json::json;
use stability::{Case, Size};

pub(super) fn run(args: &ThermalArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["thermal.txt", "thermal.md", "thermal.json", "thermal.csv", "work-precision.csv"])?;
    }
    let size = if args.quick { Size::Quick } else { Size::Full };
    let found = stability::thermal(size, console::status);
    let run = json!({
        "tool": TOOL,
        "quick": args.quick,
        "work_precision": work::json(&found),
        "wall_s": meter.wall_s(),
        "peak_rss_bytes": meter::peak_rss_bytes(),
    });
    let footer =
        format!("{:.1} s of wall time{}.\n", meter.wall_s(), if args.quick { ", with --quick" } else { "" });
    let text = |style: Style| {
        format!("{}\n{}\n{footer}", table::text(&found.cases, style), work::text(&found, style))
    };
    let (json, csv) = (table::json_text(&found.cases, &run), table::csv_text(&found.cases));
    if let Some(folder) = folder {
        let mut files: Vec<(String, Vec<u8>)> = vec![
            ("thermal.txt".to_owned(), text(Style::Plain).into()),
            (
                "thermal.md".to_owned(),
                format!("{}\n{footer}", table::markdown("Temperatures over time", &found.cases)).into(),
            ),
            ("thermal.json".to_owned(), json.clone().into()),
            ("thermal.csv".to_owned(), csv.clone().into()),
            ("work-precision.csv".to_owned(), work::csv_text(&found).into()),
        ];
        for (stem, chart) in work::charts(&found) {
            files.push((format!("{stem}.svg"), chart.svg()?.into_bytes()));
            files.push((format!("{stem}.png"), chart.png()?));
        }
        folder.write_all(&files)?;
    }
    console::print(&match args.format {
        Format::Text => text(console::style()),
        Format::Json => json,
        Format::Csv => csv,
    })?;
    Ok(if found.cases.iter().all(Case::passes) { Outcome::Done } else { Outcome::CheckFailed })
}
