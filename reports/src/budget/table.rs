//! The results of a check as text, JSON and CSV.

use super::check::{Checked, CheckedFrame, Outcome, Row, Severity};
use super::file::{Change, Limit, Rule};
use super::why;
use crate::columns::{Column, write_rows};
use crate::counters::Value;
use crate::csv_rows;
use crate::text::{Style, reach};
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

/// The figure, with how far it may be off where it is of a sample.
pub(super) fn figure(Row { value, interval, .. }: &Row) -> String {
    let number = match value {
        Value::Count(count) => count.to_string(),
        Value::Real(real) => units::digits(*real),
        Value::Absent { .. } => "absent".to_owned(),
    };
    match value.as_f64().zip(*interval) {
        Some((value, interval)) => format!("{number} {}", reach(value, interval)),
        None => number,
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

/// How many limits were broken, and of which groups.
pub(super) fn closing(checked: &Checked) -> String {
    let (hard, soft) = (checked.failures(Severity::Hard), checked.failures(Severity::Soft));
    let not_compared = match checked.count(|row| row.outcome == Outcome::NotCompared) {
        0 => String::new(),
        count => format!(", {count} not compared for want of a baseline"),
    };
    let passed_over = match checked.passed_over {
        0 => String::new(),
        count => format!(", {count} more for other frames"),
    };
    let groups: Vec<String> =
        groups(checked).into_iter().filter_map(|group| broken(checked, group)).collect();
    let by_group =
        if groups.is_empty() { String::new() } else { format!("; broken by group: {}", groups.join(", ")) };
    let all = checked.count(|_| true);
    format!("{all} limits: {hard} hard broken, {soft} soft broken{not_compared}{passed_over}{by_group}")
}

/// Groups in the order of the file.
fn groups(checked: &Checked) -> Vec<&str> {
    let mut groups = Vec::new();
    for group in checked.rows().filter_map(|(_, row)| row.limit.group.as_deref()) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups
}

/// How many limits of a group are broken; none where all are kept.
fn broken(checked: &Checked, group: &str) -> Option<String> {
    let of_group = |row: &Row| row.limit.group.as_deref() == Some(group);
    let all = checked.count(of_group);
    let broken = checked.count(|row| of_group(row) && row.outcome == Outcome::Fail);
    (broken > 0).then(|| format!("{group} {broken} of {all}"))
}

/// Which frames and groups a table has to tell apart.
pub(super) struct Told {
    pub(super) frames: bool,
    pub(super) groups: bool,
}

impl Told {
    pub(super) fn of(checked: &Checked) -> Self {
        Self { frames: checked.frames.len() > 1, groups: !groups(checked).is_empty() }
    }
}

/// The results as an aligned table and a closing line, and why limits are broken.
pub fn text(checked: &Checked, style: Style) -> String {
    let told = Told::of(checked);
    let cells = |heading: &str, cell: &dyn Fn(&CheckedFrame, &Row) -> String| -> Vec<String> {
        std::iter::once(heading.to_owned())
            .chain(checked.rows().map(|(frame, row)| cell(frame, row)))
            .collect()
    };
    let mut columns = vec![Column::words(cells("result", &|_, row| verdict(row).to_owned()))];
    if told.frames {
        columns.push(Column::words(cells("frame", &|frame, _| frame.name.clone())));
    }
    if told.groups {
        columns.push(Column::words(cells("group", &|_, row| row.limit.group.clone().unwrap_or_default())));
    }
    columns.extend([
        Column::words(cells("counter", &|_, row| row.limit.counter.clone())),
        Column::words(cells("pass", &|_, row| row.limit.place().to_owned())),
        Column::words(cells("limit", &|_, row| {
            format!("{} {}", row.limit.severity.name(), row.limit.rule.describe())
        })),
        Column::figures(cells("value", &|_, row| figure(row))),
        Column::words(cells("unit", &|_, row| row.unit.clone())),
        Column::words(cells("change", &|_, row| changed(row))),
    ]);
    let mut out = String::new();
    write_rows(&mut out, &columns.iter().collect::<Vec<_>>(), 1, style);
    writeln!(out, "{}", closing(checked)).expect("a string takes every write");
    out + &reasons(checked)
}

/// Why limits are broken, frame by frame.
pub(super) fn reasons(checked: &Checked) -> String {
    let several = checked.frames.len() > 1;
    let of_frame = |frame: &CheckedFrame| -> String {
        let texts: String = frame.reasons.iter().flatten().map(why::text).collect();
        if several && !texts.is_empty() {
            format!("\n{} ({}){texts}", frame.name, frame.title)
        } else {
            texts
        }
    };
    checked.frames.iter().map(of_frame).collect()
}

pub(super) fn signed(number: f64) -> String {
    let sign = if number >= 0.0 { "+" } else { "" };
    format!("{sign}{}", units::digits(number))
}

/// The results as `{passed, hard_failures, soft_failures, passed_over, stale, frames: [{frame, title, stale, rows, why}]}`; the last only where reasons were asked for.
pub fn json_text(checked: &Checked) -> String {
    let row = |row: &Row| {
        let value = match row.value {
            Value::Count(count) => json!(count),
            Value::Real(real) => json!(real),
            Value::Absent { .. } => Json::Null,
        };
        json!({
            "group": row.limit.group,
            "counter": row.limit.counter,
            "pass": row.limit.pass,
            "severity": row.limit.severity,
            "limit": row.limit.rule.describe(),
            "line": row.limit.line,
            "value": value,
            "ci95": row.interval.filter(|ends| ends.iter().all(|end| end.is_finite())),
            "decided": row.is_decided(),
            "unit": row.unit,
            "baseline": row.baseline,
            "change": row.change(),
            "change_percent": row.percent(),
            "outcome": row.outcome,
        })
    };
    let frame = |frame: &CheckedFrame| {
        let mut json = json!({
            "frame": frame.name,
            "title": frame.title,
            "stale": frame.stale,
            "rows": frame.rows.iter().map(row).collect::<Vec<_>>(),
        });
        if let Some(reasons) = &frame.reasons {
            json["why"] = json!(reasons);
        }
        json
    };
    let whole = json!({
        "passed": checked.failures(Severity::Hard) == 0,
        "hard_failures": checked.failures(Severity::Hard),
        "soft_failures": checked.failures(Severity::Soft),
        "passed_over": checked.passed_over,
        "stale": checked.stale_baseline,
        "frames": checked.frames.iter().map(frame).collect::<Vec<_>>(),
    });
    format!("{whole:#}\n")
}

/// The results as CSV with a heading.
pub fn csv_text(checked: &Checked) -> String {
    let heading = [
        "frame",
        "group",
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
        "low",
        "high",
    ];
    let row = |(frame, row): (&CheckedFrame, &Row)| {
        let number = |number: Option<f64>| number.map(|number| number.to_string()).unwrap_or_default();
        let outcome = match row.outcome {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::NotCompared => "not_compared",
        };
        let value = match row.value {
            Value::Count(count) => count.to_string(),
            Value::Real(real) => real.to_string(),
            Value::Absent { .. } => String::new(),
        };
        [
            frame.name.clone(),
            row.limit.group.clone().unwrap_or_default(),
            outcome.to_owned(),
            row.limit.severity.name().to_owned(),
            row.limit.counter.clone(),
            row.limit.pass.clone().unwrap_or_default(),
            row.limit.rule.describe(),
            value,
            row.unit.clone(),
            number(row.baseline),
            number(row.change()),
            number(row.percent()),
            number(row.interval.map(|[low, _]| low)),
            number(row.interval.map(|[_, high]| high)),
        ]
    };
    csv_rows::text(heading, checked.rows().map(row))
}
