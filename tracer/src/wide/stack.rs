//! Traversal of a wide BVH with a full stack, nearest child first: while-while, all children's boxes tested at their parent.
//!
//! The children that are hit are sorted by the distance at which the ray enters their boxes, among equals by their place. The nearest is next, the
//! others are pushed, the farthest first.

use super::tree::WideBvh;
use crate::aabb::SlabRay;
use crate::bvh::{BvhOptions, NodeRef, leaf};
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;
use std::mem::MaybeUninit;

/// Stack capacity: at each level of the deepest tree, all children of the widest node but one.
const CAPACITY: usize = 7 * (BvhOptions::MAX_DEPTH as usize + 1);

#[derive(Clone, Copy)]
struct Entry {
    link: NodeRef,
    /// Distance at which the ray enters its box.
    distance: f32,
}

/// Traces one ray. Every node is visited at most once, so the loop is bounded by the tree.
#[inline]
pub fn trace<P: RayTriangle, const W: usize, O: Observer>(
    bvh: &WideBvh<P, W>,
    ray: &Ray,
    query: Query,
    observer: &mut O,
) -> Hit {
    match query {
        Query::Closest => run::<false, P, W, O>(bvh, ray, observer),
        Query::Any => run::<true, P, W, O>(bvh, ray, observer),
    }
}

#[inline(never)]
fn run<const ANY: bool, P: RayTriangle, const W: usize, O: Observer>(
    bvh: &WideBvh<P, W>,
    ray: &Ray,
    observer: &mut O,
) -> Hit {
    let prepared = P::prepare(ray);
    let slab = SlabRay::new(ray, &bvh.slack);
    let mut best = Hit::miss(ray.t_max);
    let mut stack = [const { MaybeUninit::<Entry>::uninit() }; CAPACITY];
    let mut top = 0;
    let mut next = NodeRef::inner(0, 0);
    loop {
        if next.is_inner() {
            observer.step(Op::Node, next.link);
            let node = &bvh.nodes[next.link as usize];
            observer.box_tests(node.children);
            let (entries, hits) = slab.entries(&node.planes, ray.t_min, best.t);
            let mut hit = [Entry { link: next, distance: 0.0 }; W];
            let mut count = 0;
            for child in 0..node.children as usize {
                if hits >> child & 1 != 0 {
                    let entry = Entry { link: node.links[child], distance: entries[child] };
                    let mut place = count;
                    while place > 0 && hit[place - 1].distance > entry.distance {
                        hit[place] = hit[place - 1];
                        place -= 1;
                    }
                    hit[place] = entry;
                    count += 1;
                }
            }
            if count > 0 {
                for farther in hit[1..count].iter().rev() {
                    observer.step(Op::Push, top as u32);
                    stack[top].write(*farther);
                    top += 1;
                }
                next = hit[0].link;
                continue;
            }
        } else if leaf::intersect(bvh.leaves(), next, prepared, ANY, &mut best, observer) && ANY {
            return best;
        }
        loop {
            if top == 0 {
                return best;
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
