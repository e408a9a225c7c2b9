//! The triangle loop of a leaf, shared by all kd traversals.

use super::tree::KdTree;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};

/// Tests a leaf's triangles and keeps the nearest hit in `best`; among equal distances the lowest triangle index wins, so that
/// every structure gives the same answer. A hit counts wherever it lies, also outside the leaf's cell.
///
/// Returns whether the query is answered: [`Query::Any`] by the first hit.
#[inline(always)]
pub(super) fn intersect<O: Observer>(
    tree: &KdTree,
    (first, count): (u32, u32),
    ray: &Ray,
    query: Query,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    observer.leaf_visit();
    let references = &tree.references[first as usize..first as usize + count as usize];
    for (position, &primitive) in (first..).zip(references) {
        observer.step(Op::Primitive, position);
        if let Some((t, u, v)) = tree.triangles[primitive as usize].intersect(ray, best.t)
            && (t < best.t || primitive < best.primitive)
        {
            *best = Hit { t, u, v, primitive };
            if query == Query::Any {
                return true;
            }
        }
    }
    false
}
