//! BVH traversal with a full stack, nearer child first: while-while, both children's boxes tested at their parent.

use super::leaf;
use super::pair_tree::PairTree;
use super::tree::{Bvh, NodeRef};
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;
use std::mem::MaybeUninit;

/// Stack capacity: one far sibling per level of the deepest tree.
const CAPACITY: usize = super::BvhOptions::MAX_DEPTH as usize + 1;

#[derive(Clone, Copy)]
struct Entry {
    node: NodeRef,
    entry: f32,
}

/// Traces one ray. Every node is visited at most once, so the loop is bounded by the tree.
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    match query.query() {
        Query::Closest => run::<false, P, Q, O>(bvh, ray, query, observer),
        Query::Any => run::<true, P, Q, O>(bvh, ray, query, observer),
    }
}

#[inline(never)]
fn run<const ANY: bool, P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    descend::<ANY, P, Q, O>(bvh, 0, ray, query, &mut best, observer);
    best
}

/// Looks for a hit that is better than `best`, in which the tree's triangles have indices from `base`. Returns whether an
/// any-hit query is answered.
#[inline(always)]
pub(crate) fn descend<const ANY: bool, P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    base: u32,
    ray: &Ray,
    query: Q,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    walk::<ANY, O>(bvh.pair_tree(), &slab, ray.t_min, best, observer, |node, _, best, observer| {
        leaf::intersect(bvh.leaves(base), node, prepared, query, best, observer) && ANY
    })
}

/// Walks a tree, whatever its leaves hold. `at_leaf` gets a leaf, the number of stack entries, the best hit so far and the observer,
/// and says whether the walk is over; so does `walk`.
#[inline(always)]
pub(crate) fn walk<const ANY: bool, O: Observer>(
    tree: PairTree<'_>,
    slab: &SlabRay,
    t_min: f32,
    best: &mut Hit,
    observer: &mut O,
    mut at_leaf: impl FnMut(NodeRef, u32, &mut Hit, &mut O) -> bool,
) -> bool {
    observer.step(Op::Node, 0);
    observer.box_tests(1);
    let (near, far) = slab.entry_exit(tree.root_bounds, t_min, best.t);
    let meets_root = near <= far;
    if !meets_root {
        return false;
    }

    let mut stack = [const { MaybeUninit::<Entry>::uninit() }; CAPACITY];
    let mut top = 0;
    let mut node = tree.root;
    loop {
        if node.is_inner() {
            observer.step(Op::Node, node.link);
            observer.box_tests(2);
            let pair = tree.pair(node.link);
            let (near_a, far_a, near_b, far_b) = slab.entry_exit_pair(&pair.planes, t_min, best.t);
            let (hit_a, hit_b) = (near_a <= far_a, near_b <= far_b);
            let [left, right] = pair.links;
            // Branches, not selections: a predicted branch lets the load of the next pair start before this pair's boxes are
            // known; a selection makes every step wait for the one before.
            if hit_a & hit_b {
                observer.step(Op::Push, top as u32);
                debug_assert!(top < CAPACITY);
                // SAFETY: the tree is at most `MAX_DEPTH` deep and each level on the path has pushed at most one entry, so
                // `top < CAPACITY`.
                let slot = unsafe { stack.get_unchecked_mut(top) };
                top += 1;
                if near_a <= near_b {
                    slot.write(Entry { node: right, entry: near_b });
                    node = left;
                } else {
                    slot.write(Entry { node: left, entry: near_a });
                    node = right;
                }
                continue;
            }
            if hit_a {
                // Keeps the compiler from merging this case and the next one into a selection.
                std::hint::black_box(());
                node = left;
                continue;
            }
            if hit_b {
                node = right;
                continue;
            }
        } else if at_leaf(node, top as u32, best, observer) {
            return true;
        }
        loop {
            if top == 0 {
                return false;
            }
            top -= 1;
            observer.step(Op::Pop, top as u32);
            // SAFETY: entries below the old `top` were written by a push above.
            let popped = unsafe { stack.get_unchecked(top).assume_init_read() };
            // Without a hit the interval has not shrunk since the push, and with one `ANY` has returned.
            if ANY || popped.entry <= best.t {
                node = popped.node;
                break;
            }
        }
    }
}
