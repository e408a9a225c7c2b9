//! Verdicts as text, Markdown, JSON and CSV.

use super::summary::{Group, Summary};
use super::verdict::{Figure, RowVerdict};
use crate::text::Style;
use serde_json::{Value, json};
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

fn verb(passes: bool) -> &'static str {
    if passes { "pass" } else { "FAIL" }
}

fn percent(verdict: &RowVerdict, error: Option<f64>) -> String {
    use super::file::Kind;
    match (verdict.kind, error) {
        (_, None) => String::new(),
        (Kind::Knee, Some(steps)) => format!("{steps:+.0} steps"),
        (_, Some(error)) => format!("{:+.1} %", 100.0 * error),
    }
}

fn published(figure: Option<&Figure>) -> &str {
    figure.map_or("", |figure| &figure.text)
}

/// What the row says of itself: derived figures and reasons.
fn remarks(verdict: &RowVerdict) -> Vec<String> {
    let mut remarks: Vec<String> = verdict.apart.iter().map(|apart| apart.reason().to_owned()).collect();
    if !verdict.inputs.is_empty() {
        remarks.push(format!("input of {}", verdict.inputs.join(", ")));
    }
    if !verdict.why.is_empty() {
        remarks.push(verdict.why.clone());
    }
    remarks
}

fn of_group(group: &Group) -> String {
    let Group { kind, rows, count, mean, worst, worst_row, limit } = group;
    let kind = format!("{kind:?}").to_lowercase();
    let limit = limit.map_or(String::new(), |limit| {
        format!(", limit on the mean {:.0} %: {}", 100.0 * limit, verb(group.passes()))
    });
    format!(
        "{kind}, {rows} ({count}): mean {:.1} %, worst {:.1} % ({worst_row}){limit}",
        100.0 * mean,
        100.0 * worst
    )
}

/// A table of rows, then what there is to say of some, then the means.
pub fn text(verdicts: &[RowVerdict], summary: &Summary, judge: &str, style: Style) -> String {
    let mut out = String::new();
    let heading = |text: &str| style.bold(text);
    let others: Vec<&str> =
        verdicts.first().map_or(Vec::new(), |row| row.others.iter().map(|other| other.0.as_str()).collect());
    let width = verdicts.iter().map(|verdict| verdict.id.len()).max().unwrap_or(2);
    let mut titles = format!("{:<width$}  {:>16}  {:>12}  {:>9}", "row", "published", judge, "error");
    for other in &others {
        titles += &format!("  {other:>12}  {:>9}", "error");
    }
    titles += "  limit  input";
    line!(out, "{}", heading(&titles));
    for verdict in verdicts {
        let mut row = format!(
            "{:<width$}  {:>16}  {:>12}  {:>9}",
            verdict.id,
            published(verdict.published.as_ref()),
            verdict.ours.text,
            percent(verdict, verdict.error)
        );
        for (_, figure, error) in &verdict.others {
            row += &format!("  {:>12}  {:>9}", figure.text, percent(verdict, *error));
        }
        row += &format!(
            "  {:<5}  {}",
            verb(verdict.outcome),
            if verdict.inputs.is_empty() { "" } else { "input" }
        );
        line!(out, "{}", row.trim_end());
    }
    line!(out);
    line!(out, "{}", heading("Rows"));
    for verdict in verdicts {
        line!(out, "{} ({}): {}", verdict.id, verdict.gpu, verdict.statement);
        for remark in remarks(verdict) {
            line!(out, "    {remark}");
        }
        line!(out, "    source: {}", verdict.source);
    }
    line!(out);
    line!(out, "{}", heading("Errors"));
    line!(out, "{} of {} rows keep their limits", summary.passed, summary.count);
    for group in &summary.groups {
        line!(out, "{}", of_group(group));
    }
    out
}

/// The table as Markdown, with what there is to say of each row.
pub fn markdown(verdicts: &[RowVerdict], summary: &Summary, judge: &str) -> String {
    let mut out = String::new();
    let cell = |text: &str| text.replace('|', "\\|");
    line!(out, "## Published measurements of real GPUs beside the model");
    line!(out);
    line!(out, "| row | statement | published | model, {judge} | error | limit | remarks |");
    line!(out, "|---|---|---|---|---|---|---|");
    for verdict in verdicts {
        line!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} |",
            verdict.id,
            cell(&verdict.statement),
            published(verdict.published.as_ref()),
            verdict.ours.text,
            percent(verdict, verdict.error),
            verb(verdict.outcome),
            cell(&remarks(verdict).join(". "))
        );
    }
    line!(out);
    for group in &summary.groups {
        line!(out, "- {}", of_group(group));
    }
    out
}

/// `{rows: [...], summary, run}`; `run` is what the caller knows of the run.
pub fn json_text(verdicts: &[RowVerdict], summary: &Summary, run: &Value) -> String {
    let rows: Vec<Value> = verdicts
        .iter()
        .map(|verdict| {
            let mut row = json!(verdict);
            row["why"] = json!(remarks(verdict).join(". "));
            row
        })
        .collect();
    format!("{:#}\n", json!({ "rows": rows, "summary": summary, "run": run }))
}

/// One line for each row, with a heading.
pub fn csv_text(verdicts: &[RowVerdict]) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let heading = [
        "id",
        "gpu",
        "kind",
        "statement",
        "outcome",
        "ours",
        "published",
        "error",
        "inputs",
        "why",
        "source",
    ];
    let mut rows = vec![heading.map(str::to_owned)];
    rows.extend(verdicts.iter().map(|verdict| {
        [
            verdict.id.clone(),
            verdict.gpu.clone(),
            format!("{:?}", verdict.kind).to_lowercase(),
            verdict.statement.clone(),
            if verdict.outcome { "pass" } else { "fail" }.to_owned(),
            verdict.ours.value.to_string(),
            verdict.published.as_ref().map(|figure| figure.value.to_string()).unwrap_or_default(),
            verdict.error.map(|error| error.to_string()).unwrap_or_default(),
            verdict.inputs.join("; "),
            remarks(verdict).join(". "),
            verdict.source.clone(),
        ]
    }));
    for row in rows {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}
