//! The figures of one point, as they lie in its file.

use crate::counters::Counters;
use crate::error::Error;
use crate::report::{Inputs, Pass, Report};
use crate::within::Within;
use serde::{Deserialize, Serialize};

/// Version of the form of the file.
pub(super) const SCHEMA: u32 = 1;

/// What a frame costs, without what depends on who found it and when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figures {
    pub(super) schema: u32,
    /// Hash of the point's inputs.
    pub point: String,
    /// Program and version.
    pub tool: String,
    /// What was asked.
    pub inputs: Inputs,
    /// How far the figures may be from those of a more faithful rung, as in a report.
    pub within: Option<Within>,
    /// The whole frame.
    pub counters: Counters,
    /// Its passes.
    pub passes: Vec<Pass>,
}

impl Figures {
    /// Those of a report, for the point of that hash.
    pub fn of(point: &str, report: &Report) -> Self {
        Self {
            schema: SCHEMA,
            point: point.to_owned(),
            tool: report.tool.clone(),
            inputs: report.inputs.clone(),
            within: report.run.within.clone(),
            counters: report.counters.clone(),
            passes: report.passes.clone(),
        }
    }

    /// As a file.
    ///
    /// # Panics
    /// Never: all of it has a form in JSON.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("figures have string keys and finite numbers") + "\n"
    }

    /// Reads what [`Self::text`] wrote; `file` names it in errors.
    ///
    /// # Errors
    /// When the text is torn, or of another schema.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        const REMEDY: &str = "remove the file; the point is then replayed again";
        let figures: Self = serde_json::from_str(text).map_err(|error| {
            Error::at_line(file, error.line(), format!("not figures of a point: {error}"), REMEDY)
        })?;
        if figures.schema != SCHEMA {
            let problem = format!("figures of schema {}, expected {SCHEMA}", figures.schema);
            return Err(Error::new(file, problem, REMEDY));
        }
        Ok(figures)
    }
}
