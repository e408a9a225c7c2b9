//! The structure and its construction.

use super::bottom_level::BottomLevel;
use super::stack;
use super::tlas::TopLevel;
use super::transform::{Transform, WorldToObject};
use crate::aabb::Aabb;
use crate::accel::check_costs;
use crate::alpha::RayQuery;
use crate::bvh::{Bvh, MAX_TRIANGLES};
use crate::error::Error;
use crate::observe::Observer;
use crate::ray::{Hit, Ray};
use crate::trace::Step;
use crate::triangle::{PreparedTriangle, RayTriangle};
use rayon::prelude::*;
use scenes::{Instance, Triangle};
use std::marker::PhantomData;

/// A mesh placed in the world, and which rays see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskedInstance {
    /// Mesh and place.
    pub placement: Instance,
    /// A ray sees the instance when this and its cull mask have a bit in common, as in Vulkan and DXR.
    pub mask: u8,
}

impl From<Instance> for MaskedInstance {
    /// Seen by every ray whose cull mask is not 0.
    fn from(placement: Instance) -> Self {
        Self { placement, mask: u8::MAX }
    }
}

/// The BVH of a mesh, and where its numbers begin.
#[derive(Clone)]
pub(super) struct Blas<T> {
    pub(super) tree: T,
    /// Id of the root; even.
    pub(super) first_node: u32,
    pub(super) first_reference: u32,
}

/// What the record of an instance holds.
#[derive(Clone, Debug)]
pub(super) struct PlacedBlas {
    pub(super) mesh: u32,
    pub(super) mask: u8,
    /// What is added to a triangle's index in the mesh.
    pub(super) first_primitive: u32,
    /// `None` for the identity.
    pub(super) to_object: Option<WorldToObject>,
    /// In the world; empty for an empty mesh.
    pub(super) bounds: Aabb,
}

impl PlacedBlas {
    /// The ray in the space of the mesh.
    #[inline]
    pub(super) fn object_ray(&self, ray: &Ray) -> Ray {
        self.to_object.as_ref().map_or(*ray, |transform| transform.ray(ray))
    }
}

/// A BLAS per mesh, a tree `T`, binary or wide, and a TLAS over their instances, whose nodes are of the same kind. The numbering of nodes, references and primitives is described in the [module's documentation](super).
#[derive(Clone)]
pub struct TwoLevel<P: RayTriangle = PreparedTriangle, T: BottomLevel<P> = Bvh<P>> {
    pub(super) tlas: T::Tlas,
    pub(super) blases: Vec<Blas<T>>,
    pub(super) instances: Vec<PlacedBlas>,
    triangles: PhantomData<P>,
}

impl TwoLevel {
    /// [`TwoLevel::build_for`] the test of Moller & Trumbore.
    ///
    /// # Errors
    /// As [`TwoLevel::build_for`].
    pub fn build(
        meshes: &[Vec<Triangle>],
        instances: &[MaskedInstance],
        sah_costs: [f64; 2],
    ) -> Result<Self, Error> {
        Self::build_for(meshes, instances, sah_costs)
    }
}

impl<P: RayTriangle> TwoLevel<P> {
    /// [`TwoLevel::build_with`] binary BLASes.
    ///
    /// # Errors
    /// As [`TwoLevel::build_with`].
    pub fn build_for(
        meshes: &[Vec<Triangle>],
        instances: &[MaskedInstance],
        sah_costs: [f64; 2],
    ) -> Result<Self, Error> {
        Self::build_with(meshes, instances, sah_costs, ())
    }
}

impl<P: RayTriangle, T: BottomLevel<P>> TwoLevel<P, T> {
    /// Builds a BLAS for each mesh with the SAH costs Ct and Ci, and the TLAS. Meshes may be empty, shared, or without an instance. The
    /// same comes out on any number of threads.
    ///
    /// # Errors
    /// A mesh, or the place of an instance, that the format of nodes cannot hold; costs out of range; a corner that is not finite; an instance of a mesh that does not exist, or whose transform is not
    /// finite, has no inverse in f32, or puts the mesh beyond f32; more triangles or nodes than ids can name.
    pub fn build_with(
        meshes: &[Vec<Triangle>],
        instances: &[MaskedInstance],
        sah_costs: [f64; 2],
        format: T::Format,
    ) -> Result<Self, Error> {
        check_costs(sah_costs)?;
        check_sizes(meshes, instances)?;
        let build = |mesh: &Vec<Triangle>| T::build(mesh, sah_costs, format);
        let trees =
            meshes.par_iter().map(build).collect::<Vec<_>>().into_iter().collect::<Result<Vec<T>, _>>()?;

        let mut placed = Vec::with_capacity(instances.len());
        let mut boxes = Vec::with_capacity(instances.len());
        let mut condition: f64 = 1.0;
        let mut first_primitive = 0;
        for (number, MaskedInstance { placement: Instance { mesh, transform }, mask }) in
            instances.iter().enumerate()
        {
            let refused = |why: String| Error::Options(format!("the transform of instance {number}: {why}"));
            let transform = Transform::new(transform).map_err(refused)?;
            let tree = &trees[*mesh as usize];
            let bounds = transform.world_box(&tree.bounds());
            if !(bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite())) {
                return Err(refused(
                    "it puts the mesh beyond the largest f32; use smaller scales or translations".to_owned(),
                ));
            }
            condition = condition.max(transform.condition());
            boxes.push(bounds);
            let to_object = transform.to_object();
            placed.push(PlacedBlas { mesh: *mesh, mask: *mask, first_primitive, to_object, bounds });
            first_primitive += tree.references().len() as u32;
        }

