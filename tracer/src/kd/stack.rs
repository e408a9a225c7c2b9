//! kd-tree traversal with a full stack: the far child waits while the near one is visited (Havran 2000).

use super::descent::{Descent, Visit};
use super::options::KdOptions;
use super::tree::{KdNodeKind, KdTree};
use crate::alpha::RayQuery;
use crate::leaf;
use crate::observe::{Observer, Op};
use crate::plane_ray::PlaneRay;
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;

/// One far child for each level of the deepest tree.
const CAPACITY: usize = KdOptions::MAX_DEPTH as usize;

/// Traces one ray. Every node is fetched at most once, which bounds the loops: there is nothing to stall on.
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    tree: &KdTree<P>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let prepared = P::prepare(ray);
    let Some((plane_ray, interval)) = PlaneRay::new(&tree.slack, ray, observer) else { return best };
    let mut stack = [Visit::default(); CAPACITY];
    let mut top = 0;
    let mut visit = Visit { node: 0, interval };
    loop {
        observer.step(Op::Node, visit.node);
        match tree.nodes[visit.node as usize].kind() {
            KdNodeKind::Inner { axis, split, left } => {
                observer.plane_test();
                visit = match plane_ray.descend(axis, split, left, visit.interval) {
                    Descent::One(only) => only,
                    Descent::Both(near, far) => {
                        observer.step(Op::Push, top as u32);
                        stack[top] = far;
                        top += 1;
                        near
                    }
                };
            }
            KdNodeKind::Leaf { first, count } => {
                let answered =
                    leaf::intersect(tree.leaves(), (first, count), prepared, query, &mut best, observer);
                if answered || visit.interval.settles(&best) || top == 0 {
                    return best;
                }
                top -= 1;
                observer.step(Op::Pop, top as u32);
                visit = stack[top];
            }
        }
    }
}
