//! Errors over rows of measurements, inputs apart from predictions.

use super::file::Kind;
use super::verdict::RowVerdict;
use serde::Serialize;

/// Largest mean error over rows of latency, of bandwidth, and of power.
const LIMITS: [(Kind, f64); 3] = [(Kind::Latency, 0.10), (Kind::Bandwidth, 0.20), (Kind::Power, 0.20)];

/// Errors of rows of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Of the rows.
    pub kind: Kind,
    /// All rows that are not [apart](super::Apart), those of them that are inputs of their preset, or those that are not.
    pub rows: &'static str,
    /// How many.
    pub count: usize,
    /// Mean absolute error.
    pub mean: f64,
    /// Largest absolute error, and whose.
    pub worst: f64,
    /// The row of the largest error.
    pub worst_row: String,
    /// The limit on the mean, where there is one.
    pub limit: Option<f64>,
}

/// Errors over all rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Latency, bandwidth and power: all rows, inputs, predictions.
    pub groups: Vec<Group>,
    /// Rows that keep their limits.
    pub passed: usize,
    /// Rows.
    pub count: usize,
}

impl Group {
    /// Whether the mean keeps its limit.
    pub fn passes(&self) -> bool {
        self.limit.is_none_or(|limit| self.mean <= limit)
    }
}

impl Summary {
    /// Of these verdicts.
    pub fn new(verdicts: &[RowVerdict]) -> Self {
        let mut groups = Vec::new();
        for (kind, limit) in LIMITS {
            for (rows, wanted, limit) in [
                ("all rows", None, Some(limit)),
                ("inputs", Some(true), None),
                ("predictions", Some(false), None),
            ] {
                let of_kind = verdicts.iter().filter(|verdict| {
                    let counts = verdict.kind == kind && verdict.apart.is_none();
                    counts && wanted.is_none_or(|input| input != verdict.inputs.is_empty())
                });
                let errors: Vec<(f64, &str)> =
                    of_kind.filter_map(|verdict| Some((verdict.error?.abs(), verdict.id.as_str()))).collect();
                let Some(&(worst, id)) = errors.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
                let mean = errors.iter().map(|(error, _)| error).sum::<f64>() / errors.len() as f64;
                let (count, worst_row) = (errors.len(), id.to_owned());
                groups.push(Group { kind, rows, count, mean, worst, worst_row, limit });
            }
        }
        let passed = verdicts.iter().filter(|verdict| verdict.outcome).count();
        Self { groups, passed, count: verdicts.len() }
    }

    /// Whether every row and every mean keeps its limit.
    pub fn passes(&self) -> bool {
        self.passed == self.count && self.groups.iter().all(Group::passes)
    }
}
