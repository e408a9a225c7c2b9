//! BVH traversal by restart trail (Laine, HPG 2010): instead of a stack, one bit per level says whether the first child is done.
//!
//! After a leaf the traversal starts again at the root and follows the trail; a short stack of the last few far children saves most
//! restarts. The trail, read as a binary number, grows with every pop, so the traversal ends within `2^depth` pops whatever
//! the rounding of the boxes does.

use super::leaf;
use super::tree::{Bvh, NodeRef};
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;
use std::ops::{Add, BitAnd, BitOr, Shr};

/// Width of the trail, which limits the depth of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TrailBits {
    /// Trees of at most 31 levels of decisions.
    Bits32,
    /// Trees of at most 63 levels of decisions.
    Bits64,
}

impl TrailBits {
    /// Deepest tree, in edges.
    pub fn max_depth(self) -> u32 {
        match self {
            TrailBits::Bits32 => 31,
            TrailBits::Bits64 => 63,
        }
    }

    /// The narrowest for a tree of this depth.
    pub fn fitting(depth: u32) -> Self {
        if depth <= Self::Bits32.max_depth() { Self::Bits32 } else { Self::Bits64 }
    }

    /// As a number.
    pub fn count(self) -> u32 {
        match self {
            TrailBits::Bits32 => u32::BITS,
            TrailBits::Bits64 => u64::BITS,
        }
    }
}

/// The word that a trail is kept in.
trait TrailWord:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Shr<u32, Output = Self>
{
    const ZERO: Self;
    /// The bit above all decisions.
    const FINISHED: Self;

    fn negated(self) -> Self;
}

impl TrailWord for u32 {
    const ZERO: Self = 0;
    const FINISHED: Self = 1 << (u32::BITS - 1);

    #[inline(always)]
    fn negated(self) -> Self {
        self.wrapping_neg()
    }
}

impl TrailWord for u64 {
    const ZERO: Self = 0;
    const FINISHED: Self = 1 << (u64::BITS - 1);

    #[inline(always)]
    fn negated(self) -> Self {
        self.wrapping_neg()
    }
}

/// Most entries that a short stack can have.
pub const MAX_SHORT_STACK: u32 = 64;

/// A ring of the most recently pushed far children: a push onto a full ring drops the oldest.
struct ShortStack {
    entries: [(NodeRef, f32); MAX_SHORT_STACK as usize],
    capacity: u32,
    /// Entries pushed and not popped, dropped ones included; the newest is at `(depth - 1) % capacity`.
    depth: u32,
    kept: u32,
}

impl ShortStack {
    fn new(capacity: u32, filler: NodeRef) -> Self {
        Self { entries: [(filler, 0.0); MAX_SHORT_STACK as usize], capacity, depth: 0, kept: 0 }
    }

    fn push(&mut self, node: NodeRef, entry: f32) -> Option<u32> {
        if self.capacity == 0 {
            return None;
        }
        let slot = self.depth % self.capacity;
        self.entries[slot as usize] = (node, entry);
        self.depth += 1;
        self.kept = (self.kept + 1).min(self.capacity);
        Some(slot)
    }

    fn pop(&mut self) -> Option<(u32, NodeRef, f32)> {
        if self.kept == 0 {
            self.depth = 0;
            return None;
        }
        self.kept -= 1;
        self.depth -= 1;
        let slot = self.depth % self.capacity;
        let (node, entry) = self.entries[slot as usize];
        Some((slot, node, entry))
    }
}

/// Traces one ray with `short_stack` entries (at most [`MAX_SHORT_STACK`]).
///
/// # Panics
/// When the tree is deeper than the trail, or the short stack larger than its limit: the caller checks both, see
/// [`AccelerationStructure::build`](crate::AccelerationStructure::build).
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    bits: TrailBits,
    short_stack: u32,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    assert!(bvh.depth <= bits.max_depth() && short_stack <= MAX_SHORT_STACK);
    match bits {
        TrailBits::Bits32 => trace_with::<u32, P, Q, O>(bvh, short_stack, ray, query, observer),
        TrailBits::Bits64 => trace_with::<u64, P, Q, O>(bvh, short_stack, ray, query, observer),
    }
}

fn trace_with<W: TrailWord, P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    short_stack: u32,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    let mut best = Hit::miss(ray.t_max);
    observer.step(Op::Node, 0);
    observer.box_tests(1);
    let (near, far) = slab.entry_exit(&bvh.root_bounds, ray.t_min, best.t);
    let meets_scene = near <= far;
    if !meets_scene {
        return best;
    }

    let mut stack = ShortStack::new(short_stack, bvh.root);
    let mut trail = W::ZERO;
    // The bit of the decision that led to `node` (its children's is the next lower one), and the bit that the last pop set.
    let mut above = W::FINISHED;
    let mut popped_level = W::ZERO;
    let mut node = bvh.root;
    loop {
        if node.is_inner() {
            let level = above >> 1;
            observer.step(Op::Node, node.link);
            observer.box_tests(2);
            let pair = bvh.pair(node.link);
            let (near_a, far_a, near_b, far_b) = slab.entry_exit_pair(&pair.planes, ray.t_min, best.t);
            let (hit_a, hit_b) = (near_a <= far_a, near_b <= far_b);
            if hit_a & hit_b {
                let a_first = near_a <= near_b;
                let [a, b] = pair.links;
                let (nearer, farther) = if a_first { (a, b) } else { (b, a) };
                if trail & level != W::ZERO {
                    node = farther;
                } else {
                    node = nearer;
                    let entry = if a_first { near_b } else { near_a };
                    if let Some(slot) = stack.push(farther, entry) {
                        observer.step(Op::Push, slot);
                    }
                }
                above = level;
                continue;
            }
            // Where the last pop has set the bit and only one child is left, that child is the nearer one, already done:
            // the farther one has been culled by a hit found since.
            if (hit_a | hit_b) && level != popped_level {
                trail = trail | level;
                above = level;
                // Branches, not a selection: see the stack traversal.
                if hit_a {
                    std::hint::black_box(());
                    node = pair.links[0];
                } else {
                    node = pair.links[1];
                }
                continue;
            }
        } else if leaf::intersect(bvh.leaves(0), node, prepared, query, &mut best, observer)
            && query.query() == Query::Any
        {
            return best;
        }

        // Pop: the carry skips every level whose bit is set, that is, whose last child is done.
        loop {
            trail = (trail & above.negated()) + above;
            if trail >= W::FINISHED {
                return best;
            }
            popped_level = trail & trail.negated();
            let Some((slot, popped, entry)) = stack.pop() else {
                observer.step(Op::Restart, 0);
                node = bvh.root;
                above = W::FINISHED;
                break;
            };
            observer.step(Op::Pop, slot);
            above = popped_level;
            if entry <= best.t {
                node = popped;
                break;
            }
        }
    }
}
