//! kd push-down (Horn et al. 2007), with or without a short stack: kd-restart that starts again at the lowest node which
//! still holds the whole rest of the ray. Without a short stack it is the "KD-Pushdown" of Sousa et al. 2019.

use super::options::KdOptions;
use super::restart;
use super::tree::KdTree;
use crate::alpha::RayQuery;
use crate::observe::Observer;
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;

/// Most entries that a short stack can have; as many as a full stack ever needs.
pub const MAX_SHORT_STACK: u32 = KdOptions::MAX_DEPTH;

/// Traces one ray with a short stack of `short_stack` entries; beyond [`MAX_SHORT_STACK`] more make no difference. Bounded as
/// [`restart::trace`].
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    tree: &KdTree<P>,
    short_stack: u32,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    restart::search::<true, P, Q, O>(tree, short_stack, ray, query, observer)
}
