//! The shape of a structure without its geometry: what a replay needs to lay nodes and primitives out in memory.

use crate::bvh::{Bvh, BvhNodeKind};
use crate::grid::Grid;
use crate::kd::{KdNodeKind, KdTree};
use crate::triangle::RayTriangle;
use crate::two_level::Levels;
use crate::wide::WideBvh;
use std::ops::Range;

/// A node's links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopologyNode {
    /// Children `left` and `left + 1`.
    Inner {
        /// Index of the left child.
        left: u32,
    },
    /// A node of a wide BVH: its inner children are `first .. first + count`; its leaves have no node.
    Wide {
        /// Index of the first inner child.
        first: u32,
        /// Number of inner children.
        count: u32,
        /// Number of children that are leaves.
        leaves: u32,
    },
    /// References `first .. first + count`.
    Leaf {
        /// First position in the reference list.
        first: u32,
        /// Number of references.
        count: u32,
    },
}

impl TopologyNode {
    /// Its children that are nodes.
    pub fn children(self) -> Range<u32> {
        match self {
            Self::Inner { left } => left..left + 2,
            Self::Wide { first, count, .. } => first..first + count,
            Self::Leaf { .. } => 0..0,
        }
    }

    /// The same node where nodes and references have numbers that are larger by these; modulo 2^32, so that it can be undone.
    pub(crate) fn moved(self, nodes: u32, references: u32) -> Self {
        match self {
            Self::Inner { left } => Self::Inner { left: left.wrapping_add(nodes) },
            Self::Wide { first, count, leaves } => {
                Self::Wide { first: first.wrapping_add(nodes), count, leaves }
            }
            Self::Leaf { first, count } => Self::Leaf { first: first.wrapping_add(references), count },
        }
    }
}

/// The links of all nodes, and the reference list of the leaves.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Root first, where there is one.
    pub nodes: Vec<TopologyNode>,
    /// Triangle index (file order) at each position that a primitive step can name; of two levels, among the triangles of all meshes.
    pub references: Vec<u32>,
    /// Positions in it whose triangle shares its record with that of the position before, rising: the second ones of pairs.
    pub seconds: Vec<u32>,
    /// Number of triangles of the scene; of two levels, those of all instances.
    pub triangles: u32,
    /// What belongs to which tree, where there are two levels.
    pub levels: Option<Levels>,
}

impl Topology {
    /// The shape of a BVH.
    pub fn of_bvh<P: RayTriangle>(bvh: &Bvh<P>) -> Self {
        let node = |node: crate::bvh::BvhNode| match node.kind {
            BvhNodeKind::Inner { left, .. } => TopologyNode::Inner { left },
            BvhNodeKind::Leaf { first, count } => TopologyNode::Leaf { first, count },
        };
        Self {
            nodes: bvh.nodes().map(node).collect(),
            references: bvh.references().to_vec(),
            triangles: bvh.references().len() as u32,
            ..Self::default()
        }
    }

    /// The shape of a wide BVH: its nodes, whose leaves are known from the references that steps name.
    pub fn of_wide<P: RayTriangle, const W: usize>(bvh: &WideBvh<P, W>) -> Self {
        Self {
            nodes: bvh.links().collect(),
            references: bvh.references().to_vec(),
            seconds: bvh.seconds().to_vec(),
            triangles: bvh.references().len() as u32,
            levels: None,
        }
    }

    /// The shape of a kd-tree.
    pub fn of_kd<P: RayTriangle>(tree: &KdTree<P>) -> Self {
        let node = |node: &crate::kd::KdNode| match node.kind() {
            KdNodeKind::Inner { left, .. } => TopologyNode::Inner { left },
            KdNodeKind::Leaf { first, count } => TopologyNode::Leaf { first, count },
        };
        Self {
            nodes: tree.nodes.iter().map(node).collect(),
            references: tree.references.clone(),
            triangles: tree.triangles.len() as u32,
            ..Self::default()
        }
    }

    /// The cells of a grid: leaves without a parent, numbered with x fastest and z slowest. A ray can begin at any of them.
    pub fn of_grid<P: RayTriangle>(grid: &Grid<P>) -> Self {
        let leaf = |cell| {
            let references = grid.cell(cell);
            TopologyNode::Leaf { first: references.start, count: references.len() as u32 }
        };
        Self {
            nodes: (0..grid.cell_count()).map(leaf).collect(),
            references: grid.references().to_vec(),
            triangles: grid.triangle_count() as u32,
            ..Self::default()
        }
    }

    /// Whether it is the shape of a wide BVH.
    pub fn is_wide(&self) -> bool {
        matches!(self.nodes.first(), Some(TopologyNode::Wide { .. }))
    }

    /// Checks that links stay inside their tree and lead downwards only, that references name triangles or instances, and that each
    /// instance has a BLAS.
    ///
    /// # Errors
    /// A sentence that names the first offender.
    pub fn validate(&self) -> Result<(), String> {
        // Each has a first one before it, which is not second to another.
        let mut free = 0;
        for &second in &self.seconds {
            if second as usize >= self.references.len() || second <= free {
                return Err(format!(
                    "position {second} of {} cannot be second to the one before",
                    self.references.len()
                ));
            }
            free = second + 1;
        }
        if let Some(levels) = &self.levels {
            return self.validate_levels(levels);
        }
        let nodes = self.nodes.len() as u64;
        let references = self.references.len() as u64;
        for (index, node) in (0_u64..).zip(&self.nodes) {
            match *node {
                TopologyNode::Inner { left } if u64::from(left) <= index || u64::from(left) + 1 >= nodes => {
                    return Err(format!(
                        "inner node {index} links to {left}; children lie after their parent, below {nodes}"
                    ));
                }
                TopologyNode::Wide { first, count, .. }
                    if count > 0
                        && (u64::from(first) <= index || u64::from(first) + u64::from(count) > nodes) =>
                {
                    return Err(format!(
                        "wide node {index} links to {count} nodes from {first}; children lie after their parent, below {nodes}"
                    ));
                }
                TopologyNode::Leaf { first, count } if u64::from(first) + u64::from(count) > references => {
                    return Err(format!("leaf {index} names references {first}+{count} of {references}"));
                }
                _ => {}
            }
        }
        match self.references.iter().find(|&&reference| reference >= self.triangles) {
            Some(reference) => Err(format!("reference to triangle {reference} of {}", self.triangles)),
            None if self.nodes.is_empty() => Err("no root node".to_owned()),
            None => Ok(()),
        }
    }
}
