//! `raybudget verify`: what others have stated or measured, held against this model; and the model against itself.

use crate::Outcome;
use crate::args::{ClaimsArgs, Format, HardwareArgs, VerifyArgs, VerifyWhat};
use crate::console;
use crate::meter::{self, Meter};
use crate::output::OutputFolder;
use crate::report::TOOL;
use crate::settings::start_threads;
use crate::verify::hardware as probes;
use crate::verify::measure::{self, Conditions, Measured};
use crate::verify::{eyes_table, paper_charts};
use anyhow::bail;
use gpumodel::Fidelity;
use reports::claims::{self, ClaimSet, EMBEDDED, Verdict};
use reports::hardware;
use serde_json::json;

/// Side of the images of a quick run.
const QUICK: [u32; 2] = [64, 64];

pub(crate) fn run(args: &VerifyArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    match &args.what {
        VerifyWhat::Claims(args) => verify_claims(args, meter),
        VerifyWhat::Accuracy(args) => super::accuracy::run(args, meter),
        VerifyWhat::Hardware(args) => verify_hardware(args, meter),
        VerifyWhat::Stability(args) => super::stability::run(args, meter),
        VerifyWhat::Thermal(args) => super::thermal::run(args, meter),
    }
}

fn verify_hardware(args: &HardwareArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let mut rows = hardware::parse(hardware::MEASUREMENTS, "configs/hardware/measurements.toml")?;
    if let Some(gpu) = &args.gpu {
        let mut known: Vec<String> = rows.iter().map(|row| row.gpu.clone()).collect();
        known.dedup();
        rows.retain(|row| row.gpu == *gpu);
        if rows.is_empty() {
            bail!("--gpu {gpu}: nothing was measured on it; use one of: {}", known.join(", "));
        }
    }
    start_threads(args.run.threads)?;
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["hardware.md", "hardware.json", "hardware.csv"])?;
    }
    let judge = Fidelity::from_name(&args.fidelity).unwrap_or(Fidelity::Timed);
    let others = Fidelity::ALL.into_iter().filter(|&rung| rung != judge && !args.quick);
    let rungs: Vec<Fidelity> = std::iter::once(judge).chain(others).collect();
    let verdicts = probes::all(&rows, &rungs)?;
    let summary = hardware::Summary::new(&verdicts);
    let run = json!({
        "tool": TOOL,
        "judge": judge.name(),
        "quick": args.quick,
        "threads": rayon::current_num_threads(),
        "wall_s": meter.wall_s(),
        "peak_rss_bytes": meter::peak_rss_bytes(),
    });
    let json = hardware::json_text(&verdicts, &summary, &run);
    let csv = hardware::csv_text(&verdicts);
    if let Some(folder) = folder {
        let mut files: Vec<(String, Vec<u8>)> = vec![
            ("hardware.md".to_owned(), hardware::markdown(&verdicts, &summary, judge.name()).into()),
            ("hardware.json".to_owned(), json.clone().into()),
            ("hardware.csv".to_owned(), csv.clone().into()),
        ];
        for (stem, chart) in hardware::charts(&verdicts, judge.name()) {
            files.push((format!("{stem}.svg"), chart.svg()?.into_bytes()));
            files.push((format!("{stem}.png"), chart.png()?));
        }
        folder.write_all(&files)?;
    }
    console::print(&match args.format {
        Format::Text => hardware::text(&verdicts, &summary, judge.name(), console::style()),
        Format::Json => json,
        Format::Csv => csv,
    })?;
    Ok(if summary.passes() { Outcome::Done } else { Outcome::CheckFailed })
}

