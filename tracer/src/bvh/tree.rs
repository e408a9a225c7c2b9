//! The BVH as data.

use super::leaf::Leaves;
use super::pair_tree::PairTree;
use crate::aabb::{Aabb, PlaneSlack};
use crate::triangle::{GROUP, PreparedTriangle, RayTriangle, TriangleGroup};
use glam::Vec3;

/// One node, unpacked: its box and its links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhNode {
    /// The box around everything below.
    pub bounds: Aabb,
    /// Children or primitives.
    pub kind: BvhNodeKind,
}

/// What a node leads to. By definition inner nodes hold no primitives; only leaves do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhNodeKind {
    /// Children `left` and `left + 1`, separated on `axis`: the left child's centroids lie lower.
    Inner {
        /// 0 = x, 1 = y, 2 = z.
        axis: usize,
        /// Index of the left child.
        left: u32,
    },
    /// Holds `count` references from `first`.
    Leaf {
        /// First position in the reference list.
        first: u32,
        /// Number of references; 0 only in the root of an empty tree.
        count: u32,
    },
}

/// A node's links, packed: what a traversal must remember to come back to the node without fetching it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct NodeRef {
    /// Left child of an inner node, first triangle group of a leaf.
    pub(crate) link: u32,
    /// Of an inner node [`NodeRef::INNER`] and the axis in the two low bits; of a leaf its count.
    meta: u32,
}

impl NodeRef {
    const INNER: u32 = 1 << 31;

    pub(crate) fn inner(axis: usize, left: u32) -> Self {
        debug_assert!(axis < 3);
        Self { link: left, meta: Self::INNER | axis as u32 }
    }

    /// A leaf without triangles.
    pub(crate) const NOTHING: Self = Self { link: 0, meta: 0 };

    pub(crate) fn leaf(group: u32, count: u32) -> Self {
        debug_assert!(count < Self::INNER);
        Self { link: group, meta: count }
    }

    #[inline(always)]
    pub(crate) fn is_inner(self) -> bool {
        self.meta & Self::INNER != 0
    }

    /// Reference count of a leaf.
    #[inline(always)]
    pub(crate) fn count(self) -> u32 {
        debug_assert!(!self.is_inner());
        self.meta
    }

    /// Split axis of an inner node.
    #[inline(always)]
    pub(crate) fn axis(self) -> usize {
        (self.meta & 3) as usize
    }
}

/// Two siblings in one 64-byte cache line: their boxes axis by axis, so that one four-lane operation serves both nodes and
/// both planes of an axis, and their links.
///
/// This is how the tracer stores nodes on the machine it runs on. The records of the modelled GPU are the replay's business.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct NodePair {
    /// Per axis: left min, right min, left max, right max.
    pub(crate) planes: [f32; 12],
    /// Left, right.
    pub(crate) links: [NodeRef; 2],
}

const _: () = assert!(size_of::<NodePair>() == 64);

impl NodePair {
    pub(super) fn new(boxes: [&Aabb; 2], links: [NodeRef; 2]) -> Self {
        let mut planes = [0.0; 12];
        for axis in 0..3 {
            for (side, bounds) in boxes.into_iter().enumerate() {
                planes[4 * axis + side] = bounds.min[axis];
                planes[4 * axis + 2 + side] = bounds.max[axis];
            }
        }
        Self { planes, links }
    }

    /// Pairs of all nodes but the root; `links` are those of `nodes`.
    pub(crate) fn pack(nodes: &[BvhNode], links: &[NodeRef]) -> Vec<Self> {
        let lefts = (1..nodes.len()).step_by(2);
        let pair = |left: usize| {
            Self::new([&nodes[left].bounds, &nodes[left + 1].bounds], [links[left], links[left + 1]])
        };
        lefts.map(pair).collect()
    }

    /// The left node (`side` 0) or the right one (1).
    #[inline(always)]
    pub(super) fn side(&self, side: usize) -> (Aabb, NodeRef) {
        let corner = |at: usize| Vec3::new(self.planes[at], self.planes[at + 4], self.planes[at + 8]);
        (Aabb { min: corner(side), max: corner(side + 2) }, self.links[side])
    }
}

