//! What a kd-tree is made of and what it is expected to cost.

use super::events::Cell;
use super::tree::{KdNodeKind, KdTree};
use crate::aabb::Aabb;
use crate::triangle::RayTriangle;

/// Counts over a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KdStatistics {
    /// Inner nodes and leaves.
    pub nodes: u64,
    /// Leaves, empty ones among them.
    pub leaves: u64,
    /// Leaves without references.
    pub empty_leaves: u64,
    /// Leaves without thickness on at least one axis on which the scene has thickness.
    pub flat_leaves: u64,
    /// References of all leaves together.
    pub references: u64,
    /// References of the fullest leaf.
    pub largest_leaf: u64,
    /// Longest path from the root, in edges.
    pub depth: u32,
}

impl<P: RayTriangle> KdTree<P> {
    /// Visits all nodes with their cells, parents first.
    pub(super) fn for_each_cell(&self, mut visit: impl FnMut(u32, KdNodeKind, &Cell)) {
        if self.triangles.is_empty() {
            return;
        }
        let root = Cell { min: self.bounds.min, max: self.bounds.max };
        let mut open = vec![(0_u32, root)];
        while let Some((index, cell)) = open.pop() {
            let kind = self.nodes[index as usize].kind();
            visit(index, kind, &cell);
            if let KdNodeKind::Inner { axis, split, left } = kind {
                let (left_cell, right_cell) = cell.split(axis, split);
                open.extend([(left + 1, right_cell), (left, left_cell)]);
            }
        }
    }

    /// Half the area of each node's cell; nothing without triangles.
    pub(crate) fn half_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        self.for_each_cell(|index, _, cell| {
            areas[index as usize] = Aabb { min: cell.min, max: cell.max }.half_area();
        });
        areas
    }

    /// Expected cost of a random ray that meets the scene's box: the areas of inner nodes times Ct and those of leaves times
    /// Ci and their references, over the area of the root. `None` for a box without area.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        let root_area = self.bounds.half_area();
        let mut sum = 0.0;
        self.for_each_cell(|_, kind, cell| {
            let cost = match kind {
                KdNodeKind::Inner { .. } => traversal_cost,
                KdNodeKind::Leaf { count, .. } => intersection_cost * f64::from(count),
            };
            sum += cost * Aabb { min: cell.min, max: cell.max }.half_area();
        });
        (root_area > 0.0).then_some(sum / root_area)
    }

    /// Counts nodes, leaves and references.
    pub fn statistics(&self) -> KdStatistics {
        let mut counts =
            KdStatistics { nodes: self.nodes.len() as u64, depth: self.depth, ..KdStatistics::default() };
        let extent = self.bounds.extent();
        self.for_each_cell(|_, kind, cell| {
            if let KdNodeKind::Leaf { count, .. } = kind {
                counts.leaves += 1;
                counts.empty_leaves += u64::from(count == 0);
                counts.references += u64::from(count);
                counts.largest_leaf = counts.largest_leaf.max(u64::from(count));
                let is_flat = (0..3).any(|axis| extent[axis] > 0.0 && cell.min[axis] >= cell.max[axis]);
                counts.flat_leaves += u64::from(is_flat);
            }
        });
        if self.triangles.is_empty() {
            (counts.leaves, counts.empty_leaves) = (1, 1);
        }
        counts
    }
}
