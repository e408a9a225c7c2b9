//! What a replay counts, and what a profiler would show of it.

mod frame;
mod heat_maps;
mod set;
mod table;

pub(crate) use frame::Numbers;
pub use frame::{
    BufferTraffic, FrameCounters, IssueCounters, Pass, PassCounters, ScheduleCounters, TrafficCounters,
    WaitCounters,
};
pub use heat_maps::{HeatMap, HeatMaps};
pub use set::{CounterSet, Value};
pub use table::{COUNTERS, CounterInfo};
