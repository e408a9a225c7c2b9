//! Counter values as a report holds them: a figure with its unit and origin, or the reason why there is none.

use serde::de::{self, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Which rung of the ladder of fidelity made a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fidelity {
    /// Closed forms from tree statistics and reuse-distance curves.
    Analytic,
    /// A designed sample of warps.
    Sampled,
    /// Every access through the exact caches.
    Replay,
    /// Event-driven simulation.
    Timed,
}

impl Fidelity {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Analytic => "analytic",
            Self::Sampled => "sampled",
            Self::Replay => "replay",
            Self::Timed => "timed",
        }
    }
}

/// What is known of a counter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// An exact count.
    Count(u64),
    /// A finite computed figure.
    Real(f64),
    /// The scene or the GPU does not have it.
    Absent {
        /// Why, in one sentence.
        reason: String,
    },
}

impl Value {
    /// The figure, rounded to the nearest double where it is a count beyond 2^53.
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Count(count) => Some(count as f64),
            Self::Real(real) => Some(real),
            Self::Absent { .. } => None,
        }
    }
}

/// One counter of a frame or of a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "RawCounter", try_from = "RawCounter")]
pub struct Counter {
    /// The figure, or why there is none.
    pub value: Value,
    /// Unit of the figure.
    pub unit: String,
    /// 95 % confidence interval, where the figure comes from a sample.
    pub ci95: Option<[f64; 2]>,
    /// What made the figure.
    pub from: Fidelity,
}

/// The counter as it stands in JSON: `value` is null exactly where `reason` is there.
#[derive(Serialize, Deserialize)]
struct RawCounter {
    value: Option<Number>,
    unit: String,
    ci95: Option<[f64; 2]>,
    from: Fidelity,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Number {
    Count(u64),
    Real(f64),
}

impl From<Counter> for RawCounter {
    fn from(Counter { value, unit, ci95, from }: Counter) -> Self {
        let (value, reason) = match value {
            Value::Count(count) => (Some(Number::Count(count)), None),
            Value::Real(real) => (Some(Number::Real(real)), None),
            Value::Absent { reason } => (None, Some(reason)),
        };
        Self { value, unit, ci95, from, reason }
    }
}

impl TryFrom<RawCounter> for Counter {
    type Error = &'static str;

    fn try_from(RawCounter { value, unit, ci95, from, reason }: RawCounter) -> Result<Self, Self::Error> {
        let value = match (value, reason) {
            (Some(Number::Count(count)), None) => Value::Count(count),
            (Some(Number::Real(real)), None) => Value::Real(real),
            (None, Some(reason)) => Value::Absent { reason },
            (None, None) => return Err("a counter without a value must give its reason"),
            (Some(_), Some(_)) => {
                return Err("a counter with a value must not give a reason for its absence");
            }
        };
        Ok(Self { value, unit, ci95, from })
    }
}

/// Counters by id, in the order of the table of counters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counters(Vec<(String, Counter)>);

impl Counters {
    /// The counter called `id`.
    pub fn get(&self, id: &str) -> Option<&Counter> {
        self.0.iter().find(|(known, _)| known == id).map(|(_, counter)| counter)
    }

    /// All counters in order, to be changed.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (&str, &mut Counter)> {
        self.0.iter_mut().map(|(id, counter)| (id.as_str(), counter))
    }

    /// All counters in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Counter)> {
        self.0.iter().map(|(id, counter)| (id.as_str(), counter))
    }
}

impl FromIterator<(String, Counter)> for Counters {
    fn from_iter<T: IntoIterator<Item = (String, Counter)>>(counters: T) -> Self {
        Self(counters.into_iter().collect())
    }
}

impl Serialize for Counters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (id, counter) in &self.0 {
            map.serialize_entry(id, counter)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Counters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Counters;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map of counters by id")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Counters, A::Error> {
                let mut counters = Counters::default();
                while let Some((id, counter)) = map.next_entry::<String, Counter>()? {
                    if counters.get(&id).is_some() {
                        return Err(de::Error::custom(format_args!("counter {id} is there twice")));
                    }
                    counters.0.push((id, counter));
                }
                Ok(counters)
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}