fn verify_claims(args: &ClaimsArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let Some(embedded) = EMBEDDED.iter().find(|embedded| embedded.letter == args.paper) else {
        let letters: Vec<&str> = EMBEDDED.iter().map(|embedded| embedded.letter).collect();
        bail!("--paper {}: no such paper; use one of: {}", args.paper, letters.join(", "));
    };
    let claims = embedded.parse()?;
    start_threads(args.run.threads)?;
    if let Some(folder) = args.scenes.as_deref().filter(|folder| !folder.is_dir()) {
        bail!(
            "--scenes {}: not a folder; give the folder that holds {}",
            folder.display(),
            wanted_files(&claims)
        );
    }
    let folder = args.out.as_deref().map(OutputFolder::create).transpose()?;
    if let Some(folder) = &folder {
        folder.check(&["claims.md", "claims.json", "claims.csv"])?;
    }
    let conditions = Conditions {
        scenes: args.scenes.as_deref().filter(|_| !args.quick),
        image: if args.quick { QUICK } else { claims.paper.image },
        maps: &|setup| folder.is_some() && paper_charts::is_of(&claims) && paper_charts::is_mapped(setup),
    };
    if conditions.scenes.is_none() {
        console::warn(&format!(
            "built-in scenes stand in for the paper's; for the real ones, give --scenes a folder that holds {}",
            wanted_files(&claims)
        ));
    }
    let measured = measure::all(&claims, &conditions, meter)?;
    let verdicts = claims.evaluate(&measured.measurements);
    let texts = Texts::new(&claims, &verdicts, &measured, &conditions, meter);
    if let Some(folder) = folder {
        write_files(folder, &claims, &measured, &texts)?;
    }
    console::print(match args.format {
        Format::Text => &texts.text,
        Format::Json => &texts.json,
        Format::Csv => &texts.csv,
    })?;
    Ok(Outcome::Done)
}

fn wanted_files(claims: &ClaimSet) -> String {
    let files: Vec<&str> =
        claims.scenes.iter().filter_map(|role| role.files.first()).map(String::as_str).collect();
    files.join(", ")
}

/// The verdicts in every form.
struct Texts {
    text: String,
    json: String,
    csv: String,
    markdown: String,
}

impl Texts {
    fn new(
        claims: &ClaimSet,
        verdicts: &[Verdict],
        measured: &Measured,
        conditions: &Conditions<'_>,
        meter: &Meter,
    ) -> Self {
        let scenes: serde_json::Map<String, serde_json::Value> =
            measured.scenes.iter().map(|(role, scene)| (role.clone(), json!(scene))).collect();
        let run = json!({
            "tool": TOOL,
            "image": conditions.image,
            "scenes": scenes,
            "traces": measured.traces,
            "replays": measured.replays,
            "threads": rayon::current_num_threads(),
            "wall_s": meter.wall_s(),
            "peak_rss_bytes": meter::peak_rss_bytes(),
        });
        let table = if paper_charts::is_of(claims) {
            format!("Table 1 of the paper beside ours\n\n{}\n", paper_charts::table_1(claims, measured))
        } else if eyes_table::is_of(claims) {
            let figures = eyes_table::figures(claims, measured);
            format!("Figures 1 and 3 of the paper beside ours: ray units and whole frames\n\n{figures}\n")
        } else {
            String::new()
        };
        let footer = format!(
            "{} traces, {} replays of them, in {:.0} s of wall time on {} threads; images of {}x{}.\n",
            measured.traces,
            measured.replays,
            meter.wall_s(),
            rayon::current_num_threads(),
            conditions.image[0],
            conditions.image[1],
        );
        let text = claims::text(&claims.paper, verdicts, console::style());
        Self {
            text: format!("{text}\n{table}{footer}"),
            json: claims::json_text(&claims.paper, verdicts, &run),
            csv: claims::csv_text(verdicts),
            markdown: format!(
                "{}\n{}{table}{footer}",
                claims::markdown(&claims.paper, verdicts),
                if table.is_empty() { "" } else { "## " }
            ),
        }
    }
}

/// Writes everything into the folder: verdicts, and the counterparts of the paper's figures.
fn write_files(
    folder: OutputFolder,
    claims: &ClaimSet,
    measured: &Measured,
    texts: &Texts,
) -> anyhow::Result<()> {
    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("claims.md".to_owned(), texts.markdown.clone().into()),
        ("claims.json".to_owned(), texts.json.clone().into()),
        ("claims.csv".to_owned(), texts.csv.clone().into()),
    ];
    if paper_charts::is_of(claims) {
        for (stem, chart) in paper_charts::charts(claims, measured) {
            files.push((format!("{stem}.svg"), chart.svg()?.into_bytes()));
            files.push((format!("{stem}.png"), chart.png()?));
        }
        for (stem, picture) in paper_charts::heat_maps(claims, measured)? {
            files.push((format!("{stem}.png"), picture));
        }
    }
    folder.write_all(&files)
}
