//! Acceleration structures and instrumented traversals that record what each ray visits.
//!
//! This crate knows no address, cache or clock: a trace says *what* was visited, never where it lay in memory.

mod aabb;
pub mod kd;
mod observe;
mod ray;
mod triangle;

pub use aabb::{Aabb, FAR_WIDENING, SlabRay};
pub use observe::{LoopStructure, NodeFetch, Observer, Op, Silent, Work, WorkCounter};
pub use ray::{Hit, NO_HIT, Query, Ray};
pub use triangle::PreparedTriangle;
