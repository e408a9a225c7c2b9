//! The values of a profiler's counters in one report.

use super::expression::Expression;
use super::figures;
use super::profiler::{Formula, Profiler, VendorInfo};
use crate::counters::{Counters, Value};
use crate::report::Report;
use crate::units;
use gpumodel::Gpu;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// A report's counters as the profiler of its GPU's maker names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VendorView {
    /// What the profiler is called.
    pub profiler: String,
    /// The whole frame, by name.
    pub counters: BTreeMap<String, VendorCounter>,
    /// The passes, in the order of the report's.
    pub passes: Vec<VendorPass>,
}

/// A profiler's counter.
#[derive(Clone, Debug, PartialEq)]
pub struct VendorCounter {
    /// The figure, or why there is none.
    pub value: Value,
    /// Its unit.
    pub unit: String,
    /// How it was made of ours; none where it never can be.
    pub formula: Option<String>,
}

/// A profiler's counters of one pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VendorPass {
    /// The pass.
    pub name: String,
    /// Figures by name; none where the pass does not have it.
    pub counters: BTreeMap<String, Option<f64>>,
}

impl VendorView {
    /// The counters of `report`, which `gpu` was asked for, as `profiler` names them.
    pub fn new(profiler: &Profiler, report: &Report, gpu: &Gpu) -> Self {
        let of_frame = |info: &VendorInfo| {
            let formula = match &info.formula {
                Formula::Known(formula) => Some(formula.text().to_owned()),
                Formula::Absent { .. } => None,
            };
            let value = value(info, &report.counters, gpu);
            (info.name.clone(), VendorCounter { value, unit: info.unit.clone(), formula })
        };
        let made = || profiler.counters.iter().filter(|info| matches!(info.formula, Formula::Known(_)));
        let of_pass = |pass: &crate::report::Pass| VendorPass {
            name: pass.name.clone(),
            counters: made()
                .map(|info| (info.name.clone(), value(info, &pass.counters, gpu).as_f64()))
                .collect(),
        };
        Self {
            profiler: profiler.name.clone(),
            counters: profiler.counters.iter().map(of_frame).collect(),
            passes: report.passes.iter().map(of_pass).collect(),
        }
    }
}

/// A counter of ours that is passed on as it is keeps its exact count.
fn value(info: &VendorInfo, counters: &Counters, gpu: &Gpu) -> Value {
    let known = match &info.formula {
        Formula::Absent { reason } => return Value::Absent { reason: reason.clone() },
        Formula::Known(known) => known,
    };
    let formula = &known.expression;
    if let Some(counter) = formula.only_name().and_then(|name| counters.get(name)) {
        return counter.value.clone();
    }
    let named = |name: &str| match counters.get(name) {
        Some(counter) => match &counter.value {
            Value::Absent { reason } if known.renames() == Some(name) => Err(reason.clone()),
            Value::Absent { reason } => {
                let title = units::counter_info(name).map_or(name, |info| info.name);
                Err(format!("{title}: {reason}"))
            }
            value => Ok(value.as_f64().expect("what is not absent is a figure")),
        },
        None => figures::value(gpu, name),
    };
    match formula.evaluate(named) {
        Ok(figure) if is_count(formula, counters, figure) => Value::Count(figure as u64),
        Ok(figure) => Value::Real(figure),
        Err(reason) => Value::Absent { reason },
    }
}

/// Whether a whole number was made of counts only.
fn is_count(formula: &Expression, counters: &Counters, figure: f64) -> bool {
    const EXACT: f64 = (1_u64 << 53) as f64;
    let mut ours = formula.names().filter_map(|name| counters.get(name)).peekable();
    let whole = figure.fract() == 0.0 && (0.0..=EXACT).contains(&figure);
    whole && ours.peek().is_some() && ours.all(|counter| matches!(counter.value, Value::Count(_)))
}

/// The counter as it stands in JSON: `value` is null exactly where `reason` is there.
#[derive(Serialize, Deserialize)]
struct Raw {
    value: Option<serde_json::Number>,
    unit: String,
    formula: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl Serialize for VendorCounter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (value, reason) = match &self.value {
            Value::Count(count) => (Some((*count).into()), None),
            Value::Real(real) => (serde_json::Number::from_f64(*real), None),
            Value::Absent { reason } => (None, Some(reason.clone())),
        };
        Raw { value, unit: self.unit.clone(), formula: self.formula.clone(), reason }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for VendorCounter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Raw { value, unit, formula, reason } = Raw::deserialize(deserializer)?;
        let value = match (value, reason) {
            (Some(number), None) => match (number.as_u64(), number.as_f64()) {
                (Some(count), _) => Value::Count(count),
                (None, Some(real)) => Value::Real(real),
                (None, None) => return Err(D::Error::custom("a figure is beyond what a number can hold")),
            },
            (None, Some(reason)) => Value::Absent { reason },
            _ => {
                return Err(D::Error::custom(
                    "a counter has either a figure or the reason why there is none",
                ));
            }
        };
        Ok(Self { value, unit, formula })
    }
}
