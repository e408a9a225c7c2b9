//! The results of a check as text, JSON and CSV.

use super::check::{Checked, Outcome, Row, Severity};
use super::file::{Change, Limit, Rule};
use super::why::{self, Why};
use crate::counters::Value;
use crate::text::Style;
use crate::units;
use serde_json::{Value as Json, json};
use std::fmt::Write;

impl Severity {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Hard => "hard",
        }
    }
}

impl Limit {
    /// The pass, or the frame.
    pub(super) fn place(&self) -> &str {
        self.pass.as_deref().unwrap_or("frame")
    }
}

impl Rule {
    pub(super) fn describe(self) -> String {
        let change = |change: Change| match change {
            Change::Absolute(number) => number.to_string(),
            Change::Percent(number) => format!("{number} %"),
        };
        match self {
            Self::Max(most) => format!("max {most}"),
            Self::Min(least) => format!("min {least}"),
            Self::MaxIncrease(most) => format!("max increase {}", change(most)),
            Self::MaxDecrease(most) => format!("max decrease {}", change(most)),
            Self::MinIncrease(least) => format!("min increase {}", change(least)),
            Self::MinDecrease(least) => format!("min decrease {}", change(least)),
        }
    }
}

pub(super) fn verdict(row: &Row) -> &'static str {
    match (row.outcome, row.limit.severity) {
        (Outcome::Pass, _) => "pass",
        (Outcome::Fail, Severity::Hard) => "FAIL",
        (Outcome::Fail, Severity::Soft) => "warn",
        (Outcome::NotCompared, _) => "no baseline",
    }
}

pub(super) fn figure(value: &Value) -> String {
    match value {
        Value::Count(count) => count.to_string(),
        Value::Real(real) => units::digits(*real),
        Value::Absent { .. } => "absent".to_owned(),
    }
}

/// The change against the baseline, where there is one.
pub(super) fn changed(row: &Row) -> String {
    match (row.change(), row.percent()) {
        (Some(change), Some(percent)) => format!("{} ({:+.2} %)", signed(change), percent),
        (Some(change), None) => format!("{} (from 0)", signed(change)),
        (None, _) => String::new(),
    }
}

/// How many limits were broken.
pub(super) fn closing(checked: &Checked) -> String {
    let (hard, soft) = (checked.failures(Severity::Hard), checked.failures(Severity::Soft));
    let not_compared = match checked.rows.iter().filter(|row| row.outcome == Outcome::NotCompared).count() {
        0 => String::new(),
        count => format!(", {count} not compared for want of a baseline"),
    };
    format!("{} limits: {hard} hard broken, {soft} soft broken{not_compared}", checked.rows.len())
}

/// The results as an aligned table and a closing line, and why limits are broken.
pub fn text(checked: &Checked, reasons: &[Why], style: Style) -> String {
    let mut rows = vec![["result", "counter", "pass", "limit", "value", "unit", "change"].map(str::to_owned)];
    rows.extend(checked.rows.iter().map(|row| {
        [
            verdict(row).to_owned(),
            row.limit.counter.clone(),
            row.limit.place().to_owned(),
            format!("{} {}", row.limit.severity.name(), row.limit.rule.describe()),
            figure(&row.value),
            row.unit.clone(),
            changed(row),
        ]
    }));
    let widths: [usize; 7] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let mut out = String::new();
    for (index, row) in rows.iter().enumerate() {
        let cells: Vec<String> = (row.iter().zip(widths).enumerate())
            .map(|(column, (cell, width))| match column {
                4 => format!("{cell:>width$}"),
                _ => format!("{cell:<width$}"),
            })
            .collect();
        let line = cells.join("  ").trim_end().to_owned();
        let line = if index == 0 && style == Style::Ansi { format!("\x1b[1m{line}\x1b[0m") } else { line };
        writeln!(out, "{line}").expect("a string takes every write");
    }
    writeln!(out, "{}", closing(checked)).expect("a string takes every write");
    out.extend(reasons.iter().map(why::text));
    out
}

pub(super) fn signed(number: f64) -> String {
    let sign = if number >= 0.0 { "+" } else { "" };
    format!("{sign}{}", units::digits(number))
}

/// The results as `{passed, hard_failures, soft_failures, stale, rows: [...], why: [...]}`; the last only where reasons were asked for.
pub fn json_text(checked: &Checked, reasons: Option<&[Why]>) -> String {
    let rows: Vec<Json> = checked
        .rows
        .iter()
        .map(|row| {
            let value = match row.value {
                Value::Count(count) => json!(count),
                Value::Real(real) => json!(real),
                Value::Absent { .. } => Json::Null,
            };
            json!({
                "counter": row.limit.counter,
                "pass": row.limit.pass,
                "severity": row.limit.severity,
                "limit": row.limit.rule.describe(),
                "value": value,
                "unit": row.unit,
                "baseline": row.baseline,
                "change": row.change(),
                "change_percent": row.percent(),
                "outcome": row.outcome,
            })
        })
        .collect();
    let mut whole = json!({
        "passed": checked.failures(Severity::Hard) == 0,
        "hard_failures": checked.failures(Severity::Hard),
        "soft_failures": checked.failures(Severity::Soft),
        "stale": checked.stale,
        "rows": rows,
    });
    if let Some(reasons) = reasons {
        whole["why"] = json!(reasons);
    }
    format!("{whole:#}\n")
}

/// The results as CSV with a heading.
pub fn csv_text(checked: &Checked) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let heading = [
        "outcome",
        "severity",
        "counter",
        "pass",
        "limit",
        "value",
        "unit",
        "baseline",
        "change",
        "change_percent",
    ]
    .map(str::to_owned);
    let rows = checked.rows.iter().map(|row| {
        let number = |number: Option<f64>| number.map(|number| number.to_string()).unwrap_or_default();
        [
            match row.outcome {
                Outcome::Pass => "pass",
                Outcome::Fail => "fail",
                Outcome::NotCompared => "not_compared",
            }
            .to_owned(),
            row.limit.severity.name().to_owned(),
            row.limit.counter.clone(),
            row.limit.pass.clone().unwrap_or_default(),
            row.limit.rule.describe(),
            match row.value {
                Value::Count(count) => count.to_string(),
                Value::Real(real) => real.to_string(),
                Value::Absent { .. } => String::new(),
            },
            row.unit.clone(),
            number(row.baseline),
            number(row.change()),
            number(row.percent()),
        ]
    });
    for row in std::iter::once(heading).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}
