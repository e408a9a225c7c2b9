//! Why a limit is broken: what the counter is made of, part by part, and how each part changed.

use super::baseline::Baseline;
use super::check::{Outcome, Row};
use super::table::signed;
use crate::report::{LevelTraffic, Report};
use crate::units;
use serde::Serialize;
use std::fmt::Write;

/// Parts that are told of a broken limit.
const MOST_CAUSES: usize = 8;

/// Why a counter breaks its limits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Why {
    /// The counter.
    pub counter: String,
    /// The pass that is limited; none for the whole frame.
    pub pass: Option<String>,
    /// Unit of the figures.
    pub unit: String,
    /// The parts that changed most, or without a baseline the largest ones; at most eight.
    pub causes: Vec<Cause>,
}

/// A part of a counter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// What it is a part of: `pass`, `pass and buffer`, `pass, buffer and level`, or `resource`.
    pub by: &'static str,
    /// Which part.
    pub part: String,
    /// Its figure.
    pub value: f64,
    /// The baseline's; none without a baseline.
    pub baseline: Option<f64>,
}

impl Cause {
    /// Figure minus baseline.
    pub fn change(&self) -> Option<f64> {
        Some(self.value - self.baseline?)
    }
}

/// A reason for each counter with a broken limit, soft or hard, in the order of the rows.
pub(super) fn reasons(rows: &[Row], report: &Report, baseline: Option<&Baseline>) -> Vec<Why> {
    let mut reasons: Vec<Why> = Vec::new();
    for row in rows.iter().filter(|row| row.outcome == Outcome::Fail) {
        let (counter, pass) = (&row.limit.counter, &row.limit.pass);
        if reasons.iter().any(|other| other.counter == *counter && other.pass == *pass) {
            continue;
        }
        let before = baseline.map(|baseline| match baseline.report() {
            Some(report) => parts(report, counter, pass.as_deref()),
            None => passes(baseline, counter, pass.as_deref()),
        });
        let causes = causes(parts(report, counter, pass.as_deref()), before.as_deref());
        reasons.push(Why { counter: counter.clone(), pass: pass.clone(), unit: row.unit.clone(), causes });
    }
    reasons
}

/// How a part is found again in another report.
type Part = (&'static str, String);

/// What a counter of a pass or of the frame is made of, as far as a report tells.
fn parts(report: &Report, counter: &str, pass: Option<&str>) -> Vec<(Part, f64)> {
    let mut parts = Vec::new();
    if pass.is_none() {
        let of_passes = report.passes.iter().filter_map(|pass| {
            let value = pass.counters.get(counter)?.value.as_f64()?;
            Some((("pass", pass.name.clone()), value))
        });
        parts.extend(of_passes);
        if counter == "frame_time_ms" {
            let resources = report.stack.iter();
            parts.extend(resources.map(|part| (("resource", part.name.clone()), 1e3 * part.seconds)));
        }
    }
    for row in report.traffic.iter().filter(|row| pass.is_none_or(|pass| row.pass == pass)) {
        let of_buffer = ("pass and buffer", format!("{}: {}", row.pass, row.buffer));
        match counter {
            "dram_read_bytes" | "external_read_bytes" => parts.push((of_buffer, row.dram_read_bytes as f64)),
            "dram_write_bytes" => parts.push((of_buffer, row.dram_write_bytes as f64)),
            "l1_accesses" | "l1_misses" | "l2_accesses" | "l2_misses" => {
                let misses = counter.ends_with("misses");
                let counted = |level: &&LevelTraffic| {
                    level.role.as_ref().is_some_and(|role| counter.starts_with(role.as_str()))
                };
                parts.extend(row.levels.iter().filter(counted).map(|level| {
                    let lines = if misses { level.missed } else { level.lines };
                    let part = format!("{}: {} in {}", row.pass, row.buffer, level.name);
                    (("pass, buffer and level", part), lines as f64)
                }));
            }
            _ => {}
        }
    }
    parts
}

/// What accepted figures tell of a counter of the frame.
fn passes(baseline: &Baseline, counter: &str, pass: Option<&str>) -> Vec<(Part, f64)> {
    let of_pass = |name: &str| Some((("pass", name.to_owned()), baseline.figure(counter, Some(name))?));
    if pass.is_some() { Vec::new() } else { baseline.passes().into_iter().filter_map(of_pass).collect() }
}

/// The parts that matter most, with those of the baseline: what only one of both has is 0 in the other, if that has parts of this kind.
fn causes(now: Vec<(Part, f64)>, before: Option<&[(Part, f64)]>) -> Vec<Cause> {
    let known = |part: &Part, among: &[(Part, f64)]| {
        among.iter().find(|(other, _)| other == part).map(|(_, value)| *value)
    };
    let gone = before.into_iter().flatten().filter(|(part, _)| known(part, &now).is_none());
    let gone: Vec<(Part, f64)> = gone.map(|(part, _)| (part.clone(), 0.0)).collect();
    let mut causes: Vec<Cause> = now
        .into_iter()
        .chain(gone)
        .map(|((by, part), value)| {
            let kind = before.filter(|before| before.iter().any(|((other, _), _)| *other == by));
            let baseline = kind.map(|before| known(&(by, part.clone()), before).unwrap_or(0.0));
            Cause { by, part, value, baseline }
        })
        .collect();
    let weight = |cause: &Cause| cause.change().unwrap_or(cause.value).abs();
    causes.retain(|cause| weight(cause) > 0.0);
    // What can be compared comes first. Stable: parts that matter alike stay in the order of the report.
    let comparable = |cause: &Cause| cause.baseline.is_some();
    causes.sort_by(|a, b| comparable(b).cmp(&comparable(a)).then(weight(b).total_cmp(&weight(a))));
    causes.truncate(MOST_CAUSES);
    causes
}

/// One reason as a block of text.
pub(super) fn text(Why { counter, pass, unit, causes }: &Why) -> String {
    let place = pass.as_deref().unwrap_or("frame");
    let mut out = format!("\nwhy {counter} of the {place}, in {unit}\n");
    if causes.is_empty() {
        out.push_str("  the report does not tell of what it is made\n");
    }
    for Cause { by, part, value, baseline } in causes {
        let change = baseline.map_or(String::new(), |baseline| {
            format!(", {} from {}", signed(value - baseline), units::digits(baseline))
        });
        writeln!(out, "  {by}: {part}: {}{change}", units::digits(*value))
            .expect("a string takes every write");
    }
    out
}
