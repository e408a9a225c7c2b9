//! The triangle loop of a leaf that refers to its triangles through a list: a leaf of a kd-tree or a cell of a grid.

use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query};
use crate::triangle::RayTriangle;

/// The references of all leaves of a structure, and the triangles that they refer to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct References<'a, P> {
    /// Triangle indices, leaf after leaf.
    pub(crate) list: &'a [u32],
    /// Triangles in file order.
    pub(crate) triangles: &'a [P],
}

/// Tests a leaf's triangles and keeps the nearest hit in `best`; among equal distances the lowest triangle index wins, so that
/// every structure gives the same answer. A hit that the query accepts counts wherever it lies, also outside the leaf's cell.
///
/// Returns whether the query is answered: [`Query::Any`] by the first hit.
#[inline(always)]
pub(crate) fn intersect<P: RayTriangle, Q: RayQuery, O: Observer>(
    references: References<'_, P>,
    (first, count): (u32, u32),
    ray: P::Ray<'_>,
    query: Q,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    observer.leaf_visit();
    let list = &references.list[first as usize..first as usize + count as usize];
    for (position, &primitive) in (first..).zip(list) {
        observer.step(Op::Primitive, position);
        if let Some((t, u, v)) = references.triangles[primitive as usize].test(ray, best.t)
            && (t < best.t || primitive < best.primitive)
        {
            let hit = Hit { t, u, v, primitive };
            if !query.accepts(&hit, position, observer) {
                continue;
            }
            *best = hit;
            if query.query() == Query::Any {
                return true;
            }
        }
    }
    false
}
