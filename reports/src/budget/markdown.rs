//! The results of a check as a summary in Markdown, for a pull request or a job.

use super::check::{Checked, Severity};
use super::table::{Told, changed, closing, figure, reasons, verdict};
use crate::comparison::markdown::escaped as cell;
use std::fmt::Write;

/// The results under a heading: a table for each frame, what is stale about the baseline, and why limits are broken.
pub fn markdown(checked: &Checked) -> String {
    let result = if checked.failures(Severity::Hard) > 0 { "broken" } else { "kept" };
    let told = Told::of(checked);
    let mut out = match checked.frames.as_slice() {
        [frame] => format!("## Budget {result}: {}\n", cell(&frame.title)),
        frames => format!("## Budget {result}: {} frames\n", frames.len()),
    };
    for frame in &checked.frames {
        if told.frames {
            write!(out, "\n### {}: {}\n", cell(&frame.name), cell(&frame.title))
                .expect("a string takes every write");
        }
        let (head, rule) = if told.groups { ("| group ", "|---") } else { ("", "") };
        write!(
            out,
            "\n| result {head}| counter | of | limit | value | unit | change |\n|---{rule}|---|---|---|---:|---|---:|\n"
        )
        .expect("a string takes every write");
        for row in &frame.rows {
            let limit = &row.limit;
            let group = limit.group.as_deref().unwrap_or_default();
            let group = if told.groups { format!("| {} ", cell(group)) } else { String::new() };
            writeln!(
                out,
                "| {} {group}| `{}` | {} | {} {} | {} | {} | {} |",
                verdict(row),
                limit.counter,
                cell(limit.place()),
                limit.severity.name(),
                limit.rule.describe(),
                figure(row),
                cell(&row.unit),
                changed(row)
            )
            .expect("a string takes every write");
        }
    }
    writeln!(out, "\n{}.", cell(&closing(checked))).expect("a string takes every write");
    for sentence in checked.stale() {
        writeln!(out, "\nStale baseline: {}.", cell(&sentence)).expect("a string takes every write");
    }
    let reasons = reasons(checked);
    if !reasons.is_empty() {
        writeln!(out, "\n```text\n{}```", reasons.trim_start_matches('\n').replace("```", "'''"))
            .expect("a string takes every write");
    }
    out
}
