//! kd-backtrack (Foley & Sugerman 2005, in the form of Sousa et al. 2019): nodes hold their cell and their parent; after a leaf
//! the search climbs to the first ancestor whose cell the ray leaves later, and descends from there.
//!
//! Sousa et al. move a point along the ray and ask of each ancestor whether it ends behind the point. An ancestor ends
//! later than its child exactly when the ray left the child through the ancestor's plane: when the child is the nearer one and
//! the ray meets the other too. Asked that way, cells at the same distance stay apart (module `descent`), and neither a
//! corner nor a cell without thickness can hold the search up.

use super::cells::KdCells;
use super::descent::{Descent, Visit};
use super::tree::{KdNodeKind, KdTree};
use crate::alpha::RayQuery;
use crate::leaf;
use crate::observe::{Observer, Op};
use crate::plane_ray::PlaneRay;
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;

/// Traces one ray; `cells` are those of `tree`. Each node is entered from above and left upwards at most once, which bounds the
/// loops.
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    tree: &KdTree<P>,
    cells: &KdCells,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let prepared = P::prepare(ray);
    let Some((plane_ray, interval)) = PlaneRay::new(&tree.slack, ray, observer) else { return best };
    let mut visit = Visit { node: 0, interval };
    loop {
        observer.step(Op::Node, visit.node);
        match tree.nodes[visit.node as usize].kind() {
            KdNodeKind::Inner { axis, split, left } => {
                observer.plane_test();
                visit = match plane_ray.descend(axis, split, left, visit.interval) {
                    Descent::One(child) | Descent::Both(child, _) => child,
                };
            }
            KdNodeKind::Leaf { first, count } => {
                let answered =
                    leaf::intersect(tree.leaves(), (first, count), prepared, query, &mut best, observer);
                if answered || visit.interval.settles(&best) {
                    return best;
                }
                let Some(next) = climb(tree, cells, &plane_ray, ray, visit.node, observer) else {
                    return best;
                };
                visit = next;
            }
        }
    }
}

/// The next cell after that of `child`: the far child of the lowest ancestor whose near child is done.
#[inline(always)]
fn climb<P: RayTriangle, O: Observer>(
    tree: &KdTree<P>,
    cells: &KdCells,
    plane_ray: &PlaneRay,
    ray: &Ray,
    mut child: u32,
    observer: &mut O,
) -> Option<Visit> {
    loop {
        let parent = cells.parents()[child as usize];
        if parent == KdCells::NO_PARENT {
            return None;
        }
        observer.step(Op::Up, parent);
        if let KdNodeKind::Inner { axis, split, left } = tree.nodes[parent as usize].kind()
            && plane_ray.is_near(axis, left, child)
        {
            let interval = plane_ray.interval(ray, &cells.bounds()[parent as usize]);
            if let Descent::Both(_, far) = plane_ray.descend(axis, split, left, interval) {
                return Some(far);
            }
        }
        child = parent;
    }
}
