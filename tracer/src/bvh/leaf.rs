//! The triangle loop of a BVH leaf, shared by all BVH traversals.

use super::tree::NodeRef;
use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query};
use crate::triangle::{GROUP, RayTriangle, TriangleGroup};

/// What the leaves of a tree refer to.
#[derive(Clone, Copy)]
pub(crate) struct Leaves<'a, P: RayTriangle> {
    /// Triangle indices, leaf after leaf.
    pub(crate) references: &'a [u32],
    /// The triangles in the same order; a leaf begins a new group.
    pub(crate) groups: &'a [P::Group],
    /// What the index of the tree's first triangle is in a hit.
    pub(crate) base: u32,
}

/// Tests a leaf's triangles, keeping the nearest hit in `best`; among equal distances the lowest triangle index wins, so that
/// every structure gives the same answer. [`Query::Any`] returns at the first hit that the query accepts. Returns whether one was found.
///
/// Triangles are tested in groups. Hits and steps are those of a loop over single triangles: with [`Query::Any`], the triangles behind
/// the hit of a group count as not tested.
#[inline(always)]
pub(crate) fn intersect<P: RayTriangle, Q: RayQuery, O: Observer>(
    Leaves { references, groups, base }: Leaves<'_, P>,
    leaf: NodeRef,
    ray: P::Ray<'_>,
    query: Q,
    best: &mut Hit,
    observer: &mut O,
) -> bool {
    observer.leaf_visit();
    let first = leaf.link as usize;
    let count = leaf.count() as usize;
    let groups = &groups[first..first + count.div_ceil(GROUP)];
    let mut found = false;
    for (index, group) in groups.iter().enumerate() {
        let hits = group.intersect(ray, best.t);
        let filled = (count - index * GROUP).min(GROUP) as u32;
        // Of the group's triangles, those up to here have been told to the observer.
        let mut told = group.first();
        let mut tell = |end: u32, observer: &mut O| {
            (told..end).for_each(|position| observer.step(Op::Primitive, position));
            told = end;
        };
        let mut lanes = hits.lanes;
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let (t, u, v) = hits.of_lane(lane as usize);
            let position = group.first() + lane;
            let primitive = base + references[position as usize];
            if t < best.t || (t <= best.t && primitive < best.primitive) {
                tell(position + 1, observer);
                let hit = Hit { t, u, v, primitive };
                if !query.accepts(&hit, position, observer) {
                    continue;
                }
                *best = hit;
                found = true;
                if query.query() == Query::Any {
                    return true;
                }
            }
        }
        tell(group.first() + filled, observer);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{Bvh, BvhOptions, stack};
    use crate::ray::{Query, Ray};
    use glam::Vec3;
    use scenes::Triangle;

    struct Tested(Vec<u32>);

    impl Observer for Tested {
        fn step(&mut self, op: Op, id: u32) {
            if op == Op::Primitive {
                self.0.push(id);
            }
        }
    }

    #[test]
    fn a_leaf_of_any_size_counts_as_tested_one_by_one() {
        let missed = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        let hit = Triangle { v: [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y] };
        let ray = Ray::new(Vec3::new(0.7, 0.7, -1.0), Vec3::Z);
        for count in 1..=2 * GROUP + 1 {
            for place in 0..count {
                let mut triangles = vec![missed; count];
                triangles[place] = hit;
                // All boxes are the same, so there is nothing to split.
                let bvh = Bvh::build(&triangles, &BvhOptions::EQUAL_COSTS);
                assert_eq!(bvh.node_count(), 1);
                for (query, tested) in [(Query::Closest, count), (Query::Any, place + 1)] {
                    let mut seen = Tested(Vec::new());
                    let found = stack::trace(&bvh, &ray, query, &mut seen);
                    assert_eq!((found.t, found.primitive), (1.0, place as u32));
                    assert_eq!(
                        seen.0,
                        (0..tested as u32).collect::<Vec<_>>(),
                        "{query:?} {place} of {count}"
                    );
                }
            }
        }
    }
}
