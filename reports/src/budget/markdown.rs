//! The results of a check as a summary in Markdown, for a pull request or a job.

use super::check::{Checked, Severity};
use super::table::{changed, closing, figure, verdict};
use super::why::{self, Why};
use crate::report::Report;
use std::fmt::Write;

/// The results under a heading: a table, what is stale about the baseline, and why limits are broken.
pub fn markdown(checked: &Checked, reasons: &[Why], report: &Report) -> String {
    let result = if checked.failures(Severity::Hard) > 0 { "broken" } else { "kept" };
    let inputs = &report.inputs;
    let mut out = format!(
        "## Budget {result}: {} on {}, {}\n\n| result | counter | of | limit | value | unit | change |\n|---|---|---|---|---:|---|---:|\n",
        cell(&inputs.scene),
        cell(&inputs.gpu),
        cell(&inputs.technique)
    );
    for row in &checked.rows {
        let limit = &row.limit;
        writeln!(
            out,
            "| {} | `{}` | {} | {} {} | {} | {} | {} |",
            verdict(row),
            limit.counter,
            cell(limit.place()),
            limit.severity.name(),
            limit.rule.describe(),
            figure(&row.value),
            cell(&row.unit),
            changed(row)
        )
        .expect("a string takes every write");
    }
    writeln!(out, "\n{}.", closing(checked)).expect("a string takes every write");
    for sentence in &checked.stale {
        writeln!(out, "\nStale baseline: {}.", cell(sentence)).expect("a string takes every write");
    }
    if !reasons.is_empty() {
        let reasons: String = reasons.iter().map(why::text).collect();
        writeln!(out, "\n```text\n{}```", reasons.trim_start_matches('\n'))
            .expect("a string takes every write");
    }
    out
}

/// Text that stays within its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}
