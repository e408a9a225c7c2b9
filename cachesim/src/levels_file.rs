//! The TOML description of a hierarchy: one `[[level]]` table per level, from the requester to memory.
//!
//! ```toml
//! [[level]]
//! name = "L1"
//! size = 16384            # bytes of data per copy
//! line = 64
//! ways = 4                # or "full"
//! policy = "lru"          # fifo, plru, srrip, random
//! # optional, with their defaults:
//! seed = 0                # of random
//! sector = 64             # the line
//! write = "back"          # through
//! write_miss = "fetch"    # validate, around
//! count = 1               # private copies
//! miss_classes = false
//! ```

use std::ops::Range;

use serde::Deserialize;

use crate::address::{Bytes, LineSize};
use crate::config::{LevelConfig, Levels, Policy, Ways, WriteMiss, WritePolicy};
use crate::error::{Error, Place};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    level: Vec<LevelConfig>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLevel {
    name: String,
    size: u64,
    line: u64,
    ways: RawWays,
    policy: RawPolicy,
    seed: Option<u64>,
    sector: Option<u64>,
    write: Option<WritePolicy>,
    write_miss: Option<WriteMiss>,
    count: Option<u32>,
    miss_classes: Option<bool>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "ways must be a number from 1 or \"full\"")]
enum RawWays {
    Count(u32),
    Word(FullWord),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum FullWord {
    Full,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawPolicy {
    Lru,
    Fifo,
    Plru,
    Srrip,
    Random,
}

impl TryFrom<RawLevel> for LevelConfig {
    type Error = String;

    fn try_from(raw: RawLevel) -> Result<Self, String> {
        let size = |key: &str, bytes: u64| {
            LineSize::new(bytes).ok_or_else(|| {
                let (least, most) = (LineSize::MIN.bytes(), LineSize::MAX.bytes());
                format!("{key} is {bytes} bytes, expected a power of two from {least} to {most}")
            })
        };
        let policy = match raw.policy {
            RawPolicy::Lru => Policy::Lru,
            RawPolicy::Fifo => Policy::Fifo,
            RawPolicy::Plru => Policy::Plru,
            RawPolicy::Srrip => Policy::Srrip,
            RawPolicy::Random => Policy::Random { seed: raw.seed.unwrap_or(0) },
        };
        if raw.seed.is_some() && raw.policy != RawPolicy::Random {
            return Err("seed has no meaning here, expected it only with policy = \"random\"".into());
        }
        let ways = match raw.ways {
            RawWays::Count(ways) => Ways::Count(ways),
            RawWays::Word(FullWord::Full) => Ways::Full,
        };
        let plain = Self::new(&raw.name, Bytes(raw.size), size("line", raw.line)?, ways, policy);
        Ok(Self {
            sector: raw.sector.map(|bytes| size("sector", bytes)).transpose()?,
            write: raw.write.unwrap_or(plain.write),
            write_miss: raw.write_miss.unwrap_or(plain.write_miss),
            count: raw.count.unwrap_or(plain.count),
            miss_classes: raw.miss_classes.unwrap_or(plain.miss_classes),
            ..plain
        })
    }
}

impl Levels {
    /// Reads and checks a description. `file` is its name, for errors only.
    ///
    /// # Errors
    /// If the text is not TOML, has an unknown key or lacks one, or describes what cannot be simulated;
    /// the error names the file, the line and the level.
    pub fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let found: File = toml::from_str(text).map_err(|error| {
            let place = place_of(text, file, error.span());
            Error::levels(place, error.message().replace('\n', ", "), "correct the description")
        })?;
        Self::new(found.level).map_err(|error| match error {
            Error::Levels { mut place, problem, remedy } => {
                place.file = Some(file.to_owned());
                place.line = place.level.as_ref().and_then(|(number, _)| header_line(text, *number));
                Error::Levels { place, problem, remedy }
            }
            other => other,
        })
    }
}

fn headers(text: &str) -> impl Iterator<Item = u64> {
    let is_header = |line: &str| line.split_whitespace().collect::<String>().starts_with("[[level]]");
    (1..).zip(text.lines()).filter(move |(_, line)| is_header(line)).map(|(number, _)| number)
}

/// The line of the `number`th `[[level]]`, from 1.
fn header_line(text: &str, number: usize) -> Option<u64> {
    headers(text).nth(number - 1)
}

fn place_of(text: &str, file: &str, span: Option<Range<usize>>) -> Place {
    let before = span.and_then(|span| text.get(..span.start));
    let line = before.map(|before| before.matches('\n').count() as u64 + 1);
    let level = line.map(|line| headers(text).take_while(|&header| header <= line).count());
    Place {
        file: Some(file.to_owned()),
        line,
        byte: None,
        level: level.filter(|&number| number > 0).map(|number| (number, None)),
    }
}
