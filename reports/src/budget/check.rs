//! Whether a report keeps a budget.

use super::baseline::Baseline;
use super::file::{Budget, Change, Limit, Rule, Selection};
use super::why::{self, Why};
use crate::counters::{Counter, Counters, Fidelity, Value};
use crate::error::Error;
use crate::report::{Inputs, Report};
use serde::Serialize;

/// What breaking a limit means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A warning.
    Soft,
    /// The check fails.
    Hard,
}

/// How a limit fared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Kept.
    Pass,
    /// Broken.
    Fail,
    /// The rule needs a baseline, and there is none.
    NotCompared,
}

/// One limit and how it fared.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The limit.
    pub limit: Limit,
    /// The figure.
    pub value: Value,
    /// Where it is of a sample and not exact: its interval of 95 %, endless where none is known.
    pub interval: Option<[f64; 2]>,
    /// Its unit.
    pub unit: String,
    /// The baseline's figure, where there is a baseline that has it.
    pub baseline: Option<f64>,
    /// How the limit fared.
    pub outcome: Outcome,
}

impl Row {
    /// Whether all of the figure's interval fares as the figure does.
    pub fn is_decided(&self) -> bool {
        let fares = |end: f64| outcome(self.limit.rule, end, self.baseline) == self.outcome;
        self.interval.is_none_or(|ends| ends.into_iter().all(fares))
    }

    /// Figure minus baseline.
    pub fn change(&self) -> Option<f64> {
        Some(self.value.as_f64()? - self.baseline?)
    }

    /// The change in percent of the baseline; none where that is 0.
    pub fn percent(&self) -> Option<f64> {
        self.baseline
            .filter(|&baseline| baseline != 0.0)
            .and_then(|baseline| Some(self.change()? / baseline * 100.0))
    }
}

/// A frame held against the limits that are for it.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedFrame {
    /// Its name in the budget, or that of its scene.
    pub name: String,
    /// Scene, GPU and technique in words.
    pub title: String,
    /// In file order.
    pub rows: Vec<Row>,
    /// In what the baseline's inputs differ from the report's, in sentences: such a comparison may mean little.
    pub stale: Vec<String>,
    /// Why limits are broken, where that was asked.
    pub reasons: Option<Vec<Why>>,
}

/// A budget held against all its frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Its file.
    pub file: String,
    /// At least one.
    pub frames: Vec<CheckedFrame>,
    /// What is stale about the baseline as a whole, in sentences.
    pub stale_baseline: Vec<String>,
    /// Number of limits that are for none of these frames.
    pub passed_over: usize,
}

impl CheckedFrame {
    /// Whether no limit is left open by a sample.
    pub fn is_decided(&self) -> bool {
        self.rows.iter().all(Row::is_decided)
    }

    /// Adds why limits are broken.
    #[must_use]
    pub fn explained(self, report: &Report, baseline: Option<&Baseline>) -> Self {
        let reasons = Some(why::reasons(&self.rows, report, baseline));
        Self { reasons, ..self }
    }

    /// Why a row's limit is broken, where that was asked.
    pub(super) fn reason(&self, row: &Row) -> Option<&Why> {
        let of_limit = |reason: &&Why| reason.counter == row.limit.counter && reason.pass == row.limit.pass;
        self.reasons.iter().flatten().find(of_limit).filter(|_| row.outcome == Outcome::Fail)
    }
}

impl Checked {
    /// Limits of which a sample leaves open whether they are kept, each with its frame.
    pub fn open(&self) -> impl Iterator<Item = (&CheckedFrame, &Row)> {
        self.rows().filter(|(_, row)| !row.is_decided())
    }

    /// All rows, each with its frame.
    pub(super) fn rows(&self) -> impl Iterator<Item = (&CheckedFrame, &Row)> {
        self.frames.iter().flat_map(|frame| frame.rows.iter().map(move |row| (frame, row)))
    }

    /// Number of rows.
    pub(super) fn count(&self, is: impl Fn(&Row) -> bool) -> usize {
        self.rows().filter(|(_, row)| is(row)).count()
    }

    /// Number of broken limits of that severity.
    pub fn failures(&self, severity: Severity) -> usize {
        self.count(|row| row.outcome == Outcome::Fail && row.limit.severity == severity)
    }

