//! Rays, triangles and structures.

mod degenerate;
mod hits;
mod leaks;
mod same_hits;
mod scale;
mod spawned;

use crate::Group;

/// All, in order.
pub(crate) const GROUPS: [Group; 6] = [
    ("hits", hits::cases),
    ("scale", scale::cases),
    ("leaks", leaks::cases),
    ("same-hits", same_hits::cases),
    ("degenerate", degenerate::cases),
    ("spawned", spawned::cases),
];
