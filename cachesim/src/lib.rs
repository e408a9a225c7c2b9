//! Cache hierarchy simulation over address streams: exact, deterministic, fast.
//!
//! [`Levels`] describes caches and checks the description; [`Hierarchy`] simulates them, in order, and
//! counts; [`AddressReader`] feeds it from files. [`StackDistances`] gives the misses of LRU caches of all
//! sizes at once, as a [`MissCurve`], and [`Aet`] nearly the same in a fraction of the time. [`Dram`] gives the time of what misses all caches, under an FR-FCFS
//! controller, [`RowTally`] its row hits alone. [`synthetic`] makes streams to measure and check with.
//!
//! ```
//! use cachesim::{Bytes, Hierarchy, LevelConfig, Levels, LineId, LineSize, Policy, Ways};
//!
//! let line = LineSize::new(64).unwrap();
//! let levels = Levels::new(vec![
//!     LevelConfig { count: 4, ..LevelConfig::new("L1", Bytes(16 << 10), line, Ways::Count(4), Policy::Lru) },
//!     LevelConfig::new("L2", Bytes(1 << 20), line, Ways::Count(16), Policy::Lru),
//! ])?;
//! let (mut hierarchy, path) = Hierarchy::chain(&levels)?;
//! let run = [1, 2, 3, 2].map(LineId::new);
//! let served = hierarchy.read(path, 0, &run);
//! assert_eq!((served.levels[0].misses, served.levels[1].misses, served.memory.read_bytes), (3, 3, 192));
//! # Ok::<(), cachesim::Error>(())
//! ```
//!
//! # What is simulated, and what is not
//! Of caches, contents, not time: there is no latency, no bank and no outstanding miss, and a line is there
//! as soon as it was asked for. An access is counted per line, or per sector where a level has sectors. On a miss the
//! line is read from below first, then the evicted line's dirty data is written below. Levels are neither
//! inclusive nor exclusive, and copies are not kept coherent.

mod address;
mod addresses;
mod aet;
mod assoc;
mod classes;
mod config;
mod counts;
mod dense;
mod dram;
mod engine;
mod error;
mod full;
mod hierarchy;
mod isa;
mod ledger;
mod level;
mod levels_file;
mod line_map;
mod miss_curve;
mod out;
mod policy;
mod queue;
mod recency;
mod sectors;
mod sets;
mod sink;
mod splitmix;
mod stack_distance;
mod store;
pub mod synthetic;
mod tlb;
mod word;

pub use address::{Access, Address, Bytes, LineId, LineSize};
pub use addresses::{AddressFormat, AddressReader, MAX_ACCESS_BYTES};
pub use aet::Aet;
pub use config::{
    LevelConfig, Levels, MAX_COPIES, MAX_LINES, MAX_SECTORS, MAX_WAYS, Policy, Ways, WriteMiss, WritePolicy,
};
pub use counts::{
    LevelCounts, LevelServed, MAX_LEVELS, MemoryCounts, MemoryRequest, MissClasses, Missed, Served,
};
pub use dram::{
    BuiltinDram, DRAM_STANDARDS, Done, Dram, DramConfig, DramStandard, DramStats, DramTag, DramTimings,
    MAX_CHANNELS, MAX_QUEUE, MissTraceFormat, MissTraceWriter, RowCounts, RowTally,
};
pub use error::{Error, Place};
pub use hierarchy::{Hierarchy, PathId};
pub use isa::Isa;
pub use miss_curve::MissCurve;
pub use stack_distance::StackDistances;
pub use tlb::TlbConfig;
