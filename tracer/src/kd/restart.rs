//! kd-restart (Foley & Sugerman 2005): no stack; after each leaf the search starts again at the root.
//!
//! Foley and Sugerman remember where the last leaf ended and let the plane tests lead a new descent past all that lies before.
//! One number cannot tell apart the cells that a ray meets at the same distance (module `descent`). So the place is remembered as a trail,
//! one bit for each level: set where the near child is done and the descent goes to the far one. Away from such ties
//! both descend through the same nodes.

use super::descent::{Descent, Visit};
use super::options::KdOptions;
use super::push_down::MAX_SHORT_STACK;
use super::tree::{KdNodeKind, KdTree};
use crate::alpha::RayQuery;
use crate::leaf;
use crate::observe::{Observer, Op};
use crate::plane_ray::PlaneRay;
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;

const _: () = assert!(KdOptions::MAX_DEPTH <= u64::BITS, "the trail has a bit for each level");

/// Traces one ray. Each start leads to a leaf later in the ray's order than the one before, which bounds the loops.
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    tree: &KdTree<P>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    search::<false, P, Q, O>(tree, 0, ray, query, observer)
}

/// A node to descend from.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    visit: Visit,
    level: u32,
}

/// The loop of kd-restart and push-down. With `PUSH_DOWN` the node to start from moves down while the rest of the ray lies
/// within one child. Up to `short_stack` far children are kept, the latest ones.
pub(super) fn search<const PUSH_DOWN: bool, P: RayTriangle, Q: RayQuery, O: Observer>(
    tree: &KdTree<P>,
    short_stack: u32,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let prepared = P::prepare(ray);
    let Some((plane_ray, interval)) = PlaneRay::new(&tree.slack, ray, observer) else { return best };
    let mut stack = ShortStack::new(short_stack);
    let mut restart = Start { visit: Visit { node: 0, interval }, level: 0 };
    let mut here = restart;
    let mut trail = Trail::default();
    let mut push_down = PUSH_DOWN;
    loop {
        observer.step(Op::Node, here.visit.node);
        match tree.nodes[here.visit.node as usize].kind() {
            KdNodeKind::Inner { axis, split, left } => {
                observer.plane_test();
                let level = here.level;
                here.level += 1;
                here.visit = match plane_ray.descend(axis, split, left, here.visit.interval) {
                    Descent::One(only) => only,
                    Descent::Both(_, far) if trail.near_is_done(level) => far,
                    Descent::Both(near, far) => {
                        trail.wait_for_near(level);
                        push_down = false;
                        if let Some(depth) = stack.push(Start { visit: far, level: here.level }) {
                            observer.step(Op::Push, depth);
                        }
                        near
                    }
                };
                if PUSH_DOWN && push_down {
                    restart = here;
                }
            }
            KdNodeKind::Leaf { first, count } => {
                let answered =
                    leaf::intersect(tree.leaves(), (first, count), prepared, query, &mut best, observer);
                if answered || here.visit.interval.settles(&best) || !trail.finish_near() {
                    return best;
                }
                if let Some((depth, far)) = stack.pop() {
                    observer.step(Op::Pop, depth);
                    here = far;
                } else {
                    observer.step(Op::Restart, restart.visit.node);
                    here = restart;
                    trail.restart();
                    push_down = PUSH_DOWN;
                }
            }
        }
    }
}

/// Which levels of the path have two children to visit, and whether the near one is done. Bit `l` stands for the node at
/// level `l`, the root being at 0. Read with level 0 as the highest digit, `done` rises with each leaf.
#[derive(Clone, Copy, Debug, Default)]
struct Trail {
    /// The far child is being visited.
    done: u64,
    /// The near child is being visited, the far one is to come.
    waiting: u64,
}

impl Trail {
    #[inline(always)]
    fn near_is_done(&self, level: u32) -> bool {
        self.done >> level & 1 != 0
    }

    #[inline(always)]
    fn wait_for_near(&mut self, level: u32) {
        self.waiting |= 1 << level;
    }

    /// Moves on to the far child of the deepest node that waits; returns whether there is one.
    #[inline(always)]
    fn finish_near(&mut self) -> bool {
        let Some(level) = self.waiting.checked_ilog2() else { return false };
        let bit = 1 << level;
        self.waiting ^= bit;
        self.done = self.done & (bit - 1) | bit;
        true
    }

    /// A new descent finds again which nodes wait.
    #[inline(always)]
    fn restart(&mut self) {
        self.waiting = 0;
    }
}