        let tlas = T::Tlas::build(&boxes, condition, format)?;
        let mut next_node = u64::from(tlas.node_count());
        let mut first_reference = 0;
        let mut blases = Vec::with_capacity(trees.len());
        for tree in trees {
            let first_node = next_node.next_multiple_of(2);
            next_node = first_node + u64::from(tree.node_count());
            let references = tree.references().len() as u32;
            blases.push(Blas { tree, first_node: first_node as u32, first_reference });
            first_reference += references;
        }
        if next_node > u64::from(Step::MAX_ID) + 1 {
            return Err(Error::Options(format!(
                "{next_node} nodes in all trees: a structure names at most {}; split the scene",
                Step::MAX_ID + 1
            )));
        }
        Ok(Self { tlas, blases, instances: placed, triangles: PhantomData })
    }

    /// Traces one ray, which sees the instances whose mask has a bit in common with `cull_mask`. Nearer child first in either level;
    /// the stack goes through both.
    ///
    /// A TLAS leaf makes an [`Op::Instance`](crate::Op::Instance) of each of its instances, hidden or not, as the mask is in the
    /// instance's record; the nodes of the BLAS follow, from its root, unless the instance is hidden. Every instance is visited at most
    /// once, and every node at most once for each, which bounds the loop.
    #[inline]
    pub fn trace<Q: RayQuery, O: Observer>(
        &self,
        ray: &Ray,
        query: Q,
        cull_mask: u8,
        observer: &mut O,
    ) -> Hit {
        stack::trace(self, ray, query, cull_mask, observer)
    }

    /// The ray in the space of an instance's mesh, as the traversal transforms it: `t` is the same parameter in both spaces, the
    /// identity gives the same bits.
    ///
    /// # Panics
    /// When there is no such instance.
    pub fn object_ray(&self, instance: u32, ray: &Ray) -> Ray {
        self.instances[instance as usize].object_ray(ray)
    }

    /// Most entries that the stack can have, with one to spare as in [`TraceHeader`](crate::TraceHeader): those of the TLAS and
    /// what the neediest BLAS takes.
    pub fn stack_entries(&self) -> u32 {
        let deepest = self.instances.iter().map(|placed| self.blas_of(placed).tree.stack_entries()).max();
        self.tlas.stack_entries() + deepest.unwrap_or(0) + 1
    }

    /// Longest path from the root of the TLAS to a node of a BLAS, in edges; the way into an instance is one.
    pub fn depth(&self) -> u32 {
        let deepest = self.instances.iter().map(|placed| self.blas_of(placed).tree.depth() + 1).max();
        self.tlas.depth() + deepest.unwrap_or(0)
    }

    /// Leaves of all BLASes.
    pub fn leaf_count(&self) -> u64 {
        self.blases.iter().map(|blas| blas.tree.leaf_count()).sum()
    }

    /// Nodes of all trees.
    pub fn node_count(&self) -> u64 {
        let blases = self.blases.iter().map(|blas| u64::from(blas.tree.node_count()));
        u64::from(self.tlas.node_count()) + blases.sum::<u64>()
    }

    pub(super) fn blas_of(&self, placed: &PlacedBlas) -> &Blas<T> {
        &self.blases[placed.mesh as usize]
    }
}

/// Refuses what the builders cannot hold or number.
fn check_sizes(meshes: &[Vec<Triangle>], instances: &[MaskedInstance]) -> Result<(), Error> {
    let stored: usize = meshes.iter().map(Vec::len).sum();
    if stored > MAX_TRIANGLES || instances.len() > MAX_TRIANGLES {
        return Err(Error::Options(format!(
            "{stored} triangles and {} instances: a structure holds at most {MAX_TRIANGLES} of either; split the scene",
            instances.len()
        )));
    }
    for (mesh, triangles) in meshes.iter().enumerate() {
        if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
            return Err(Error::Options(format!(
                "triangle {index} of mesh {mesh} has a corner that is not finite; remove it before building a structure"
            )));
        }
    }
    let mut flattened = 0;
    for (number, MaskedInstance { placement, .. }) in instances.iter().enumerate() {
        let Some(mesh) = meshes.get(placement.mesh as usize) else {
            return Err(Error::Options(format!(
                "instance {number} is of mesh {}, but there are {} meshes, counted from 0",
                placement.mesh,
                meshes.len()
            )));
        };
        flattened += mesh.len() as u64;
    }
    if flattened >= u64::from(crate::ray::NO_HIT) {
        return Err(Error::Options(format!(
            "{flattened} triangles in all instances: ids have 32 bits; use fewer instances"
        )));
    }
    Ok(())
}
