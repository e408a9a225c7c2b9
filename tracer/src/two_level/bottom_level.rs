//! The trees that a BLAS can be.

use super::tlas::{BinaryTlas, TopLevel, WideTlas};
use crate::aabb::{Aabb, SlabRay};
use crate::alpha::RayQuery;
use crate::bvh::stack::{descend, walk};
use crate::bvh::{Bvh, BvhOptions};
use crate::error::Error;
use crate::observe::{Observer, Silent};
use crate::ray::{Hit, Ray};
use crate::topology::Topology;
use crate::triangle::RayTriangle;
use crate::wide::{self, NodeFormat, WideBvh};
use scenes::Triangle;

/// A tree over the triangles of a mesh, prepared for a test as `P`.
pub trait BottomLevel<P: RayTriangle>: Sized + Send + Sync {
    /// What it is built with besides the costs.
    type Format: Copy + Sync;
    /// The tree over its instances, whose nodes are of the same kind.
    type Tlas: TopLevel<Format = Self::Format>;

    /// Builds it with the SAH costs Ct and Ci.
    ///
    /// # Errors
    /// When the format cannot hold the mesh.
    fn build(mesh: &[Triangle], sah_costs: [f64; 2], format: Self::Format) -> Result<Self, Error>;
    /// The box around all triangles, as rays meet it; empty without one.
    fn bounds(&self) -> Aabb;
    /// Number of nodes.
    fn node_count(&self) -> u32;
    /// Longest path from the root to a node, in edges.
    fn depth(&self) -> u32;
    /// Number of leaves.
    fn leaf_count(&self) -> u64;
    /// Most entries that a full stack takes.
    fn stack_entries(&self) -> u32;
    /// Triangle indices (file order) of all leaves.
    fn references(&self) -> &[u32];
    /// Links and references without geometry.
    fn topology(&self) -> Topology;
    /// Whether the ray meets the box of a leaf.
    fn meets_leaf(&self, ray: &Ray) -> bool;
    /// Looks for a hit that is better than `best`, in which the mesh's triangles have indices from `base`. Returns whether an
    /// any-hit query is answered.
    fn descend<const ANY: bool, Q: RayQuery, O: Observer>(
        &self,
        base: u32,
        ray: &Ray,
        query: Q,
        best: &mut Hit,
        observer: &mut O,
    ) -> bool;
}

impl<P: RayTriangle> BottomLevel<P> for Bvh<P> {
    type Format = ();
    type Tlas = BinaryTlas;

    fn build(
        mesh: &[Triangle],
        [traversal_cost, intersection_cost]: [f64; 2],
        (): (),
    ) -> Result<Self, Error> {
        let options = BvhOptions { traversal_cost, intersection_cost, ..BvhOptions::MOBILE };
        Ok(Self::build_for(mesh, &options))
    }

    fn bounds(&self) -> Aabb {
        self.root_bounds
    }

    fn node_count(&self) -> u32 {
        Self::node_count(self)
    }

    fn depth(&self) -> u32 {
        self.depth
    }

    fn leaf_count(&self) -> u64 {
        self.statistics().leaves
    }

    fn stack_entries(&self) -> u32 {
        self.depth
    }

    fn references(&self) -> &[u32] {
        Self::references(self)
    }

    fn topology(&self) -> Topology {
        Topology::of_bvh(self)
    }

    fn meets_leaf(&self, ray: &Ray) -> bool {
        let slab = SlabRay::new(ray, &self.slack);
        let mut unused = Hit::miss(ray.t_max);
        walk::<true, _>(self.pair_tree(), &slab, ray.t_min, &mut unused, &mut Silent, |_, _, _, _| true)
    }

    #[inline(always)]
    fn descend<const ANY: bool, Q: RayQuery, O: Observer>(
        &self,
        base: u32,
        ray: &Ray,
        query: Q,
        best: &mut Hit,
        observer: &mut O,
    ) -> bool {
        descend::<ANY, P, Q, O>(self, base, ray, query, best, observer)
    }
}

impl<P: RayTriangle, const W: usize> BottomLevel<P> for WideBvh<P, W> {
    type Format = NodeFormat;
    type Tlas = WideTlas<W>;

    fn build(mesh: &[Triangle], sah_costs: [f64; 2], format: NodeFormat) -> Result<Self, Error> {
        Self::build_for(mesh, sah_costs, format)
    }

    fn bounds(&self) -> Aabb {
        Self::bounds(self)
    }

    fn node_count(&self) -> u32 {
        self.statistics().nodes as u32
    }

    fn depth(&self) -> u32 {
        Self::depth(self)
    }

    fn leaf_count(&self) -> u64 {
        self.statistics().leaves
    }

    fn stack_entries(&self) -> u32 {
        Self::stack_entries(self)
    }

    fn references(&self) -> &[u32] {
        Self::references(self)
    }

    fn topology(&self) -> Topology {
        Topology::of_wide(self)
    }

    fn meets_leaf(&self, ray: &Ray) -> bool {
        wide::stack::meets_leaf(self, ray)
    }

    #[inline(always)]
    fn descend<const ANY: bool, Q: RayQuery, O: Observer>(
        &self,
        base: u32,
        ray: &Ray,
        query: Q,
        best: &mut Hit,
        observer: &mut O,
    ) -> bool {
        wide::stack::descend::<ANY, P, W, Q, O>(self, base, ray, query, best, observer)
    }
}
