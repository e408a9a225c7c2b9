//! The description of a cache hierarchy, and the checks that make it one that can be simulated.

use serde::Deserialize;

use crate::address::{Bytes, LineSize};
use crate::counts::MAX_LEVELS;
use crate::error::{Error, Place};

/// The most lines that all levels and copies may hold together: 4 GiB of 64-byte lines.
pub const MAX_LINES: u64 = 1 << 26;
/// The most ways of a set that is not fully associative.
pub const MAX_WAYS: u32 = 1024;
/// The most private copies of a level.
pub const MAX_COPIES: u32 = 4096;
/// The most sectors in a line.
pub const MAX_SECTORS: u64 = 32;

/// How many lines a set holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ways {
    /// This many; the number of sets is `size / (line * ways)`, any number of them.
    Count(u32),
    /// All of the cache: one set.
    Full,
}

/// Which line of a full set makes room. Empty ways are always taken first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// The least recently used one.
    Lru,
    /// The oldest one.
    Fifo,
    /// The one that a binary tree of recency bits points to; ways must be a power of two up to 64.
    Plru,
    /// Static re-reference interval prediction with 2 bits and hit priority (Jaleel et al. 2010).
    Srrip,
    /// A pseudorandom one.
    Random {
        /// Start of the random sequence; copies of a level get different sequences.
        seed: u64,
    },
}

/// When written data moves on to the level below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WritePolicy {
    /// When the line is evicted or flushed.
    Back,
    /// At once.
    Through,
}

/// What a write does that misses (Jouppi 1993).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WriteMiss {
    /// Reads the line from below, then writes into it: write-allocate with fetch on write.
    Fetch,
    /// Takes a line without reading it: write-allocate of data that covers the line.
    Validate,
    /// Passes the write on below and keeps nothing: no write-allocate.
    Around,
}

/// One level of a hierarchy.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "crate::levels_file::RawLevel")]
pub struct LevelConfig {
    /// A name for reports and errors, unique in the hierarchy.
    pub name: String,
    /// Data bytes in each copy: `line * ways * sets`.
    pub size: Bytes,
    /// Bytes that share one tag.
    pub line: LineSize,
    /// Lines per set.
    pub ways: Ways,
    /// Replacement policy.
    pub policy: Policy,
    /// Bytes filled and written back at a time; `None` is the whole line.
    pub sector: Option<LineSize>,
    /// When writes move on.
    pub write: WritePolicy,
    /// What a write miss does.
    pub write_miss: WriteMiss,
    /// Private copies, shared out evenly over the units.
    pub count: u32,
    /// Whether to tell cold, capacity and conflict misses apart, at some cost in time.
    pub miss_classes: bool,
}

impl LevelConfig {
    /// One write-back, fetch-on-write copy without sectors or miss classes.
    #[must_use]
    pub fn new(name: &str, size: Bytes, line: LineSize, ways: Ways, policy: Policy) -> Self {
        Self {
            name: name.to_owned(),
            size,
            line,
            ways,
            policy,
            sector: None,
            write: WritePolicy::Back,
            write_miss: WriteMiss::Fetch,
            count: 1,
            miss_classes: false,
        }
    }

    /// The unit in which the level is accessed, filled and written back: its sector, or else its line.
    #[must_use]
    pub fn granule(&self) -> LineSize {
        self.sector.unwrap_or(self.line)
    }

    /// Lines in each copy.
    #[must_use]
    pub fn lines(&self) -> u64 {
        self.size.0 >> self.line.log2()
    }

    /// Ways as a number; all lines where the level is fully associative.
    #[must_use]
    pub fn way_count(&self) -> u64 {
        match self.ways {
            Ways::Count(ways) => u64::from(ways),
            Ways::Full => self.lines(),
        }
    }

    /// Sets in each copy.
    #[must_use]
    pub fn sets(&self) -> u64 {
        self.lines() / self.way_count().max(1)
    }

