//! The kd-tree as data.

use crate::aabb::{Aabb, PlaneSlack};
use crate::leaf::References;
use crate::triangle::{PreparedTriangle, RayTriangle};

/// One node in 8 bytes: `bits` is the split position (f32) or the first reference; `meta` holds the axis (0, 1, 2; 3 for a
/// leaf) in its two low bits, and above them the left child's index or the leaf's reference count.
///
/// Siblings are neighbours: the right child is the left one plus 1. Node 0 is the root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct KdNode {
    bits: u32,
    meta: u32,
}

const _: () = assert!(size_of::<KdNode>() == 8);

/// A node, unpacked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KdNodeKind {
    /// Splits its cell at `split` on `axis`; children `left` (below) and `left + 1` (above).
    Inner {
        /// 0 = x, 1 = y, 2 = z.
        axis: usize,
        /// Plane position.
        split: f32,
        /// Index of the lower child.
        left: u32,
    },
    /// Holds `count` references from `first`; may be empty.
    Leaf {
        /// First position in the reference list.
        first: u32,
        /// Number of references.
        count: u32,
    },
}

impl KdNode {
    /// Largest child index or count that fits in a node.
    pub const MAX_PAYLOAD: u32 = u32::MAX >> 2;

    /// An inner node.
    pub fn inner(axis: usize, split: f32, left: u32) -> Self {
        debug_assert!(axis < 3 && left <= Self::MAX_PAYLOAD);
        Self { bits: split.to_bits(), meta: left << 2 | axis as u32 }
    }

    /// A leaf.
    pub fn leaf(first: u32, count: u32) -> Self {
        debug_assert!(count <= Self::MAX_PAYLOAD);
        Self { bits: first, meta: count << 2 | 3 }
    }

    /// What the node is.
    #[inline(always)]
    pub fn kind(self) -> KdNodeKind {
        let payload = self.meta >> 2;
        match self.meta & 3 {
            3 => KdNodeKind::Leaf { first: self.bits, count: payload },
            axis => {
                KdNodeKind::Inner { axis: axis as usize, split: f32::from_bits(self.bits), left: payload }
            }
        }
    }

    /// The same node in a tree where children lie `nodes` and references `references` further back.
    pub(super) fn moved(self, nodes: u32, references: u32) -> Self {
        match self.kind() {
            KdNodeKind::Inner { axis, split, left } => Self::inner(axis, split, left + nodes),
            KdNodeKind::Leaf { first, count } => Self::leaf(first + references, count),
        }
    }
}

/// A kd-tree over triangles, prepared for a test as `P`: the cells partition `bounds`; a triangle is referenced by every leaf that its box (or, with perfect
/// splits, the triangle itself) overlaps. A triangle in a split plane belongs to the leaves on one side of it.
///
/// [`KdTree::build`] is the only constructor, so that traversals can rely on what [`KdTree::validate`] checks.
#[derive(Clone, Debug)]
pub struct KdTree<P: RayTriangle = PreparedTriangle> {
    pub(crate) nodes: Vec<KdNode>,
    pub(crate) references: Vec<u32>,
    pub(crate) bounds: Aabb,
    pub(crate) slack: PlaneSlack,
    pub(crate) depth: u32,
    /// Triangles in file order, prepared for the test.
    pub(crate) triangles: Vec<P>,
}

impl<P: RayTriangle> KdTree<P> {
    /// Nodes; siblings adjacent, root first, children behind their parent.
    pub fn nodes(&self) -> &[KdNode] {
        &self.nodes
    }

    /// Triangle indices (file order) of all leaves, one leaf after the other.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Box of the whole scene; [`Aabb::EMPTY`] without triangles.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Longest path from the root, in edges.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Number of triangles, referenced or not.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// What its leaves refer to.
    #[inline(always)]
    pub(super) fn leaves(&self) -> References<'_, P> {
        References { list: &self.references, triangles: &self.triangles }
    }
}