    /// In what baselines differ from the frames, with the frame's name where there are several.
    pub fn stale(&self) -> Vec<String> {
        let told = |frame: &CheckedFrame, sentence: &String| match self.frames.len() {
            1 => sentence.clone(),
            _ => format!("{}: {sentence}", frame.name),
        };
        let of_frames =
            self.frames.iter().flat_map(|frame| frame.stale.iter().map(move |each| told(frame, each)));
        of_frames.chain(self.stale_baseline.iter().cloned()).collect()
    }
}

impl Selection {
    /// Whether a limit is for the frame of that name and report.
    fn selects(&self, name: &str, inputs: &Inputs) -> bool {
        let is = |wanted: &Option<String>, given: &str| wanted.as_ref().is_none_or(|wanted| wanted == given);
        let Self { frame, scene, gpu, technique } = self;
        is(frame, name)
            && is(scene, &inputs.scene)
            && is(gpu, &inputs.gpu)
            && is(technique, &inputs.technique)
    }
}

impl Budget {
    /// Holds the limits that are for the frame called `name` against its report, changes against `baseline`. Without a baseline, rules
    /// about changes are not compared.
    ///
    /// # Errors
    /// When the report lacks a counter or a pass that the budget limits; the error gives the reason of the absence.
    pub fn check(
        &self,
        name: &str,
        report: &Report,
        baseline: Option<&Baseline>,
    ) -> Result<CheckedFrame, Error> {
        let inputs = &report.inputs;
        let chosen = self.limits.iter().filter(|limit| limit.selection.selects(name, inputs));
        let rows = chosen.map(|limit| self.row(limit, report, baseline)).collect::<Result<Vec<_>, _>>()?;
        let mut stale = baseline.map_or_else(Vec::new, |baseline| differences(report, baseline));
        stale.extend(baseline.is_some().then(|| lacking(&rows)).flatten());
        Ok(CheckedFrame {
            name: name.to_owned(),
            title: format!("{} on {}, {}", inputs.scene, inputs.gpu, inputs.technique),
            rows,
            stale,
            reasons: None,
        })
    }

    /// Puts all its frames together, with what is stale about the baseline as a whole.
    ///
    /// # Errors
    /// When a limit is for none of them: where the budget names its frames, any limit; else when all are for others.
    pub fn checked(&self, frames: Vec<CheckedFrame>, stale_baseline: Vec<String>) -> Result<Checked, Error> {
        let used = |limit: &Limit| frames.iter().flat_map(|frame| &frame.rows).any(|row| row.limit == *limit);
        let unused = self.limits.iter().find(|limit| !used(limit));
        let all_unused = frames.iter().all(|frame| frame.rows.is_empty());
        if let Some(limit) = unused.filter(|_| all_unused || !self.frames.is_empty()) {
            let titles: Vec<String> =
                frames.iter().map(|frame| format!("{} ({})", frame.name, frame.title)).collect();
            let problem =
                format!("the limit on {} is for none of these frames: {}", limit.counter, titles.join("; "));
            let remedy = "correct its frame, scene, gpu or technique";
            return Err(Error::at_line(&self.file, limit.line, problem, remedy));
        }
        let passed_over = self.limits.iter().filter(|limit| !used(limit)).count();
        Ok(Checked { file: self.file.clone(), frames, stale_baseline, passed_over })
    }

    fn row(&self, limit: &Limit, report: &Report, baseline: Option<&Baseline>) -> Result<Row, Error> {
        let refuse =
            |problem: String, remedy: &str| Err(Error::at_line(&self.file, limit.line, problem, remedy));
        let id = &limit.counter;
        let Some(counters) = counters_of(limit, report) else {
            let known: Vec<&str> = report.passes.iter().map(|pass| pass.name.as_str()).collect();
            let pass = limit.pass.as_deref().unwrap_or_default();
            return refuse(
                format!("the report has no pass '{pass}'"),
                &format!("use one of: {}; or leave pass out for the whole frame", known.join(", ")),
            );
        };
        let place = limit.pass.as_ref().map_or_else(|| "frame".to_owned(), |pass| format!("pass '{pass}'"));
        let Some(counter) = counters.get(id) else {
            return refuse(
                format!("the {place} of this report has no counter {id}"),
                "remove the limit, or limit it where the report has it",
            );
        };
        let Some(value) = counter.value.as_f64() else {
            let reason = match &counter.value {
                Value::Absent { reason } => reason.trim_end_matches('.'),
                _ => "it has no figure",
            };
            return refuse(
                format!("{id} is absent from the {place}: {reason}"),
                "remove the limit, or check a scene and GPU that have it",
            );
        };
        let baseline = baseline.and_then(|baseline| baseline.figure(id, limit.pass.as_deref()));
        Ok(Row {
            limit: limit.clone(),
            value: counter.value.clone(),
            interval: interval(counter),
            unit: counter.unit.clone(),
            baseline,
            outcome: outcome(limit.rule, value, baseline),
        })
    }
}

