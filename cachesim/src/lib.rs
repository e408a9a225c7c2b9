//! Cache hierarchy simulation over address streams: exact, deterministic, fast.

mod address;
mod config;
mod counts;
mod engine;
mod error;
mod hierarchy;
mod level;
mod policy;
mod queue;
mod sets;
mod store;
pub mod synthetic;
mod word;

pub use address::{Access, Address, Bytes, LineId, LineSize};
pub use config::{
    LevelConfig, Levels, MAX_COPIES, MAX_LINES, MAX_SECTORS, MAX_WAYS, Policy, Ways, WriteMiss, WritePolicy,
};
pub use counts::{LevelCounts, LevelServed, MAX_LEVELS, MemoryCounts, MissClasses, Served};
pub use error::{Error, Place};
pub use hierarchy::{Hierarchy, PathId};
