//! Traversal of a wide BVH with a short stack, as Mesa's driver walks around the `ray_intersection` instruction of the Adreno 7xx and 8xx
//! (`tu_nir_lower_ray_query.cc`, `build_ray_traversal`): one loop, one node or leaf per trip.
//!
//! A stack entry is a node with those of its children that are still to be visited, the nearest first, so a node pushes once. The instruction gives no
//! distances, so what is popped is visited even where a hit has been found before it. The stack is a ring: a push onto a full one drops the oldest entry.
//! Where entries are lost the traversal climbs: it goes to the parent of the node that it has finished, tests the parent's boxes again, and goes on with
//! the child behind that node.
//!
//! In a structure of two levels both share the ring: a BLAS's entries lie on those of the TLAS, which they may push out. The ray is back in the TLAS when the
//! entries of the BLAS are used up or it has climbed to the BLAS's root, and goes on behind the leaf of the instance.

use super::stack::{Entry, near_to_far};
use super::tree::{WideBvh, WideNodes};
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::bvh::restart_trail::MAX_SHORT_STACK;
use crate::bvh::{NodeRef, leaf};
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;

/// Entries of the driver's stack.
pub const DRIVER_ENTRIES: u32 = 8;

/// A node whose children from `next` on are still to be visited.
#[derive(Clone, Copy)]
struct Pending<const W: usize> {
    node: u32,
    children: [Entry; W],
    next: u8,
    count: u8,
}

/// The ring. Entries are numbered from the bottom; entry `number` lies at `number % capacity`.
pub(crate) struct Ring<const W: usize> {
    entries: [Pending<W>; MAX_SHORT_STACK as usize],
    capacity: u32,
    /// Entries, lost ones included.
    depth: u32,
    /// Entries below this one are lost.
    lost: u32,
}

impl<const W: usize> Ring<W> {
    /// An empty one of so many entries, at most [`MAX_SHORT_STACK`].
    pub(crate) fn new(capacity: u32) -> Self {
        let children = [Entry { link: NodeRef::NOTHING, distance: 0.0 }; W];
        let filler = Pending { node: 0, children, next: 0, count: 0 };
        Self {
            entries: [filler; MAX_SHORT_STACK as usize],
            capacity: capacity.min(MAX_SHORT_STACK),
            depth: 0,
            lost: 0,
        }
    }

    fn push<O: Observer>(&mut self, pending: Pending<W>, observer: &mut O) {
        if self.capacity > 0 {
            let slot = self.depth % self.capacity;
            observer.step(Op::Push, slot);
            self.entries[slot as usize] = pending;
        }
        self.depth += 1;
        self.lost = self.lost.max(self.depth.saturating_sub(self.capacity));
    }

    /// The next child of the newest entry, and its parent. There must be an entry that is not lost.
    fn pop<O: Observer>(&mut self, observer: &mut O) -> (NodeRef, u32) {
        let slot = (self.depth - 1) % self.capacity;
        observer.step(Op::Pop, slot);
        let pending = &mut self.entries[slot as usize];
        let child = pending.children[pending.next as usize].link;
        pending.next += 1;
        if pending.next == pending.count {
            self.depth -= 1;
        }
        (child, pending.node)
    }
}

/// Traces one ray with `short_stack` entries (at most [`MAX_SHORT_STACK`]).
pub fn trace<P: RayTriangle, const W: usize, Q: RayQuery, O: Observer>(
    bvh: &WideBvh<P, W>,
    short_stack: u32,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let mut ring = Ring::new(short_stack);
    descend(bvh, 0, &mut ring, ray, query, &mut best, observer);
    best
}

/// Looks for a hit that is better than `best`, in which the tree's triangles have indices from `base`. Returns whether an
/// any-hit query is answered.
pub(crate) fn descend<P: RayTriangle, const W: usize, Q: RayQuery, O: Observer>(
    bvh: &WideBvh<P, W>,
    base: u32,
    ring: &mut Ring<W>,
    ray: &Ray,
    query: Q,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    let any = query.query() == Query::Any;
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    walk(&bvh.tree, ring, &slab, ray.t_min, best, observer, |node, _, best, observer| {
        leaf::intersect(bvh.leaves(base), node, prepared, query, best, observer) && any
    })
}

/// Walks a tree, whatever its leaves hold. `at_leaf` gets a leaf, the ring, the best hit so far and the observer, and says whether the walk is
/// over; so does `walk`. Entries that the ring has already are those of another tree, and stay. Every node is entered once, and tested once more
/// for each of its children at most, which bounds the loop.
pub(crate) fn walk<const W: usize, O: Observer>(
    tree: &WideNodes<W>,
    ring: &mut Ring<W>,
    slab: &SlabRay,
    t_min: f32,
    best: &mut Hit,
    observer: &mut O,
    mut at_leaf: impl FnMut(NodeRef, &mut Ring<W>, &mut Hit, &mut O) -> bool,
) -> bool {
    let bottom = ring.depth;
    let (mut at, mut parent) = (NodeRef::inner(0, 0), 0);
    loop {
        if at.is_inner() {
            let (children, count) = near_to_far(tree, slab, at.link, t_min, best.t, observer);
            if count > 1 {
                ring.push(Pending { node: at.link, children, next: 1, count: count as u8 }, observer);
            }
            if count > 0 {
                (at, parent) = (children[0].link, at.link);
                continue;
            }
        } else if at_leaf(at, ring, best, observer) {
            return true;
        }
        if ring.depth == bottom {
            return false;
        }
        if ring.depth > ring.lost {
            (at, parent) = ring.pop(observer);
            continue;
        }
        loop {
            if at == NodeRef::inner(0, 0) {
                return false;
            }
            observer.step(Op::Restart, parent);
            let (children, count) = near_to_far(tree, slab, parent, t_min, best.t, observer);
            // A node that is not among the children any more lies behind a hit found since, and so do those behind it.
            let place = children[..count].iter().position(|child| child.link == at);
            let next = place.and_then(|place| children[..count].get(place + 1));
            if let Some(next) = next {
                at = next.link;
                break;
            }
            (at, parent) = (NodeRef::inner(0, parent), tree.parents[parent as usize]);
        }
    }
}
