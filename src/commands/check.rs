//! `raybudget check`: holds a frame's counters against a budget.

use super::profile::profile;
use crate::Outcome;
use crate::args::{CheckArgs, Format, FrameArgs, MachineArgs};
use crate::console;
use crate::machine::Machine;
use crate::meter::Meter;
use crate::output::read_text;
use crate::settings::{FrameSettings, start_threads};
use anyhow::bail;
use reports::budget::{self, Budget, Severity};
use reports::{Report, json};
use std::path::Path;

pub(crate) fn run(args: &CheckArgs, meter: &Meter) -> anyhow::Result<Outcome> {
    let budget_text = read_text(&args.budget, "a budget file (.toml)")?;
    let budget = Budget::parse(&budget_text, &args.budget.display().to_string())?;
    let baseline = args.baseline.as_deref().map(read_report).transpose()?;
    let report = report(args, meter)?;
    let checked = budget.check(&report, baseline.as_ref())?;
    for difference in &checked.stale {
        console::warn(&format!("stale baseline: {difference}"));
    }
    console::print(&match args.format {
        Format::Text => budget::text(&checked, console::style()),
        Format::Json => budget::json_text(&checked),
        Format::Csv => budget::csv_text(&checked),
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

fn read_report(path: &Path) -> anyhow::Result<Report> {
    let text = read_text(path, "a report (.json)")?;
    Ok(json::read(&text, &path.display().to_string())?)
}
