//! What a replay counts, and what a profiler would show of it.

mod frame;
mod set;
mod table;

pub(crate) use frame::Numbers;
pub use frame::{
    BufferTraffic, FrameCounters, HeatMap, HeatMaps, IssueCounters, Pass, PassCounters, ScheduleCounters,
    TrafficCounters, WaitCounters,
};
pub use set::{CounterSet, Value};
pub use table::{COUNTERS, CounterInfo};
