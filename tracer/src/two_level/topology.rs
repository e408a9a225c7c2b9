//! The shape of a two-level structure without its geometry.

use super::bottom_level::BottomLevel;
use super::structure::TwoLevel;
use super::tlas::TopLevel;
use crate::ray::NO_HIT;
use crate::topology::{Topology, TopologyNode};
use crate::trace::Step;
use crate::triangle::RayTriangle;
use std::ops::Range;

/// What a two-level structure has besides nodes and references: which of them belong to which tree, and the instances.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    /// Nodes of the TLAS, which come first.
    pub tlas_nodes: u32,
    /// Instance at each position that a leaf of the TLAS names.
    pub tlas_references: Vec<u32>,
    /// The BLAS of each mesh.
    pub blases: Vec<BlasPlace>,
    /// Of each instance, the mesh.
    pub meshes: Vec<u32>,
}

/// Where the tree of a mesh lies in the numbers of the whole structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlasPlace {
    /// Its nodes, root first; the root's id is even.
    pub nodes: Range<u32>,
    /// Its positions in the reference list. As each triangle of a mesh has one, these are also the numbers of its triangles
    /// among those of all meshes.
    pub references: Range<u32>,
}

impl Levels {
    /// The BLAS of an instance.
    pub fn blas_of(&self, instance: u32) -> Option<&BlasPlace> {
        self.blases.get(*self.meshes.get(instance as usize)? as usize)
    }

    /// Triangles of all instances; `None` where they are more than ids can name.
    pub fn scene_triangles(&self) -> Option<u32> {
        let triangles = (0..self.meshes.len() as u32).map(|instance| self.blas_of(instance));
        let sum = triangles.flatten().map(|blas| blas.references.len() as u64).sum::<u64>();
        u32::try_from(sum).ok().filter(|&sum| sum < NO_HIT)
    }
}

impl Topology {
    /// The shape of a TLAS over BLASes, each in numbers of its own: a TLAS whose references are instances, a BLAS per mesh, and the
    /// mesh of each instance. Numbered as the [module](super) says; between trees, a node may be left out, which nothing links to.
    ///
    /// # Errors
    /// A sentence when there are more nodes, references or triangles than steps can name, or an instance of a mesh that is not
    /// there.
    pub fn of_two_levels(tlas: Self, blases: Vec<Self>, meshes: Vec<u32>) -> Result<Self, String> {
        let Self { mut nodes, references: tlas_references, .. } = tlas;
        if let Some(mesh) = meshes.iter().find(|&&mesh| mesh as usize >= blases.len()) {
            return Err(format!("an instance of mesh {mesh} of {}", blases.len()));
        }
        let tlas_nodes = nodes.len() as u32;
        let (mut references, mut seconds) = (Vec::new(), Vec::new());
        let mut places = Vec::with_capacity(blases.len());
        for blas in blases {
            nodes.resize(nodes.len().next_multiple_of(2), TopologyNode::Leaf { first: 0, count: 0 });
            let limit = Step::MAX_ID as usize;
            if nodes.len() + blas.nodes.len() > limit || references.len() + blas.references.len() > limit {
                return Err(format!("more than {limit} nodes or references in all trees"));
            }
            let (first_node, first_reference) = (nodes.len() as u32, references.len() as u32);
            nodes.extend(blas.nodes.iter().map(|node| node.moved(first_node, first_reference)));
            references
                .extend(blas.references.iter().map(|&reference| first_reference.wrapping_add(reference)));
            seconds.extend(blas.seconds.iter().map(|&second| first_reference.wrapping_add(second)));
            places.push(BlasPlace {
                nodes: first_node..nodes.len() as u32,
                references: first_reference..references.len() as u32,
            });
        }
        let levels = Levels { tlas_nodes, tlas_references, blases: places, meshes };
        let triangles =
            levels.scene_triangles().ok_or("more triangles in all instances than ids can name")?;
        Ok(Self { nodes, references, seconds, triangles, levels: Some(levels) })
    }

