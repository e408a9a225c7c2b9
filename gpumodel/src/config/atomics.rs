//! Atomics, barriers and indirect dispatches of a GPU.

use super::gpu_checks::RATE;
use super::gpu_file::AtomicsFile;
use super::sourced::{File, Sourced};
use crate::error::Error;

/// What adding to shared counters takes, and what passes that depend on each other take besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atomics {
    /// Clocks for which a counter in memory is busy with the add of one lane, or of a whole instruction where that is joined into one.
    pub lane_clocks: f64,
    /// Clocks for which the counters of an atomic instruction are busy besides, whatever lanes it has.
    pub warp_clocks: f64,
    /// Whether the adds of an instruction reach a counter as one, where the compiler can see that its address is uniform:
    /// [`AtomicTally::reaching_memory`](crate::ordering::AtomicTally::reaching_memory).
    pub joins_uniform: bool,
    /// Clocks for which a counter in a workgroup's memory is busy with the add of one lane.
    pub shared_lane_clocks: f64,
    /// Clocks that a warp waits at a barrier of its workgroup if all others are there.
    pub barrier_clocks: f64,
    /// Seconds from the end of a pass to the start of an indirect dispatch that depends on it.
    pub dispatch_seconds: f64,
}

pub(super) fn atomics(file: &File<'_>, raw: &AtomicsFile) -> Result<Atomics, Error> {
    let clocks =
        |key: &str, figure: &Sourced<f64>| file.within(&format!("atomics.{key}"), figure, 0.0..=*RATE.end());
    Ok(Atomics {
        lane_clocks: file.within("atomics.lane_clocks", &raw.lane_clocks, RATE)?,
        warp_clocks: clocks("warp_clocks", &raw.warp_clocks)?,
        joins_uniform: *file.sourced("atomics.joins_uniform", &raw.joins_uniform)?,
        shared_lane_clocks: file.within("atomics.shared_lane_clocks", &raw.shared_lane_clocks, RATE)?,
        barrier_clocks: clocks("barrier_clocks", &raw.barrier_clocks)?,
        dispatch_seconds: clocks("dispatch_us", &raw.dispatch_us)? * 1e-6,
    })
}
