//! The shape of a two-level structure without its geometry.

use super::structure::TwoLevel;
use crate::topology::{Topology, TopologyNode};
use crate::triangle::RayTriangle;

/// The shapes of the trees, each in numbers of its own, and where these begin in the numbers of the steps.
///
/// This is what a replay needs to lay the structure out. Still missing: the replay itself refuses
/// [`Op::Instance`](crate::Op::Instance), and a trace file holds the shape of one tree and no instance; both have to take this in its
/// place, and to read the record of an instance, of a size that is the layout's business, at such a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TwoLevelTopology {
    /// The upper tree. Its references are numbers of instances, its `triangles` the number of instances.
    pub tlas: Topology,
    /// The tree of each mesh.
    pub blases: Vec<BlasTopology>,
    /// Per instance, the mesh.
    pub meshes: Vec<u32>,
}

/// The tree of a mesh, and its place in the numbers of the steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlasTopology {
    /// Its shape, in the mesh's own numbers.
    pub tree: Topology,
    /// Id of its root in steps; node `n` is `first_node + n`.
    pub first_node: u32,
    /// Position of its first reference in steps.
    pub first_reference: u32,
}

impl<P: RayTriangle> TwoLevel<P> {
    /// Links, references and instances without geometry.
    pub fn topology(&self) -> TwoLevelTopology {
        let tree = self.tlas.pair_tree();
        let node = |index| {
            let (_, links) = tree.node(index);
            if links.is_inner() {
                TopologyNode::Inner { left: links.link }
            } else {
                TopologyNode::Leaf { first: links.link, count: links.count() }
            }
        };
        TwoLevelTopology {
            tlas: Topology {
                nodes: (0..self.tlas.node_count()).map(node).collect(),
                references: self.tlas.references.clone(),
                triangles: self.instances.len() as u32,
            },
            blases: self
                .blases
                .iter()
                .map(|blas| BlasTopology {
                    tree: Topology::of_bvh(&blas.tree),
                    first_node: blas.first_node,
                    first_reference: blas.first_reference,
                })
                .collect(),
            meshes: self.instances.iter().map(|placed| placed.mesh).collect(),
        }
    }
}