/// A stack that drops its oldest entry when full: a ring of `capacity` slots.
struct ShortStack {
    entries: [Start; MAX_SHORT_STACK as usize],
    capacity: u32,
    /// The slot of the next entry.
    next: u32,
    kept: u32,
}

impl ShortStack {
    fn new(capacity: u32) -> Self {
        let entries = [Start::default(); MAX_SHORT_STACK as usize];
        Self { entries, capacity: capacity.min(MAX_SHORT_STACK), next: 0, kept: 0 }
    }

    /// Returns the slot written; `None` without a stack.
    #[inline(always)]
    fn push(&mut self, far: Start) -> Option<u32> {
        if self.capacity == 0 {
            return None;
        }
        let slot = self.next;
        self.entries[slot as usize] = far;
        self.next = if slot + 1 == self.capacity { 0 } else { slot + 1 };
        self.kept = (self.kept + 1).min(self.capacity);
        Some(slot)
    }

    /// The latest entry and its slot.
    #[inline(always)]
    fn pop(&mut self) -> Option<(u32, Start)> {
        self.kept = self.kept.checked_sub(1)?;
        let slot = if self.next == 0 { self.capacity } else { self.next } - 1;
        self.next = slot;
        Some((slot, self.entries[slot as usize]))
    }
}

#[cfg(test)]
mod tests {
    use crate::aabb::{Aabb, PlaneSlack};
    use crate::kd::{KdCells, KdNode, KdOptions, KdTree, backtrack, push_down, restart, stack};
    use crate::observe::{NodeFetch, WorkCounter};
    use crate::ray::{Query, Ray};
    use crate::triangle::PreparedTriangle;
    use glam::Vec3;
    use scenes::Triangle;

    /// A plate at each x from 0 to `depth`, and a chain of nodes that each take the last plate off.
    fn chain(depth: u32) -> KdTree {
        let plate = |x: u32| {
            let x = x as f32;
            Triangle { v: [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0), Vec3::new(x, 0.0, 1.0)] }
        };
        let plates: Vec<_> = (0..=depth).map(plate).collect();
        let inner = |last: u32, left| KdNode::inner(0, last as f32 - 0.5, left);
        let mut nodes = vec![inner(depth, 1)];
        for last in (1..depth).rev() {
            nodes.extend([inner(last, nodes.len() as u32 + 2), KdNode::leaf(last + 1, 1)]);
        }
        nodes.extend([KdNode::leaf(0, 1), KdNode::leaf(1, 1)]);
        KdTree {
            nodes,
            references: (0..=depth).collect(),
            bounds: plates.iter().map(Aabb::of_triangle).fold(Aabb::EMPTY, Aabb::union),
            slack: PlaneSlack::new(&plates.iter().map(Aabb::of_triangle).collect::<Vec<_>>()),
            depth,
            triangles: plates.iter().map(PreparedTriangle::from).collect(),
        }
    }

    #[test]
    fn at_the_largest_depth_every_level_can_wait() {
        let tree = chain(KdOptions::MAX_DEPTH);
        let cells = KdCells::new(&tree);
        let end = KdOptions::MAX_DEPTH as f32;
        let trace = |ray: &Ray| {
            let mut counters = [WorkCounter::new(NodeFetch::Single); 6];
            let [a, b, c, d, e, f] = &mut counters;
            let hits = [
                stack::trace(&tree, ray, Query::Closest, a),
                restart::trace(&tree, ray, Query::Closest, b),
                push_down::trace(&tree, 0, ray, Query::Closest, c),
                push_down::trace(&tree, 1, ray, Query::Closest, d),
                push_down::trace(&tree, 64, ray, Query::Closest, e),
                backtrack::trace(&tree, &cells, ray, Query::Closest, f),
            ];
            (hits, counters.map(|counter| counter.work()))
        };
        for (origin, direction) in [(-1.0, Vec3::X), (end + 1.0, Vec3::NEG_X)] {
            let beside = Ray::new(Vec3::new(origin, 0.9, 0.9), direction);
            let (hits, work) = trace(&beside);
            assert!(hits.iter().all(|hit| !hit.is_hit()));
            assert!(work.iter().all(|work| work.leaf_visits == u64::from(KdOptions::MAX_DEPTH) + 1));
            for plate in 0..=KdOptions::MAX_DEPTH {
                let from = (plate as f32 - origin).abs() - 0.5;
                let ray = Ray { t_min: from, ..Ray::new(Vec3::new(origin, 0.25, 0.25), direction) };
                let (hits, _) = trace(&ray);
                assert!(hits.iter().all(|hit| hit.primitive == plate), "plate {plate}: {hits:?}");
            }
        }
    }
}
