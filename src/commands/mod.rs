//! One file per command: parse, call, print.

mod accuracy;
pub(crate) mod cache;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod list;
pub(crate) mod profile;
pub(crate) mod render;
pub(crate) mod replay;
mod sampling;
pub(crate) mod shell;
mod stability;
pub(crate) mod stereo;
pub(crate) mod sweep;
mod thermal;
pub(crate) mod trace;
pub(crate) mod verify;
pub(crate) mod whatif;

use crate::args::{Format, ReportArgs};
use crate::console;
use crate::output::read_text;
use crate::report::{Answer, ReportFiles};
use reports::{Report, csv_table, json, text};
use std::path::Path;

/// Whether a path names a finished report.
fn is_report(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
}

/// Reads a finished report.
fn read_report(path: &Path) -> anyhow::Result<Report> {
    let text = read_text(path, "a report (.json)")?;
    Ok(json::read(&text, &path.display().to_string())?)
}

/// Opens the files that a report was asked to be written into.
fn open_report_files(args: &ReportArgs) -> anyhow::Result<Option<ReportFiles>> {
    args.out.as_deref().map(ReportFiles::create).transpose()
}

/// Writes the files, then prints the report.
fn deliver(answer: &Answer, files: Option<ReportFiles>, format: Format) -> anyhow::Result<()> {
    if let Some(files) = files {
        files.write(answer)?;
    }
    let report = &answer.report;
    console::print(&match format {
        Format::Text => text::write(report, console::style()),
        Format::Json => json::write(report),
        Format::Csv => csv_table::write(report),
    })
}
