//! What compute shaders do to the order of rays and hits.
//!
//! Rays that a pass appends to a buffer lie there in the order in which its warps got to the counter ([`arrival_order`]), no longer in
//! that of the image. A workgroup can put its own into bins first ([`Binning`], [`Compaction`]); hits can be brought into buckets, one for
//! each shader ([`BucketSort`]). All of it is executed, atomics included ([`AtomicStrategy`]): the results are orders and counts, no times.
//! The algorithms are those of Calvo Lista, "Mobile Ray Tracing Demystified", Vulkanised 2026, as its prose has them.

mod arrival;
mod atomics;
mod binning;
mod compaction;
mod sorting;

pub use arrival::arrival_order;
pub use atomics::{Address, AtomicStrategy, AtomicTally};
pub use binning::{Binning, MOST_BINS};
pub use compaction::{Compacted, Compaction, Counters, Workgroup};
pub use sorting::{Bucket, BucketSort, Sorted, bucket_of};

use crate::error::Error;

fn refuse(problem: impl Into<String>, remedy: impl Into<String>) -> Error {
    Error::Ordering { problem: problem.into(), remedy: remedy.into() }
}

/// Refuses arrivals that do not name each of `units` once.
fn check_arrivals(what: &str, arrivals: &[usize], units: usize) -> Result<(), Error> {
    let mut missing = vec![true; units];
    let each_once = arrivals.len() == units
        && arrivals.iter().all(|&unit| missing.get_mut(unit).is_some_and(std::mem::take));
    if each_once {
        return Ok(());
    }
    let problem = format!("{} arrivals do not name each of {units} {what} once", arrivals.len());
    Err(refuse(problem, "take them from arrival_order, of as many durations"))
}
