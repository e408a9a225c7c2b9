//! Stackless BVH traversal by parent links (Hapala, Davidovic, Wald, Havran & Slusallek, SCCG 2011).
//!
//! A three-state automaton: a node is entered from its parent, from its sibling or from a child. It tests the boxes and triangles
//! that a stack traversal in axis order tests, in the same order, but fetches every inner node a second time on the way up.
//! Which child is nearer must be a pure function of node and ray (split axis, sign of the direction): a distance order would change
//! between the way down and the way up as the nearest hit moves.

use super::leaf;
use super::tree::{Bvh, BvhNodeKind, NodeRef};
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;

/// What the traversal needs beside the tree: each node's parent (the root is its own), 48-byte records on a GPU.
#[derive(Clone, Debug)]
pub struct ParentLinks {
    parents: Vec<u32>,
}

impl ParentLinks {
    /// Computes the links of a tree.
    pub fn new<P: RayTriangle>(bvh: &Bvh<P>) -> Self {
        let mut parents = vec![0; bvh.node_count() as usize];
        for (index, node) in (0..).zip(bvh.nodes()) {
            if let BvhNodeKind::Inner { left, .. } = node.kind {
                parents[left as usize] = index;
                parents[left as usize + 1] = index;
            }
        }
        Self { parents }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum From {
    Parent,
    Sibling,
    Child,
}

/// Traces one ray. Each node is entered at most once in each of the three states, which bounds the loop.
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    bvh: &Bvh<P>,
    links: &ParentLinks,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    let mut best = Hit::miss(ray.t_max);
    // Siblings are neighbours: the far child is the other one of the pair.
    let near_child = |node: NodeRef| node.link + u32::from(ray.direction[node.axis()] < 0.0);
    let sibling = |index: u32| ((index - 1) ^ 1) + 1;
    let parent = |index: u32| links.parents[index as usize];

    let mut current = 0;
    let mut from = From::Parent;
    loop {
        if from == From::Child {
            if current == 0 {
                return best;
            }
            observer.step(Op::Up, current);
            if current == near_child(bvh.packed_node(parent(current)).1) {
                current = sibling(current);
                from = From::Sibling;
            } else {
                current = parent(current);
            }
            continue;
        }

        observer.step(Op::Node, current);
        observer.box_tests(1);
        let (bounds, node) = bvh.packed_node(current);
        let (near, far) = slab.entry_exit(&bounds, ray.t_min, best.t);
        let hit = near <= far;
        if hit && node.is_inner() {
            current = near_child(node);
            from = From::Parent;
            continue;
        }
        let found = hit && leaf::intersect(bvh.leaves(0), node, prepared, query, &mut best, observer);
        if (found && query.query() == Query::Any) || current == 0 {
            return best;
        }
        if from == From::Parent {
            current = sibling(current);
            from = From::Sibling;
        } else {
            current = parent(current);
            from = From::Child;
        }
    }
}