fn interval(counter: &Counter) -> Option<[f64; 2]> {
    let ends = match (counter.from, counter.ci95) {
        (Fidelity::Sampled, None) => [f64::NEG_INFINITY, f64::INFINITY],
        (_, ends) => ends?,
    };
    (ends[0] < ends[1]).then_some(ends)
}

/// How a figure fares.
fn outcome(rule: Rule, value: f64, baseline: Option<f64>) -> Outcome {
    match rule.holds(value, baseline) {
        Some(true) => Outcome::Pass,
        Some(false) => Outcome::Fail,
        None => Outcome::NotCompared,
    }
}

impl Rule {
    /// Whether the rule holds; `None` where it needs a baseline and there is none.
    fn holds(self, value: f64, baseline: Option<f64>) -> Option<bool> {
        let within = |change: f64, most: Change, baseline: f64| match most {
            Change::Absolute(most) => change <= most,
            // Multiplied out, so that a baseline of 0 allows no change and 5 % of 100 is not rounded.
            Change::Percent(most) => change * 100.0 <= most * baseline.abs(),
        };
        let beyond = |change: f64, least: Change, baseline: f64| match least {
            Change::Absolute(least) => change >= least,
            Change::Percent(least) => change * 100.0 >= least * baseline.abs(),
        };
        match self {
            Self::Max(most) => Some(value <= most),
            Self::Min(least) => Some(value >= least),
            Self::MaxIncrease(most) => baseline.map(|baseline| within(value - baseline, most, baseline)),
            Self::MaxDecrease(most) => baseline.map(|baseline| within(baseline - value, most, baseline)),
            Self::MinIncrease(least) => baseline.map(|baseline| beyond(value - baseline, least, baseline)),
            Self::MinDecrease(least) => baseline.map(|baseline| beyond(baseline - value, least, baseline)),
        }
    }
}

fn counters_of<'a>(limit: &Limit, report: &'a Report) -> Option<&'a Counters> {
    match &limit.pass {
        None => Some(&report.counters),
        Some(pass) => report.pass(pass).map(|pass| &pass.counters),
    }
}

/// Counters that a baseline lacks although a limit needs them, in a sentence.
fn lacking(rows: &[Row]) -> Option<String> {
    let lacking = rows.iter().filter(|row| row.outcome == Outcome::NotCompared);
    let mut names: Vec<&str> = lacking.map(|row| row.limit.counter.as_str()).collect();
    names.dedup();
    (!names.is_empty()).then(|| format!("the baseline has no figure of {}; accept it anew", names.join(", ")))
}

fn differences(report: &Report, baseline: &Baseline) -> Vec<String> {
    let object = |inputs: &Inputs| match serde_json::to_value(inputs) {
        Ok(serde_json::Value::Object(fields)) => fields,
        _ => unreachable!("inputs are a struct of plain fields"),
    };
    let (ours, theirs) = (object(&report.inputs), object(baseline.inputs()));
    let mut sentences = Vec::new();
    if report.tool != baseline.tool() {
        sentences.push(format!(
            "the baseline was made by {}, this report by {}",
            baseline.tool(),
            report.tool
        ));
    }
    if matches!(baseline, Baseline::Report(report) if report.is_sampled()) {
        sentences.push("the baseline's figures are of a sample".to_owned());
    }
    // It draws a sample, and is no part of the frame.
    for (key, value) in ours.iter().filter(|(key, _)| *key != "seed") {
        if let Some(other) = theirs.get(key).filter(|&other| other != value) {
            sentences.push(format!("inputs.{key} is {other} in the baseline and {value} here"));
        }
    }
    sentences
}
