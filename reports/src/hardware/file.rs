//! The file of measurements.

use crate::error::Error;
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
    /// What was found; nothing where only an order is known.
    pub published: Option<Published>,
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
        }
    }

    /// Of what a probe measured; a ratio is the caller's to form from times per load.
    pub(super) fn of(self, observed: &Observation) -> f64 {
        match self {
            Self::NsPerLoad => observed.seconds_per_load() * 1e9,
            Self::TimeRatio => observed.seconds_per_load(),
            Self::Gbs => observed.bytes_per_second() / 1e9,
            Self::L2Gbs => observed.cache_bytes_per_second(CacheRole::L2) / 1e9,
            Self::ExternalGbs => observed.memory_bytes_per_second() / 1e9,
        }
    }
}
