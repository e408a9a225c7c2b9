//! `raybudget check`: holds a frame's counters against a budget.

use super::profile::profile;
use crate::Outcome;
use crate::args::{CheckArgs, CheckFormat, FrameArgs, MachineArgs};
use crate::console;
use crate::machine::Machine;
use crate::meter::Meter;
use crate::output::{OutputFile, read_text};
use crate::settings::{FrameSettings, start_threads};
use anyhow::bail;
use reports::budget::{self, Accepted, Baseline, Budget, Severity};
use reports::{Report, json};
use std::path::Path;

pub(crate) fn run(args: &CheckArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let budget_text = read_text(&args.budget, "a budget file (.toml)")?;
    let budget = Budget::parse(&budget_text, &args.budget.display().to_string())?;
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?.flatten();
    let accept = args.accept.as_deref().map(OutputFile::create).transpose()?;
    let report = report(args, meter)?;
    let checked = budget.check(&report, baseline.as_ref())?;
    if let Some(file) = accept {
        file.written(Accepted::of(&report, &budget).text().as_bytes())?.finish()?;
    }
    for difference in &checked.stale {
        console::warn(&format!("stale baseline: {difference}"));
    }
    let reasons = args.why.then(|| budget::why(&checked, &report, baseline.as_ref()));
    let told = reasons.as_deref().unwrap_or_default();
    console::print(&match args.format {
        CheckFormat::Text => budget::text(&checked, told, console::style()),
        CheckFormat::Json => budget::json_text(&checked, reasons.as_deref()),
        CheckFormat::Csv => budget::csv_text(&checked),
        CheckFormat::Markdown => budget::markdown(&checked, told, &report),
        CheckFormat::Junit => budget::junit(&checked, told, &report),
        CheckFormat::Github => budget::annotations(&checked, told, &budget.file),
    })?;
    Ok(if checked.failures(Severity::Hard) > 0 { Outcome::CheckFailed } else { Outcome::Done })
}

/// The report to check: read, or made.
fn report(args: &CheckArgs, meter: &Meter) -> anyhow::Result<Report> {
    let path = Path::new(&args.subject);
    if path.extension().is_some_and(|extension| extension == "json") {
        if args.frame != FrameArgs::default() || args.machine != MachineArgs::default() {
            bail!(
                "{}: a finished report takes no options of a frame or a machine; leave them out",
                path.display()
            );
        }
        return read_report(path);
    }
    let settings = FrameSettings::new(&args.frame)?;
    let machine = Machine::of_whole_frames(&args.machine)?;
    start_threads(args.run.threads)?;
    Ok(profile(&args.subject, &settings, (&machine, None), gpumodel::Maps::Dropped, meter)?.report)
}

/// `None`, with a warning, where there is no such file: the first run of a check has none.
fn read_baseline(path: &Path) -> anyhow::Result<Option<Baseline>> {
    if !path.exists() {
        console::warn(&format!(
            "{}: there is no such baseline; limits on changes are not compared. To make one: raybudget check --accept",
            path.display()
        ));
        return Ok(None);
    }
    if path.extension().is_some_and(|extension| extension == "toml") {
        let text = read_text(path, "figures that were accepted (.toml)")?;
        let accepted = Accepted::parse(&text, &path.display().to_string())?;
        return Ok(Some(Baseline::Accepted(Box::new(accepted))));
    }
    Ok(Some(Baseline::Report(Box::new(read_report(path)?))))
}

fn read_report(path: &Path) -> anyhow::Result<Report> {
    let text = read_text(path, "a report (.json)")?;
    Ok(json::read(&text, &path.display().to_string())?)
}
