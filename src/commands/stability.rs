//! `raybudget verify stability`: tracer, solvers and models at the ends of their ranges.

use crate::Outcome;
use crate::args::{Format, StabilityArgs};
use crate::console;
use crate::meter::{self, Meter};
use crate::output::OutputFolder;
use crate::report::TOOL;
use crate::settings::start_threads;
use reports::stability as table;
use reports::text::Style;
use serde_json::json;
use stability::{Case, Size};

pub(super) fn run(args: &StabilityArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    start_threads(args.run.threads)?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["stability.txt", "stability.md", "stability.json", "stability.csv"])?;
    }
    let size = if args.quick { Size::Quick } else { Size::Full };
    let cases = stability::all(size, console::status);
    let run = json!({
        "tool": TOOL,
        "quick": args.quick,
        "threads": rayon::current_num_threads(),
        "wall_s": meter.wall_s(),
        "peak_rss_bytes": meter::peak_rss_bytes(),
    });
    let footer = format!(
        "{:.0} s of wall time on {} threads{}.\n",
        meter.wall_s(),
        rayon::current_num_threads(),
        if args.quick { ", with --quick" } else { "" }
    );
    let text = |style: Style| format!("{}{footer}", table::text(&cases, style));
    let (json, csv) = (table::json_text(&cases, &run), table::csv_text(&cases));
    if let Some(folder) = folder {
        let files: [(String, Vec<u8>); 4] = [
            ("stability.txt".to_owned(), text(Style::Plain).into()),
            (
                "stability.md".to_owned(),
                format!("{}\n{footer}", table::markdown("Numerical stability", &cases)).into(),
            ),
            ("stability.json".to_owned(), json.clone().into()),
            ("stability.csv".to_owned(), csv.clone().into()),
        ];
        folder.write_all(&files)?;
    }
    console::print(&match args.format {
        Format::Text => text(console::style()),
        Format::Json => json,
        Format::Csv => csv,
    })?;
    Ok(if cases.iter().all(Case::passes) { Outcome::Done } else { Outcome::CheckFailed })
}
