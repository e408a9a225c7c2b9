//! The file of measurements.

use super::power::memory_of;
use crate::error::Error;
use gpumodel::energy::DramPower;
use gpumodel::kernel::{Observation, Pattern};
use gpumodel::{BuiltinGpu, CacheRole};
use serde::{Deserialize, Serialize};

/// The measurements that come with the program.
pub const MEASUREMENTS: &str = include_str!("../../../configs/hardware/measurements.toml");

/// A measurement of a real GPU.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Unique in the file.
    pub id: String,
    /// A description that comes with the program.
    pub gpu: String,
    /// What was measured.
    pub statement: String,
    /// What it is about, which decides its limit.
    pub kind: Kind,
    /// What is compared.
    pub quantity: Quantity,
    /// The access pattern.
    pub pattern: Pattern,
    /// The pattern that `quantity` relates to, for [`Quantity::TimeRatio`].
    pub over: Option<Pattern>,
    /// Bytes that the pattern goes over, one after the other: a knee is looked for.
    #[serde(default)]
    pub footprints: Vec<u64>,
    /// Blocks of the pattern, one after the other: the quantity must not fall.
    #[serde(default)]
    pub blocks: Vec<u32>,
    /// Of a row of power, 10^9 bytes per second through each interface of the memory, whose peak is set so.
    pub interface_gbs: Option<f64>,
    /// Of a row of [`Quantity::RailMw`], the supply.
    pub rail: Option<String>,
    /// What was found; nothing where only an order is known.
    pub published: Option<Published>,
    /// Why the row is in no mean of errors; none where it is.
    pub apart: Option<Apart>,
    /// Figures of the GPU's description that were derived from this row.
    #[serde(default)]
    pub inputs: Vec<String>,
    /// Where it was published.
    pub source: String,
    /// What explains an error.
    pub why: Option<String>,
}

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Time of a dependent load.
    Latency,
    /// Rate of independent loads.
    Bandwidth,
    /// Slowdown by the pattern of access.
    Ratio,
    /// Slowdown by lanes that part.
    Divergence,
    /// Size at which time or traffic steps.
    Knee,
    /// Order of times.
    Monotone,
    /// Power of memory.
    Power,
}

/// Why a row says nothing of how near the model is, and so is in no mean of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Apart {
    /// What was published is a formula that the model computes too: the row checks its implementation.
    Formula,
    /// What was published is a range, which is met or not at the one rate of the row: there is no error of a measurement.
    Range,
}

impl Apart {
    /// The reason as a sentence.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Formula => "checks the implementation of the published formula, and is in no mean",
            Self::Range => "states a range at one rate, and is in no mean",
        }
    }
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Nanoseconds per load of a lane.
    NsPerLoad,
    /// 10^9 bytes per second that lanes ask for.
    Gbs,
    /// 10^9 bytes per second of lines through the second level.
    L2Gbs,
    /// 10^9 bytes per second read from memory.
    ExternalGbs,
    /// Time over that of another pattern.
    TimeRatio,
    /// Milliwatts of one supply of one interface of the memory.
    RailMw,
    /// Picojoules per byte of the whole memory beyond what it takes idle: milliwatts per 10^9 bytes per second.
    PjPerByte,
}

/// A published figure or range.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Published {
    /// One figure.
    Figure(f64),
    /// Least and most.
    Range([f64; 2]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    row: Vec<Row>,
}