/// A binary BVH over triangles, prepared for a test as `P`; every triangle is in exactly one leaf.
///
/// Node 0 is the root; siblings are neighbours, the left one at an odd index. A pair lies before the pairs below it.
#[derive(Clone, Debug)]
pub struct Bvh<P: RayTriangle = PreparedTriangle> {
    pub(crate) root_bounds: Aabb,
    pub(crate) slack: PlaneSlack,
    pub(crate) root: NodeRef,
    /// Nodes 1 and 2, 3 and 4, ...
    pub(crate) pairs: Vec<NodePair>,
    pub(crate) references: Vec<u32>,
    /// The triangles of each leaf in reference order; a leaf begins a new group.
    pub(crate) groups: Vec<P::Group>,
    pub(crate) depth: u32,
}

/// Facts about a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhStatistics {
    /// All nodes.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// References in the largest leaf.
    pub largest_leaf: u32,
    /// Longest path from the root, in edges.
    pub depth: u32,
}

impl<P: RayTriangle> Bvh<P> {
    /// Stores nodes, root first, siblings adjacent; `triangles` in reference order.
    pub(super) fn from_nodes(
        nodes: &[BvhNode],
        references: Vec<u32>,
        triangles: &[P],
        depth: u32,
        slack: PlaneSlack,
    ) -> Self {
        let mut groups = Vec::with_capacity(nodes.len() / 2 + 1 + triangles.len() / GROUP);
        let links: Vec<NodeRef> = nodes
            .iter()
            .map(|node| match node.kind {
                BvhNodeKind::Inner { axis, left } => NodeRef::inner(axis, left),
                BvhNodeKind::Leaf { first, count } => {
                    let group = groups.len() as u32;
                    let positions = (first..first + count).step_by(GROUP);
                    let chunks = triangles[first as usize..][..count as usize].chunks(GROUP);
                    groups.extend(positions.zip(chunks).map(|(first, chunk)| P::Group::new(first, chunk)));
                    NodeRef::leaf(group, count)
                }
            })
            .collect();
        Self {
            root_bounds: nodes[0].bounds,
            slack,
            root: links[0],
            pairs: NodePair::pack(nodes, &links),
            references,
            groups,
            depth,
        }
    }

    /// Number of nodes; odd.
    pub fn node_count(&self) -> u32 {
        2 * self.pairs.len() as u32 + 1
    }

    /// Node `index`.
    ///
    /// # Panics
    /// When there is no such node.
    pub fn node(&self, index: u32) -> BvhNode {
        let (bounds, links) = self.packed_node(index);
        let kind = if links.is_inner() {
            BvhNodeKind::Inner { axis: links.axis(), left: links.link }
        } else {
            // Only the empty root has no group.
            let first = self.groups.get(links.link as usize).map_or(0, |group| group.first());
            BvhNodeKind::Leaf { first, count: links.count() }
        };
        BvhNode { bounds, kind }
    }

    /// All nodes, root first.
    pub fn nodes(&self) -> impl Iterator<Item = BvhNode> {
        (0..self.node_count()).map(|index| self.node(index))
    }

