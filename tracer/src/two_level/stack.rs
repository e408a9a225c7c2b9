//! The traversal: that of a BVH with a full stack, binary or wide, for the TLAS and, at each of its leaves, for the BLAS of each instance.

use super::bottom_level::BottomLevel;
use super::structure::TwoLevel;
use super::tlas::TopLevel;
use crate::alpha::RayQuery;
use crate::observe::{Observer, Op};
use crate::ray::{Hit, Query, Ray};
use crate::triangle::RayTriangle;

pub(super) fn trace<P: RayTriangle, T: BottomLevel<P>, Q: RayQuery, O: Observer>(
    structure: &TwoLevel<P, T>,
    ray: &Ray,
    query: Q,
    cull_mask: u8,
    observer: &mut O,
) -> Hit {
    match query.query() {
        Query::Closest => run::<false, P, T, Q, O>(structure, ray, query, cull_mask, observer),
        Query::Any => run::<true, P, T, Q, O>(structure, ray, query, cull_mask, observer),
    }
}

#[inline(never)]
fn run<const ANY: bool, P: RayTriangle, T: BottomLevel<P>, Q: RayQuery, O: Observer>(
    structure: &TwoLevel<P, T>,
    ray: &Ray,
    query: Q,
    cull_mask: u8,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    structure.tlas.walk::<ANY, O>(ray, &mut best, observer, |instances, stacked, best, observer| {
        observer.leaf_visit();
        instances.iter().any(|&number| {
            enter(structure, number, ray, cull_mask, stacked, observer, |blas, base, ray, observer| {
                blas.descend::<ANY, Q, _>(base, ray, query, best, observer)
            })
        })
    });
    best
}

/// Reads the record of an instance and, unless its mask hides it, has `descend` look into its BLAS: it gets the tree, the number of its first
/// triangle, the ray in its space, and the observer. `stacked` entries of the TLAS are on the stack.
#[inline(always)]
pub(super) fn enter<P: RayTriangle, T: BottomLevel<P>, O: Observer>(
    structure: &TwoLevel<P, T>,
    number: u32,
    ray: &Ray,
    cull_mask: u8,
    stacked: u32,
    observer: &mut O,
    descend: impl FnOnce(&T, u32, &Ray, &mut InBlas<'_, O>) -> bool,
) -> bool {
    observer.step(Op::Instance, number);
    let placed = &structure.instances[number as usize];
    if placed.mask & cull_mask == 0 {
        return false;
    }
    let blas = structure.blas_of(placed);
    let mut in_blas = InBlas {
        outer: observer,
        first_node: blas.first_node,
        first_reference: blas.first_reference,
        stacked,
    };
    descend(&blas.tree, placed.first_primitive, &placed.object_ray(ray), &mut in_blas)
}

/// Tells `outer` of the steps within a BLAS, in the numbers of the whole structure.
pub(super) struct InBlas<'a, O> {
    outer: &'a mut O,
    first_node: u32,
    first_reference: u32,
    /// Entries that the TLAS has on the stack.
    stacked: u32,
}

impl<O: Observer> Observer for InBlas<'_, O> {
    #[inline(always)]
    fn step(&mut self, op: Op, id: u32) {
        let first = match op {
            Op::Node | Op::Up | Op::Restart => self.first_node,
            Op::Primitive | Op::AnyHit => self.first_reference,
            Op::Push | Op::Pop => self.stacked,
            Op::Instance => 0,
        };
        self.outer.step(op, first + id);
    }

    #[inline(always)]
    fn box_tests(&mut self, n: u32) {
        self.outer.box_tests(n);
    }

    #[inline(always)]
    fn plane_test(&mut self) {
        self.outer.plane_test();
    }

    #[inline(always)]
    fn leaf_visit(&mut self) {
        self.outer.leaf_visit();
    }

    #[inline(always)]
    fn stall(&mut self) {
        self.outer.stall();
    }
}
