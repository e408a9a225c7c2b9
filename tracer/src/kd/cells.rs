//! Boxes and parents of all nodes, for backtracking.

use super::tree::{KdNodeKind, KdTree};
use crate::aabb::Aabb;
use crate::triangle::RayTriangle;

/// What a backtracking node holds beyond a kd node: its cell and its parent.
#[derive(Clone, Debug)]
pub struct KdCells {
    bounds: Vec<Aabb>,
    parents: Vec<u32>,
}

impl KdCells {
    /// The parent of the root.
    pub const NO_PARENT: u32 = u32::MAX;

    /// Computes both for all nodes of a tree.
    pub fn new<P: RayTriangle>(tree: &KdTree<P>) -> Self {
        let mut cells = Self {
            bounds: vec![tree.bounds; tree.nodes.len()],
            parents: vec![Self::NO_PARENT; tree.nodes.len()],
        };
        tree.for_each_cell(|node, kind, cell| {
            cells.bounds[node as usize] = Aabb { min: cell.min, max: cell.max };
            if let KdNodeKind::Inner { left, .. } = kind {
                cells.parents[left as usize] = node;
                cells.parents[left as usize + 1] = node;
            }
        });
        cells
    }

    /// The cell of each node.
    pub fn bounds(&self) -> &[Aabb] {
        &self.bounds
    }

    /// The parent of each node; [`KdCells::NO_PARENT`] for the root.
    pub fn parents(&self) -> &[u32] {
        &self.parents
    }
}