    /// Its nodes, without what the leaves hold.
    #[inline(always)]
    pub(crate) fn pair_tree(&self) -> PairTree<'_> {
        PairTree { root_bounds: &self.root_bounds, root: self.root, pairs: &self.pairs }
    }

    /// Box and packed links of node `index`.
    #[inline(always)]
    pub(crate) fn packed_node(&self, index: u32) -> (Aabb, NodeRef) {
        self.pair_tree().node(index)
    }

    /// What leaves refer to; the tree's first triangle has index `base` in hits.
    #[inline(always)]
    pub(super) fn leaves(&self, base: u32) -> Leaves<'_, P> {
        Leaves { references: &self.references, groups: &self.groups, base }
    }

    /// The pair of nodes `left` and `left + 1`.
    #[inline(always)]
    pub(super) fn pair(&self, left: u32) -> &NodePair {
        self.pair_tree().pair(left)
    }

    /// Triangle indices (file order) of all leaves: a permutation.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// How thick the traversals take the planes of the boxes.
    pub fn plane_slack(&self) -> &PlaneSlack {
        &self.slack
    }

    /// Longest path from the root, in edges.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Expected cost of a random ray that meets the root (surface area heuristic, Goldsmith & Salmon 1987):
    /// `(Ct * sum of inner areas + Ci * sum of count * leaf area) / root area`. `None` when the root has no area.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        let root = self.root_bounds.half_area();
        let total: f64 = self
            .nodes()
            .map(|node| {
                let area = node.bounds.half_area();
                match node.kind {
                    BvhNodeKind::Inner { .. } => traversal_cost * area,
                    BvhNodeKind::Leaf { count, .. } => intersection_cost * f64::from(count) * area,
                }
            })
            .sum();
        (root > 0.0).then(|| total / root)
    }

    /// Counts over all nodes.
    pub fn statistics(&self) -> BvhStatistics {
        let counts = || {
            self.nodes().filter_map(|node| match node.kind {
                BvhNodeKind::Leaf { count, .. } => Some(count),
                BvhNodeKind::Inner { .. } => None,
            })
        };
        BvhStatistics {
            nodes: u64::from(self.node_count()),
            leaves: counts().count() as u64,
            largest_leaf: counts().max().unwrap_or(0),
            depth: self.depth,
        }
    }

    /// Checks what every traversal relies on: children exist and lie after their parent, child boxes lie in the parent's,
    /// leaves partition the references, references are a permutation, triangles lie in their leaf's box.
    ///
    /// # Errors
    /// A sentence that names the first node that breaks a rule.
    pub fn validate(&self, triangles: &[scenes::Triangle]) -> Result<(), String> {
        let mut seen = vec![false; triangles.len()];
        let mut reached = 0;
        let mut pending = vec![(0_u32, self.root_bounds, 0_u32)];
        while let Some((index, outer, depth)) = pending.pop() {
            if index >= self.node_count() {
                return Err(format!("node {index} does not exist"));
            }
            let BvhNode { bounds, kind } = self.node(index);
            reached += 1;
            if self.references.is_empty() {
                break;
            }
            if bounds.union(outer) != outer {
                return Err(format!("the box of node {index} sticks out of its parent's"));
            }
            if depth > self.depth {
                return Err(format!("node {index} is deeper than the stated depth {}", self.depth));
            }
            match kind {
                BvhNodeKind::Inner { left, .. } if left <= index => {
                    return Err(format!("node {index} links back to {left}"));
                }
                BvhNodeKind::Inner { left, .. } if left % 2 == 0 => {
                    return Err(format!("node {index} links to {left}, which is not the left one of a pair"));
                }
                BvhNodeKind::Inner { left, .. } => {
                    pending.extend([(left + 1, bounds, depth + 1), (left, bounds, depth + 1)]);
                }
                BvhNodeKind::Leaf { first, count } => {
                    let range = first as usize..first as usize + count as usize;
                    let references = self
                        .references
                        .get(range)
                        .ok_or_else(|| format!("leaf {index} reaches past the references"))?;
                    for &reference in references {
                        let triangle = triangles
                            .get(reference as usize)
                            .ok_or_else(|| format!("leaf {index} names triangle {reference}"))?;
                        if std::mem::replace(&mut seen[reference as usize], true) {
                            return Err(format!("triangle {reference} is in two leaves"));
                        }
                        if bounds.union(Aabb::of_triangle(triangle)) != bounds {
                            return Err(format!("triangle {reference} sticks out of leaf {index}"));
                        }
                    }
                }
            }
        }
        if let Some(missing) = seen.iter().position(|&seen| !seen) {
            return Err(format!("triangle {missing} is in no leaf"));
        }
        if reached != self.node_count() {
            return Err(format!("{} nodes, but {reached} are reached", self.node_count()));
        }
        Ok(())
    }
}
