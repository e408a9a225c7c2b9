//! The values of the counters.

use super::table::{COUNTERS, CounterInfo};

/// A counter's value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number, exact.
    Count(u64),
    /// A finite number.
    Real(f64),
    /// There is none.
    Absent {
        /// Why.
        reason: String,
    },
}

impl Value {
    /// A share or mean; absent with `reason` when there is nothing to divide by.
    pub(crate) fn ratio(numerator: f64, denominator: f64, reason: &str) -> Self {
        if denominator > 0.0 {
            Self::Real(numerator / denominator)
        } else {
            Self::Absent { reason: reason.to_owned() }
        }
    }

    /// No value.
    pub(crate) fn absent(reason: &str) -> Self {
        Self::Absent { reason: reason.to_owned() }
    }

    /// The value as a number.
    pub fn number(&self) -> Option<f64> {
        match *self {
            Self::Count(count) => Some(count as f64),
            Self::Real(real) => Some(real),
            Self::Absent { .. } => None,
        }
    }
}

/// A value for each of [`COUNTERS`].
#[derive(Clone, Debug, PartialEq)]
pub struct CounterSet {
    values: Vec<Value>,
}

impl CounterSet {
    /// Asks `value` for each counter, by id.
    pub(crate) fn new(value: impl Fn(&str) -> Value) -> Self {
        Self { values: COUNTERS.iter().map(|counter| value(counter.id)).collect() }
    }

    /// The counter of that id.
    pub fn get(&self, id: &str) -> Option<&Value> {
        self.iter().find(|(counter, _)| counter.id == id).map(|(_, value)| value)
    }

    /// All counters, in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = (&'static CounterInfo, &Value)> {
        COUNTERS.iter().zip(&self.values)
    }
}