    /// Nodes of all trees.
    pub fn node_count(&self) -> u64 {
        let of_levels = |levels: &Levels| {
            u64::from(levels.tlas_nodes)
                + levels.blases.iter().map(|blas| blas.nodes.len() as u64).sum::<u64>()
        };
        self.levels.as_ref().map_or(self.nodes.len() as u64, of_levels)
    }

    /// Triangles that the structure holds: with two levels, those of each mesh once.
    pub fn stored_triangles(&self) -> u32 {
        self.levels.as_ref().map_or(self.triangles, |_| self.references.len() as u32)
    }

    /// The trees that the structure consists of, each with the number of its root and in numbers of its own: itself, or the TLAS
    /// and the BLASes.
    pub fn trees(&self) -> Vec<(u32, Self)> {
        let Some(levels) = &self.levels else { return vec![(0, self.clone())] };
        let tlas = Self {
            nodes: self.nodes[..levels.tlas_nodes as usize].to_vec(),
            references: levels.tlas_references.clone(),
            triangles: levels.meshes.len() as u32,
            ..Self::default()
        };
        let blas = |BlasPlace { nodes, references }: &BlasPlace| {
            let back = [nodes.start, references.start].map(u32::wrapping_neg);
            let before = |reference: u32| self.seconds.partition_point(|&second| second < reference);
            let first_second = before(references.start);
            let seconds = first_second..before(references.end).max(first_second);
            let tree = Self {
                nodes: self.nodes[nodes.start as usize..nodes.end as usize]
                    .iter()
                    .map(|node| node.moved(back[0], back[1]))
                    .collect(),
                references: self.references[references.start as usize..references.end as usize]
                    .iter()
                    .map(|reference| reference.wrapping_add(back[1]))
                    .collect(),
                seconds: self.seconds[seconds].iter().map(|second| second.wrapping_add(back[1])).collect(),
                triangles: references.len() as u32,
                levels: None,
            };
            (nodes.start, tree)
        };
        std::iter::once((0, tlas)).chain(levels.blases.iter().map(blas)).collect()
    }

    /// [`Self::validate`] for two levels: each tree by itself, so that no link leads from one into another.
    pub(crate) fn validate_levels(&self, levels: &Levels) -> Result<(), String> {
        let mut end = (levels.tlas_nodes, 0);
        for BlasPlace { nodes, references } in &levels.blases {
            let begins = Some(nodes.start) == end.0.checked_next_multiple_of(2) && references.start == end.1;
            if !begins || nodes.is_empty() || references.end < references.start {
                return Err(format!("a BLAS of nodes {nodes:?} and references {references:?} after {end:?}"));
            }
            end = (nodes.end, references.end);
        }
        if (end.0 as usize, end.1 as usize) != (self.nodes.len(), self.references.len()) {
            return Err(format!("trees of {end:?} nodes and references in all do not fill the lists"));
        }
        if let Some(instance) = (0..levels.meshes.len() as u32).find(|&i| levels.blas_of(i).is_none()) {
            return Err(format!("instance {instance} has no BLAS of the {}", levels.blases.len()));
        }
        if levels.scene_triangles() != Some(self.triangles) {
            return Err(format!("the instances do not have the {} triangles of the scene", self.triangles));
        }
        let trees = self.trees();
        for (root, tree) in &trees {
            tree.validate().map_err(|problem| format!("in the tree of node {root}: {problem}"))?;
        }
        // A binary TLAS may stand over wide BLASes, as in traces that were recorded before a TLAS could be wide.
        let (tlas, blases) = trees.split_first().expect("a TLAS is always there");
        match blases.iter().find(|(_, blas)| tlas.1.is_wide() && !blas.is_wide()) {
            Some((root, _)) => {
                Err(format!("the nodes of the TLAS are wide, and that of the root {root} is binary"))
            }
            None => Ok(()),
        }
    }
}

impl<P: RayTriangle, T: BottomLevel<P>> TwoLevel<P, T> {
    /// Links, references and instances without geometry.
    pub fn topology(&self) -> Topology {
        let blases = self.blases.iter().map(|blas| blas.tree.topology()).collect();
        let meshes = self.instances.iter().map(|placed| placed.mesh).collect();
        Topology::of_two_levels(self.tlas.topology(), blases, meshes)
            .expect("sizes were checked when it was built")
    }
}
