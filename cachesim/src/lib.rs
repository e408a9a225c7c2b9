//! Cache hierarchy simulation over address streams: exact, deterministic, fast.

mod address;
mod addresses;
mod assoc;
mod classes;
mod config;
mod counts;
mod dense;
mod engine;
mod error;
mod full;
mod hierarchy;
mod isa;
mod level;
mod levels_file;
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
mod word;

pub use address::{Access, Address, Bytes, LineId, LineSize};
pub use addresses::{AddressFormat, AddressReader, MAX_ACCESS_BYTES};
pub use config::{
    LevelConfig, Levels, MAX_COPIES, MAX_LINES, MAX_SECTORS, MAX_WAYS, Policy, Ways, WriteMiss, WritePolicy,
};
pub use counts::{LevelCounts, LevelServed, MAX_LEVELS, MemoryCounts, MissClasses, Served};
pub use error::{Error, Place};
pub use hierarchy::{Hierarchy, PathId};
pub use isa::Isa;
pub use stack_distance::StackDistances;
