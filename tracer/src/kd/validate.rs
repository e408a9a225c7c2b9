//! What every kd-tree must satisfy.

use super::options::KdOptions;
use super::statistics::KdStatistics;
use super::tree::{KdNodeKind, KdTree};
use crate::triangle::RayTriangle;

/// The first thing found wrong with a tree. Such a tree cannot come from [`KdTree::build`]: it is a defect of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum KdDefect {
    /// A child index that is not behind its parent and inside the tree.
    #[error("node {node}: left child {left} of {nodes} nodes; expected a pair behind the node")]
    Link {
        /// The parent.
        node: u32,
        /// Its left child.
        left: u32,
        /// Nodes of the tree.
        nodes: usize,
    },
    /// A node that is the child of none or of several.
    #[error("node {node} is the child of {parents} nodes; expected one, and none for the root")]
    Parents {
        /// The node.
        node: u32,
        /// How many nodes link to it.
        parents: u32,
    },
    /// A path longer than the tree's depth, or none as long.
    #[error(
        "the longest path has {found} edges; the tree says {stated}, and at most {} are allowed",
        KdOptions::MAX_DEPTH
    )]
    Depth {
        /// Edges of the longest path.
        found: u32,
        /// [`KdTree::depth`].
        stated: u32,
    },
    /// A split plane outside its cell, or none.
    #[error("node {node} splits axis {axis} at {split}, outside its cell {low}..={high}")]
    Plane {
        /// The node.
        node: u32,
        /// Its axis.
        axis: usize,
        /// Its plane.
        split: f32,
        /// Where its cell begins.
        low: f32,
        /// Where its cell ends.
        high: f32,
    },
    /// Leaves that do not divide the reference list among themselves in order.
    #[error(
        "leaf {node} begins at reference {first}; the leaves before it end at {expected} of {references}"
    )]
    References {
        /// The leaf.
        node: u32,
        /// Its first reference.
        first: u32,
        /// Where it should begin.
        expected: u64,
        /// Length of the reference list.
        references: usize,
    },
    /// References of a leaf that do not rise, or that name no triangle.
    #[error("leaf {node}: triangle {triangle} after {previous:?} of {triangles}; expected rising indices")]
    Order {
        /// The leaf.
        node: u32,
        /// The offending reference.
        triangle: u32,
        /// The reference before it.
        previous: Option<u32>,
        /// Triangles of the tree.
        triangles: usize,
    },
}

impl<P: RayTriangle> KdTree<P> {
    /// Checks the tree and returns what it is made of. Takes time linear in its size.
    ///
    /// # Errors
    /// The first defect.
    pub fn validate(&self) -> Result<KdStatistics, KdDefect> {
        self.check_links()?;
        self.check_planes()?;
        self.check_references()?;
        Ok(self.statistics())
    }

    fn check_links(&self) -> Result<(), KdDefect> {
        let mut parents = vec![0_u32; self.nodes.len()];
        let mut depths = vec![0_u32; self.nodes.len()];
        for (node, record) in (0_u32..).zip(&self.nodes) {
            if let KdNodeKind::Inner { left, .. } = record.kind() {
                if left <= node || left as usize + 1 >= self.nodes.len() {
                    return Err(KdDefect::Link { node, left, nodes: self.nodes.len() });
                }
                for child in [left as usize, left as usize + 1] {
                    parents[child] += 1;
                    depths[child] = depths[node as usize] + 1;
                }
            }
        }
        let expected = |node: u32| u32::from(node != 0);
        if let Some((node, &parents)) =
            (0..).zip(&parents).find(|&(node, &parents)| parents != expected(node))
        {
            return Err(KdDefect::Parents { node, parents });
        }
        let found = depths.into_iter().max().unwrap_or(0);
        if found != self.depth || found > KdOptions::MAX_DEPTH {
            return Err(KdDefect::Depth { found, stated: self.depth });
        }
        Ok(())
    }

    fn check_planes(&self) -> Result<(), KdDefect> {
        let mut defect = None;
        self.for_each_cell(|node, kind, cell| {
            if let KdNodeKind::Inner { axis, split, .. } = kind {
                let (low, high) = (cell.min[axis], cell.max[axis]);
                if !(low <= split && split <= high && low < high) {
                    defect.get_or_insert(KdDefect::Plane { node, axis, split, low, high });
                }
            }
        });
        defect.map_or(Ok(()), Err)
    }

    fn check_references(&self) -> Result<(), KdDefect> {
        let mut leaves = Vec::new();
        self.for_each_cell(|node, kind, _| {
            if let KdNodeKind::Leaf { first, count } = kind {
                leaves.push((node, first, count));
            }
        });
        let (triangles, references) = (self.triangles.len(), self.references.len());
        let mut expected = 0;
        for (node, first, count) in leaves {
            let end = u64::from(first) + u64::from(count);
            if u64::from(first) != expected || end > references as u64 {
                return Err(KdDefect::References { node, first, expected, references });
            }
            expected = end;
            let mut previous = None;
            for &triangle in &self.references[first as usize..end as usize] {
                if triangle as usize >= triangles || previous.is_some_and(|previous| previous >= triangle) {
                    return Err(KdDefect::Order { node, triangle, previous, triangles });
                }
                previous = Some(triangle);
            }
        }
        if expected == references as u64 {
            Ok(())
        } else {
            Err(KdDefect::References { node: 0, first: 0, expected, references })
        }
    }
}