/// Reads and checks a file of measurements; `file` is for messages.
///
/// # Errors
/// When it is not TOML, has an unknown key, or a row contradicts itself.
pub fn parse(text: &str, file: &str) -> Result<Vec<Row>, Error> {
    let rows = toml::from_str::<File>(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let line = text[..at].lines().count().max(1);
        Error::at_line(file, line, error.message().to_owned(), "correct the file")
    })?;
    let mut known: Vec<&str> = Vec::new();
    for row in &rows.row {
        let refuse = |problem: String, remedy: &str| {
            Err(Error::new(format!("{file}: row '{}'", row.id), problem, remedy))
        };
        if known.contains(&row.id.as_str()) {
            return refuse("its id stands twice".to_owned(), "rename one of the rows");
        }
        known.push(&row.id);
        if BuiltinGpu::named(&row.gpu).is_none() {
            return refuse(format!("there is no GPU '{}'", row.gpu), "name one of `list gpus`");
        }
        if (row.quantity == Quantity::TimeRatio) != row.over.is_some() {
            return refuse("`over` belongs to time_ratio, and to nothing else".to_owned(), "correct either");
        }
        let sweeps = (row.footprints.is_empty(), row.blocks.is_empty());
        let expected = match row.kind {
            Kind::Knee => (false, true),
            Kind::Monotone => (true, false),
            _ => (true, true),
        };
        if sweeps != expected {
            let problem = "footprints are for a knee, blocks for a monotone row".to_owned();
            return refuse(problem, "correct the sweep or the kind");
        }
        let of_power = matches!(row.quantity, Quantity::RailMw | Quantity::PjPerByte);
        if of_power != (row.kind == Kind::Power)
            || of_power != row.interface_gbs.is_some()
            || (row.quantity == Quantity::RailMw) != row.rail.is_some()
        {
            let problem =
                "kind power goes with rail_mw or pj_per_byte and interface_gbs, and rail with rail_mw";
            return refuse(problem.to_owned(), "correct these keys");
        }
        if of_power {
            let Ok(Some(memory)) = memory_of(&row.gpu) else {
                return refuse(format!("the energy of {} is not known", row.gpu), "name another GPU");
            };
            let rails: Vec<&str> = memory.rails().iter().map(|rail| rail.name()).collect();
            if let Some(rail) = row.rail.as_deref().filter(|rail| !rails.contains(rail)) {
                return refuse(
                    format!("no supply is called '{rail}'"),
                    &format!("name one of: {}", rails.join(", ")),
                );
            }
            if !row.interface_gbs.is_some_and(|gbs| gbs > 0.0 && gbs.is_finite()) {
                return refuse("interface_gbs is no rate".to_owned(), "give a positive figure");
            }
        }
        match row.published {
            None if row.kind != Kind::Monotone => {
                return refuse("nothing is published".to_owned(), "give `published`");
            }
            Some(published) => {
                let (low, high) = published.ends();
                if !(low >= 0.0 && low <= high && high.is_finite()) {
                    return refuse(format!("{low} to {high} is no range"), "give two rising figures");
                }
            }
            None => {}
        }
    }
    Ok(rows.row)
}

impl Row {
    /// The patterns that it measures, in order.
    pub fn patterns(&self) -> Vec<Pattern> {
        match self.kind {
            Kind::Knee => self.footprints.iter().map(|&bytes| self.pattern.with_footprint(bytes)).collect(),
            Kind::Monotone => self.blocks.iter().map(|&edge| self.pattern.with_block(edge)).collect(),
            _ => std::iter::once(self.pattern.clone()).chain(self.over.clone()).collect(),
        }
    }
}

impl Published {
    /// Least and most.
    pub fn ends(self) -> (f64, f64) {
        match self {
            Self::Figure(figure) => (figure, figure),
            Self::Range([low, high]) => (low, high),
        }
    }

    /// One figure for it: of a range, its middle.
    pub fn middle(self) -> f64 {
        let (low, high) = self.ends();
        low.midpoint(high)
    }
}

impl Quantity {
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::NsPerLoad => "ns",
            Self::Gbs | Self::L2Gbs | Self::ExternalGbs => "GB/s",
            Self::TimeRatio => "x",
            Self::RailMw => "mW",
            Self::PjPerByte => "pJ/B",
        }
    }

    /// Of what a probe measured, and for power of the memory it was measured on and one of its supplies; a ratio is the caller's to form from times per
    /// load.
    pub(super) fn of(self, observed: &Observation, memory: Option<(&DramPower, &str)>) -> f64 {
        let rate = observed.memory_traffic_per_second();
        match self {
            Self::NsPerLoad => observed.seconds_per_load() * 1e9,
            Self::TimeRatio => observed.seconds_per_load(),
            Self::Gbs => observed.bytes_per_second() / 1e9,
            Self::L2Gbs => observed.cache_bytes_per_second(CacheRole::L2) / 1e9,
            Self::ExternalGbs => observed.memory_bytes_per_second() / 1e9,
            Self::RailMw => memory.map_or(f64::NAN, |(memory, rail)| rail_milliwatts(memory, rail, rate)),
            Self::PjPerByte => {
                memory.map_or(f64::NAN, |(memory, _)| (memory.watts(rate) - memory.watts(0.0)) * 1e12 / rate)
            }
        }
    }
}

/// Of one interface.
fn rail_milliwatts(memory: &DramPower, rail: &str, bytes_per_second: f64) -> f64 {
    let rail = memory.rails().iter().find(|of| of.name() == rail);
    let watts = rail.map_or(f64::NAN, |rail| rail.floor_watts() + rail.traffic_watts(bytes_per_second));
    watts * 1e3 / memory.interfaces()
}
