//! Traversal of a wide BVH with a full stack, nearest child first: while-while, all children's boxes tested at their parent.
//!
//! The children that are hit are sorted by the distance at which the ray enters their boxes, among equals by their place. The nearest is next, the
//! others are pushed, the farthest first.

use super::tree::{WideBvh, WideNodes};
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::bvh::{BvhOptions, NodeRef, leaf};
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;
use std::mem::MaybeUninit;

/// Stack capacity: at each level of the deepest tree, all children of the widest node but one.
const CAPACITY: usize = 7 * (BvhOptions::MAX_DEPTH as usize + 1);

/// A child that the ray meets.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) link: NodeRef,
    /// Distance at which the ray enters its box.
    pub(super) distance: f32,
}

/// Fetches a node and tests the boxes of its children up to the distance `t_max`: those that are hit, and how many, sorted as the module's
/// documentation says.
#[inline(always)]
pub(super) fn near_to_far<const W: usize, O: Observer>(
    tree: &WideNodes<W>,
    slab: &SlabRay,
    node: u32,
    t_min: f32,
    t_max: f32,
    observer: &mut O,
) -> ([Entry; W], usize) {
    observer.step(Op::Node, node);
    let node = &tree.nodes[node as usize];
    observer.box_tests(node.children);
    let (entries, hits) = slab.entries(&node.planes, t_min, t_max);
    let mut hit = [Entry { link: NodeRef::NOTHING, distance: 0.0 }; W];
    let mut count = 0;
    let children = node.links.into_iter().zip(entries).take(node.children as usize);
    for (child, (link, distance)) in children.enumerate() {
        if hits >> child & 1 != 0 {
            let mut place = count;
            while place > 0 && hit[place - 1].distance > distance {
                hit[place] = hit[place - 1];
                place -= 1;
            }
            hit[place] = Entry { link, distance };
            count += 1;
        }
    }
    (hit, count)
}

/// Traces one ray. Every node is visited at most once, so the loop is bounded by the tree.
#[inline]
pub fn trace<P: RayTriangle, const W: usize, Q: RayQuery, O: Observer>(
    bvh: &WideBvh<P, W>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    match query.query() {
        Query::Closest => run::<false, P, W, Q, O>(bvh, ray, query, observer),
        Query::Any => run::<true, P, W, Q, O>(bvh, ray, query, observer),
    }
}

#[inline(never)]
fn run<const ANY: bool, P: RayTriangle, const W: usize, Q: RayQuery, O: Observer>(
    bvh: &WideBvh<P, W>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    descend::<ANY, P, W, Q, O>(bvh, 0, ray, query, &mut best, observer);
    best
}

/// Looks for a hit that is better than `best`, in which the tree's triangles have indices from `base`. Returns whether an
/// any-hit query is answered.
#[inline(always)]
pub(crate) fn descend<const ANY: bool, P: RayTriangle, const W: usize, Q: RayQuery, O: Observer>(
    bvh: &WideBvh<P, W>,
    base: u32,
    ray: &Ray,
    query: Q,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    walk::<ANY, W, O>(&bvh.tree, &slab, ray.t_min, best, observer, |node, _, best, observer| {
        leaf::intersect(bvh.leaves(base), node, prepared, query, best, observer) && ANY
    })
}

/// Walks a tree, whatever its leaves hold. `at_leaf` gets a leaf, the number of stack entries, the best hit so far and the observer,
/// and says whether the walk is over; so does `walk`.
#[inline(always)]
pub(crate) fn walk<const ANY: bool, const W: usize, O: Observer>(
    tree: &WideNodes<W>,
    slab: &SlabRay,
    t_min: f32,
    best: &mut Hit,
    observer: &mut O,
    mut at_leaf: impl FnMut(NodeRef, u32, &mut Hit, &mut O) -> bool,
) -> bool {
    let mut stack = [const { MaybeUninit::<Entry>::uninit() }; CAPACITY];
    let mut top = 0;
    let mut next = NodeRef::inner(0, 0);
    loop {
        if next.is_inner() {
            let (hit, count) = near_to_far(tree, slab, next.link, t_min, best.t, observer);
            if count > 0 {
                for farther in hit[1..count].iter().rev() {
                    observer.step(Op::Push, top as u32);
                    stack[top].write(*farther);
                    top += 1;
                }
                next = hit[0].link;
                continue;
            }
        } else if at_leaf(next, top as u32, best, observer) {
            return true;
        }
        loop {
            if top == 0 {
                return false;
            }
            top -= 1;
            observer.step(Op::Pop, top as u32);
            // SAFETY: entries below the old `top` were written by a push above.
            let Entry { link, distance } = unsafe { stack[top].assume_init_read() };
            // Without a hit the interval has not shrunk since the push, and with one `ANY` has returned.
            if ANY || distance <= best.t {
                next = link;
                break;
            }
        }
    }
}

/// Whether the ray meets the box of a leaf.
pub(crate) fn meets_leaf<P: RayTriangle, const W: usize>(bvh: &WideBvh<P, W>, ray: &Ray) -> bool {
    let slab = SlabRay::new(ray, &bvh.slack);
    let mut open = vec![0];
    while let Some(node) = open.pop() {
        let node = &bvh.tree.nodes[node as usize];
        let (_, hits) = slab.entries(&node.planes, ray.t_min, ray.t_max);
        for (child, link) in node.links.iter().take(node.children as usize).enumerate() {
            if hits >> child & 1 != 0 {
                if !link.is_inner() {
                    return true;
                }
                open.push(link.link);
            }
        }
    }
    false
}
