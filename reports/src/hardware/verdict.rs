//! A row beside what the model says.

use super::file::{Apart, Kind, Published, Quantity, Row};
use super::power::memory_of;
use gpumodel::Fidelity;
use gpumodel::kernel::Observation;
use serde::{Serialize, Serializer};

/// Largest error of a row of latency, as a part of what was published.
const LATENCY_LIMIT: f64 = 0.10;
/// The same of bandwidth, divergence and power.
const BANDWIDTH_LIMIT: f64 = 0.20;
/// Slowdowns lie within this factor.
const RATIO_LIMIT: f64 = 1.5;
/// Traffic that is none is a step from at least this part of the largest of the sweep.
const NOTHING: f64 = 0.01;

/// What the model says of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// A value of the row's quantity.
    Value(f64),
    /// The place of a knee in the row's sweep.
    Knee(usize),
    /// Whether the sweep never falls.
    Monotone(bool),
}

/// A number with its unit, for eyes and for programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// The number; of a range, its middle.
    pub value: f64,
    /// The number or the range with its unit.
    pub text: String,
}

/// A row beside what the model says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowVerdict {
    /// Of the row.
    pub id: String,
    /// Of the row.
    pub gpu: String,
    /// Of the row.
    pub statement: String,
    /// Of the row.
    pub kind: Kind,
    /// Whether the row keeps its limit.
    #[serde(serialize_with = "outcome")]
    pub outcome: bool,
    /// What the judging rung says.
    pub ours: Figure,
    /// What was published.
    pub published: Option<Figure>,
    /// Relative difference from what was published, 0 within a range; of a knee, in steps of the sweep.
    pub error: Option<f64>,
    /// The other rungs: name, value and error.
    pub others: Vec<(String, Figure, Option<f64>)>,
    /// Of the row.
    pub apart: Option<Apart>,
    /// Figures of the description that were derived from this row.
    pub inputs: Vec<String>,
    /// Where it was published.
    pub source: String,
    /// What explains an error.
    pub why: String,
}

fn outcome<S: Serializer>(passed: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(if *passed { "pass" } else { "fail" })
}

impl Row {
    /// What the observations of [`Row::patterns`], in order, say.
    pub fn found(&self, observed: &[Observation]) -> Found {
        let memory = self.interface_gbs.and_then(|_| memory_of(&self.gpu).ok().flatten());
        let supply = memory.as_ref().map(|memory| (memory, self.rail.as_deref().unwrap_or_default()));
        let values: Vec<f64> = observed.iter().map(|observed| self.quantity.of(observed, supply)).collect();
        match self.kind {
            Kind::Knee => Found::Knee(steepest(&values)),
            Kind::Monotone => Found::Monotone(values.is_sorted()),
            _ => Found::Value(match (self.quantity, values.as_slice()) {
                (Quantity::TimeRatio, [this, over, ..]) => this / over,
                _ => values.first().copied().unwrap_or(f64::NAN),
            }),
        }
    }

    /// Compares what the judging rung found, and what others did, with what was published.
    pub fn judge(&self, judge: Found, others: &[(Fidelity, Found)]) -> RowVerdict {
        let error = self.error(judge);
        let of_others = others
            .iter()
            .map(|&(fidelity, found)| (fidelity.name().to_owned(), self.figure(found), self.error(found)));
        RowVerdict {
            id: self.id.clone(),
            gpu: self.gpu.clone(),
            statement: self.statement.clone(),
            kind: self.kind,
            outcome: self.keeps_limit(judge, error),
            ours: self.figure(judge),
            published: self.published.map(|published| self.published_figure(published)),
            error,
            others: of_others.collect(),
            apart: self.apart,
            inputs: self.inputs.clone(),
            source: self.source.clone(),
            why: self.why.clone().unwrap_or_default(),
        }
    }

    fn keeps_limit(&self, found: Found, error: Option<f64>) -> bool {
        let within = |limit: f64| error.is_some_and(|error| error.abs() <= limit);
        match self.kind {
            Kind::Latency => within(LATENCY_LIMIT),
            Kind::Bandwidth | Kind::Divergence | Kind::Power => within(BANDWIDTH_LIMIT),
            Kind::Ratio => {
                error.is_some_and(|error| (1.0 / RATIO_LIMIT..=RATIO_LIMIT).contains(&(1.0 + error)))
            }
            Kind::Knee => within(1.0),
            Kind::Monotone => found == Found::Monotone(true),
        }
    }

    fn error(&self, found: Found) -> Option<f64> {
        let (low, high) = self.published?.ends();
        Some(match found {
            Found::Value(value) if value < low => value / low - 1.0,
            Found::Value(value) if value > high => value / high - 1.0,
            Found::Value(_) => 0.0,
            Found::Knee(place) => {
                let near = |&size: &u64| (low..=high).contains(&(size as f64));
                let first = self.footprints.iter().position(near)?;
                let last = self.footprints.iter().rposition(near)?;
                place as f64 - place.clamp(first, last) as f64
            }
            Found::Monotone(_) => return None,
        })
    }

    fn figure(&self, found: Found) -> Figure {
        match found {
            Found::Value(value) => {
                Figure { value, text: format!("{} {}", digits(value), self.quantity.unit()) }
            }
            Found::Knee(place) => {
                let bytes = self.footprints.get(place).copied().unwrap_or(0) as f64;
                Figure { value: bytes, text: kib(bytes) }
            }
            Found::Monotone(rises) => Figure {
                value: f64::from(u8::from(rises)),
                text: if rises { "rises" } else { "falls" }.to_owned(),
            },
        }
    }

    fn published_figure(&self, published: Published) -> Figure {
        let text = |value: f64| if self.kind == Kind::Knee { kib(value) } else { digits(value) };
        let (low, high) = published.ends();
        let mut words = if low == high { text(low) } else { format!("{} to {}", text(low), text(high)) };
        if self.kind != Kind::Knee {
            words = format!("{words} {}", self.quantity.unit());
        }
        Figure { value: published.middle(), text: words }
    }
}

/// The place before the largest rise, as a factor.
fn steepest(values: &[f64]) -> usize {
    let most = values.iter().copied().fold(0.0, f64::max);
    let rise = |pair: &[f64]| pair[1].max(most * NOTHING) / pair[0].max(most * NOTHING);
    let rises = values.windows(2).map(rise).enumerate();
    rises.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| place)
}

fn kib(bytes: f64) -> String {
    format!("{} KB", digits(bytes / 1024.0))
}

/// Four significant digits at most.
fn digits(value: f64) -> String {
    let decimals = if value.abs() >= 1000.0 {
        0
    } else if value.abs() >= 100.0 {
        1
    } else {
        2
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
