//! Traversal of a wide BVH with a short stack, as Mesa's driver walks around the `ray_intersection` instruction of the Adreno 7xx and 8xx
//! (`tu_nir_lower_ray_query.cc`, `build_ray_traversal`): one loop, one node or leaf per trip.
//!
//! A stack entry is a node with those of its children that are still to be visited, the nearest first, so a node pushes once. The instruction gives no
//! distances, so what is popped is visited even where a hit has been found before it. The stack is a ring: a push onto a full one drops the oldest entry.
//! Where entries are lost the traversal climbs: it goes to the parent of the node that it has finished, tests the parent's boxes again, and goes on with
//! the child behind that node.

use super::stack::{Entry, near_to_far};
use super::tree::WideBvh;
use crate::aabb::SlabRay;
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
struct Ring<const W: usize> {
    entries: [Pending<W>; MAX_SHORT_STACK as usize],
    capacity: u32,
    /// Entries, lost ones included.
    depth: u32,
    /// Entries below this one are lost.
    lost: u32,
}

impl<const W: usize> Ring<W> {
    fn new(capacity: u32) -> Self {
        let children = [Entry { link: NodeRef::NOTHING, distance: 0.0 }; W];
        let filler = Pending { node: 0, children, next: 0, count: 0 };
        Self { entries: [filler; MAX_SHORT_STACK as usize], capacity, depth: 0, lost: 0 }
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

/// Traces one ray with `short_stack` entries (at most [`MAX_SHORT_STACK`]). Every node is entered once, and tested once more for each
/// of its children at most, which bounds the loop.
pub fn trace<P: RayTriangle, const W: usize, O: Observer>(
    bvh: &WideBvh<P, W>,
    short_stack: u32,
    ray: &Ray,
    query: Query,
    observer: &mut O,
) -> Hit {
    let any = query == Query::Any;
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    let mut best = Hit::miss(ray.t_max);
    let mut ring = Ring::<W>::new(short_stack.min(MAX_SHORT_STACK));
    let (mut at, mut parent) = (NodeRef::inner(0, 0), 0);
    loop {
        if at.is_inner() {
            let (children, count) = near_to_far(&bvh.tree, &slab, at.link, ray.t_min, best.t, observer);
            if count > 1 {
                ring.push(Pending { node: at.link, children, next: 1, count: count as u8 }, observer);
            }
            if count > 0 {
                (at, parent) = (children[0].link, at.link);
                continue;
            }
        } else if leaf::intersect(bvh.leaves(0), at, prepared, any, &mut best, observer) && any {
            return best;
        }
        if ring.depth == 0 {
            return best;
        }
        if ring.depth > ring.lost {
            (at, parent) = ring.pop(observer);
            continue;
        }
        loop {
            if at == NodeRef::inner(0, 0) {
                return best;
            }
            observer.step(Op::Restart, parent);
            let (children, count) = near_to_far(&bvh.tree, &slab, parent, ray.t_min, best.t, observer);
            // A node that is not among the children any more lies behind a hit found since, and so do those behind it.
            let place = children[..count].iter().position(|child| child.link == at);
            let next = place.and_then(|place| children[..count].get(place + 1));
            if let Some(next) = next {
                at = next.link;
                break;
            }
            (at, parent) = (NodeRef::inner(0, parent), bvh.tree.parents[parent as usize]);
        }
    }
}
