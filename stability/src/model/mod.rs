//! Solvers, replays, caches and sums.

mod caches;
mod frames;
mod solver;
mod sums;

use crate::Group;

/// All, in order.
pub(crate) const GROUPS: [Group; 4] =
    [("solver", solver::cases), ("frames", frames::cases), ("caches", caches::cases), ("sums", sums::cases)];