    /// What is wrong with this level and its remedy.
    fn check(&self) -> Result<(), (String, String)> {
        let fail = |problem: String, remedy: &str| Err((problem, remedy.to_owned()));
        let line = self.line.bytes();
        if self.size.0 == 0 {
            return fail(
                "size is 0 bytes, expected a cache that holds at least one line".into(),
                "raise size",
            );
        }
        if self.count == 0 || self.count > MAX_COPIES {
            return fail(
                format!("count is {}, expected 1 to {MAX_COPIES} private copies", self.count),
                "correct count, or leave it out for one shared copy",
            );
        }
        let lines = self.size.0 >> self.line.log2();
        if lines.saturating_mul(u64::from(self.count)) > MAX_LINES {
            return fail(
                format!(
                    "{} x {} bytes hold more than {MAX_LINES} lines of {line} bytes, the most that is simulated",
                    self.count, self.size.0
                ),
                "lower size or count, or raise line",
            );
        }
        match self.ways {
            Ways::Count(ways) => {
                if ways == 0 || ways > MAX_WAYS {
                    return fail(
                        format!("ways is {ways}, expected 1 to {MAX_WAYS} or \"full\""),
                        "correct ways, or write ways = \"full\"",
                    );
                }
                let set = line * u64::from(ways);
                if !self.size.0.is_multiple_of(set) {
                    let sets = self.size.0 as f64 / set as f64;
                    return fail(
                        format!(
                            "size {} is {sets:.3} sets of {ways} ways of {line} bytes, expected a whole number",
                            self.size.0
                        ),
                        &format!("make size a multiple of {set}"),
                    );
                }
                if self.policy == Policy::Plru && !(ways.is_power_of_two() && ways <= 64) {
                    return fail(
                        format!(
                            "plru needs a binary tree over the ways, and ways is {ways}; expected a power of two up to 64"
                        ),
                        "change ways, or use policy = \"lru\"",
                    );
                }
            }
            Ways::Full => {
                if !self.size.0.is_multiple_of(line) {
                    return fail(
                        format!("size {} is not a whole number of {line}-byte lines", self.size.0),
                        &format!("make size a multiple of {line}"),
                    );
                }
                if !matches!(self.policy, Policy::Lru | Policy::Fifo) {
                    return fail(
                        "ways = \"full\" is simulated for the policies lru and fifo only".into(),
                        "use one of these, or give ways as a number",
                    );
                }
            }
        }
        if let Some(sector) = self.sector {
            let sectors = line / sector.bytes().min(line);
            if sector > self.line || sectors > MAX_SECTORS {
                return fail(
                    format!(
                        "sector is {} bytes in a line of {line}, expected 1 to {MAX_SECTORS} sectors per line",
                        sector.bytes()
                    ),
                    "correct sector, or leave it out",
                );
            }
        }
        Ok(())
    }
}

/// A hierarchy's levels from the requester to memory, checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Levels {
    levels: Vec<LevelConfig>,
}

impl Levels {
    /// Checks each level and how they fit together.
    ///
    /// # Errors
    /// Names the level at fault, what was expected and the remedy.
    pub fn new(levels: Vec<LevelConfig>) -> Result<Self, Error> {
        if levels.is_empty() || levels.len() > MAX_LEVELS {
            return Err(Error::levels(
                Place::default(),
                format!("{} levels, expected 1 to {MAX_LEVELS}", levels.len()),
                "give one [[level]] table per level, from the requester to memory",
            ));
        }
        let mut lines = 0;
        let units = levels.iter().map(|level| level.count).max().unwrap_or(1);
        for (index, level) in levels.iter().enumerate() {
            let at = || Place { level: Some((index + 1, Some(level.name.clone()))), ..Place::default() };
            level.check().map_err(|(problem, remedy)| Error::levels(at(), problem, remedy))?;
            if levels[..index].iter().any(|other| other.name == level.name) {
                return Err(Error::levels(
                    at(),
                    "another level has the same name",
                    "give each level its own name",
                ));
            }
            if !units.is_multiple_of(level.count) {
                return Err(Error::levels(
                    at(),
                    format!("{} copies cannot be shared out evenly over {units} units", level.count),
                    format!("make count a divisor of {units}, the largest count"),
                ));
            }
            lines += level.lines() * u64::from(level.count);
            if lines > MAX_LINES {
                return Err(Error::levels(
                    at(),
                    format!("the levels up to here hold {lines} lines, expected at most {MAX_LINES} in all"),
                    "lower size or count, or raise line",
                ));
            }
        }
        Ok(Self { levels })
    }

    /// The levels, from the requester to memory.
    #[must_use]
    pub fn as_slice(&self) -> &[LevelConfig] {
        &self.levels
    }

    /// How many requesters there are: the largest number of copies of any level.
    #[must_use]
    pub fn units(&self) -> u32 {
        self.levels.iter().map(|level| level.count).max().unwrap_or(1)
    }
}
