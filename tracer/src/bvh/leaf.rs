//! The triangle loop of a BVH leaf, shared by all BVH traversals.

use super::tree::{Bvh, NodeRef};
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Ray};

/// Tests a leaf's triangles, keeping the nearest hit in `best`; among equal distances the lowest triangle index wins, so that
/// every structure gives the same answer. With `any`, returns at the first hit. Returns whether a hit was found.
#[inline(always)]
pub(super) fn intersect<O: Observer>(
    bvh: &Bvh,
    leaf: NodeRef,
    ray: &Ray,
    any: bool,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    observer.leaf_visit();
    let first = leaf.link as usize;
    let mut found = false;
    let triangles = &bvh.triangles[first..first + leaf.count() as usize];
    for (position, triangle) in (leaf.link..).zip(triangles) {
        observer.step(Op::Primitive, position);
        if let Some((t, u, v)) = triangle.intersect(ray, best.t) {
            let primitive = bvh.references[position as usize];
            if t < best.t || primitive < best.primitive {
                *best = Hit { t, u, v, primitive };
                found = true;
                if any {
                    return true;
                }
            }
        }
    }
    found
}
