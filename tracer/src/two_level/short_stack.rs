//! The traversal with a short stack, one for both levels, as Mesa's driver walks around the instruction of the Adreno 7xx and 8xx that tests nodes
//! (`tu_nir_lower_ray_query.cc`).

use super::stack::enter;
use super::structure::TwoLevel;
use crate::aabb::SlabRay;
use crate::alpha::RayQuery;
use crate::observe::Observer;
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;
use crate::wide::WideBvh;
use crate::wide::short_stack::{Ring, descend, walk};

impl<P: RayTriangle, const W: usize> TwoLevel<P, WideBvh<P, W>> {
    /// [`Self::trace`] with a [short stack](crate::wide::short_stack) of so many entries (at most
    /// [`MAX_SHORT_STACK`](crate::bvh::restart_trail::MAX_SHORT_STACK)), which both levels share.
    #[inline]
    pub fn trace_short_stack<Q: RayQuery, O: Observer>(
        &self,
        short_stack: u32,
        ray: &Ray,
        query: Q,
        cull_mask: u8,
        observer: &mut O,
    ) -> Hit {
        let tlas = &self.tlas;
        let slab = SlabRay::new(ray, &tlas.slack);
        let mut best = Hit::miss(ray.t_max);
        let mut ring = Ring::new(short_stack);
        walk(&tlas.tree, &mut ring, &slab, ray.t_min, &mut best, observer, |leaf, ring, best, observer| {
            observer.leaf_visit();
            tlas.instances.of(leaf).iter().any(|&number| {
                // Entries are numbered by their place in the ring.
                enter(self, number, ray, cull_mask, 0, observer, |blas, base, ray, observer| {
                    descend(blas, base, ring, ray, query, best, observer)
                })
            })
        });
        best
    }
}
