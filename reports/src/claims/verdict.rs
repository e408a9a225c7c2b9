//! What became of a claim.

use super::model::Kind;
use serde::Serialize;

/// Of a claim or a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Every test holds.
    Reproduced,
    /// A test fails.
    NotReproduced,
    /// No test fails, and one could not be decided.
    Untestable,
}

impl Outcome {
    /// As it stands in JSON and CSV.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "not_reproduced",
            Self::Untestable => "untestable",
        }
    }
}

/// A figure that a verdict rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Name of the scene.
    pub scene: String,
    /// Name of the variant that the case sets, where it sets one.
    pub each: Option<String>,
    /// Name of the variant.
    pub variant: String,
    /// The metric, or one over another.
    pub metric: String,
    /// What was measured.
    pub value: f64,
}

/// A claim held against measurements. The outcome is that of its tests as the file has them; readings stand beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Id of the claim.
    pub id: String,
    /// What the paper states.
    pub statement: String,
    /// Section, figure or table.
    #[serde(rename = "where")]
    pub place: String,
    /// What it is about.
    pub kind: Kind,
    /// What became of it.
    pub outcome: Outcome,
    /// The figures that decided it; `None` where there are none.
    pub ours: Option<String>,
    /// The paper's.
    pub published: Option<String>,
    /// Relative error farthest from 0 against the paper's figures; `None` where it has none.
    pub error: Option<f64>,
    /// One line: the figures, what was wanted, in how many cases it holds.
    pub why: String,
    /// Misprints and assumptions.
    pub note: Option<String>,
    /// The part of the statement that no test covers, and why.
    pub untested: Option<String>,
    /// Other readings.
    pub readings: Vec<ReadingVerdict>,
    /// The stand-ins among the scenes, as "role: built-in".
    pub stand_ins: Vec<String>,
    /// Every figure that was compared.
    pub figures: Vec<Figure>,
}

/// A reading held against measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReadingVerdict {
    /// Its name.
    pub name: String,
    /// Why one may read it so.
    pub assumption: String,
    /// What became of it.
    pub outcome: Outcome,
    /// The figures that decided it.
    pub ours: Option<String>,
    /// As for a claim.
    pub why: String,
}
