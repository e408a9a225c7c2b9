//! What limits on changes are held against: an earlier report, or the figures of one that were accepted.
//!
//! ```toml
//! [cornell]                      # the frame's name in the budget, or its scene
//! tool = "raybudget 0.1.0"
//!
//! [cornell.inputs]               # as in the report
//! scene = "cornell"
//!
//! [cornell.frame]
//! node_fetches = 87890391
//!
//! [cornell.passes."primary rays"]
//! node_fetches = 49131229
//! ```

use super::file::{Budget, refusal};
use crate::counters::{Counters, Value};
use crate::error::Error;
use crate::report::{Inputs, Report};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Figures by counter.
type Figures = BTreeMap<String, Figure>;

/// A count, or any other number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number")]
enum Figure {
    Count(u64),
    Real(f64),
}

/// Figures of one frame that were accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AcceptedFrame {
    /// Program and version.
    tool: String,
    /// What was asked.
    inputs: Inputs,
    /// Of the whole frame.
    #[serde(default)]
    frame: Figures,
    /// By pass.
    #[serde(default)]
    passes: BTreeMap<String, Figures>,
}

/// Figures that were accepted, by name of the frame: those of the counters that a budget limits, small enough to be reviewed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Accepted {
    frames: BTreeMap<String, AcceptedFrame>,
}

/// What stands at the head of a file of accepted figures.
const HEADING: &str = "# Figures that limits on changes are held against: raybudget check --baseline. Written by raybudget check --accept; review a change of \
                       it as one of code.\n\n";

impl AcceptedFrame {
    /// The figures of all counters that `budget` limits, of the frame and of each pass that has them.
    fn of(report: &Report, budget: &Budget) -> Self {
        let limited: BTreeSet<&str> = budget.limits.iter().map(|limit| limit.counter.as_str()).collect();
        let figures = |counters: &Counters| -> Figures {
            let figure = |value: &Value| match value {
                Value::Count(count) => Some(Figure::Count(*count)),
                Value::Real(real) => Some(Figure::Real(*real)),
                Value::Absent { .. } => None,
            };
            let of_budget = counters.iter().filter(|(id, _)| limited.contains(id));
            of_budget.filter_map(|(id, counter)| Some((id.to_owned(), figure(&counter.value)?))).collect()
        };
        let passes = report.passes.iter().map(|pass| (pass.name.clone(), figures(&pass.counters)));
        Self {
            tool: report.tool.clone(),
            inputs: report.inputs.clone(),
            frame: figures(&report.counters),
            passes: passes.filter(|(_, figures)| !figures.is_empty()).collect(),
        }
    }
}

impl Accepted {
    /// Adds the figures of a frame.
    pub fn add(&mut self, name: &str, report: &Report, budget: &Budget) {
        self.frames.insert(name.to_owned(), AcceptedFrame::of(report, budget));
    }

    /// The only frame.
    pub fn only(&self) -> Option<&AcceptedFrame> {
        self.frames.values().next().filter(|_| self.frames.len() == 1)
    }

    /// The frame of that name.
    pub fn frame(&self, name: &str) -> Option<&AcceptedFrame> {
        self.frames.get(name)
    }

    /// Names of all frames.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.frames.keys().map(String::as_str)
    }

    /// Reads the text of such a file; `file` names it in errors.
    ///
    /// # Errors
    /// On TOML that is none, with its line.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        const REMEDY: &str = "write it anew with raybudget check --accept";
        let accepted: Self = toml::from_str(text).map_err(|error| refusal(text, file, &error, REMEDY))?;
        match accepted.not_finite() {
            Some((frame, counter)) => {
                Err(Error::new(file, format!("{counter} of '{frame}' is no finite number"), REMEDY))
            }
            None => Ok(accepted),
        }
    }

    /// Frame and counter of a figure that is no number.
    fn not_finite(&self) -> Option<(&str, &str)> {
        self.frames.iter().find_map(|(name, frame)| {
            let mut all = frame.passes.values().chain([&frame.frame]).flatten();
            let is_finite = |figure: &Figure| match figure {
                Figure::Count(_) => true,
                Figure::Real(real) => real.is_finite(),
            };
            let (counter, _) = all.find(|(_, figure)| !is_finite(figure))?;
            Some((name.as_str(), counter.as_str()))
        })
    }

    /// As a file.
    ///
    /// # Panics
    /// Never: all of it has a form in TOML.
    pub fn text(&self) -> String {
        let text = toml::to_string(self).expect("names and numbers have a form in TOML");
        format!("{HEADING}{text}")
    }
}

/// What a report is compared with.
#[derive(Clone, Debug, PartialEq)]
pub enum Baseline {
    /// A whole report.
    Report(Box<Report>),
    /// Its accepted figures.
    Accepted(Box<AcceptedFrame>),
}

impl Baseline {
    /// Program and version that made it.
    pub(super) fn tool(&self) -> &str {
        match self {
            Self::Report(report) => &report.tool,
            Self::Accepted(accepted) => &accepted.tool,
        }
    }

    /// What was asked.
    pub(super) fn inputs(&self) -> &Inputs {
        match self {
            Self::Report(report) => &report.inputs,
            Self::Accepted(accepted) => &accepted.inputs,
        }
    }

    /// A counter of a pass, or of the whole frame.
    pub(super) fn figure(&self, counter: &str, pass: Option<&str>) -> Option<f64> {
        match self {
            Self::Report(report) => {
                let counters = match pass {
                    None => &report.counters,
                    Some(pass) => &report.pass(pass)?.counters,
                };
                counters.get(counter)?.value.as_f64()
            }
            Self::Accepted(accepted) => {
                let figures = match pass {
                    None => &accepted.frame,
                    Some(pass) => accepted.passes.get(pass)?,
                };
                figures.get(counter).map(|figure| match *figure {
                    Figure::Count(count) => count as f64,
                    Figure::Real(real) => real,
                })
            }
        }
    }

    /// Names of its passes.
    pub(super) fn passes(&self) -> Vec<&str> {
        match self {
            Self::Report(report) => report.passes.iter().map(|pass| pass.name.as_str()).collect(),
            Self::Accepted(accepted) => accepted.passes.keys().map(String::as_str).collect(),
        }
    }

    /// The whole report, where it is one.
    pub(super) fn report(&self) -> Option<&Report> {
        match self {
            Self::Report(report) => Some(report),
            Self::Accepted(_) => None,
        }
    }
}
