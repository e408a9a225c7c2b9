//! The BVH as data.

use crate::aabb::Aabb;
use crate::triangle::PreparedTriangle;
use glam::Vec3;

/// One node in 32 bytes: min xyz, link, max xyz, meta.
///
/// Siblings are neighbours, the right one after the left one; node 0 is the root, so that pairs begin at odd indices. By
/// definition inner nodes hold no primitives; only leaves do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct BvhNode {
    min: Vec3,
    link: u32,
    max: Vec3,
    meta: u32,
}

const _: () = assert!(size_of::<BvhNode>() == 32);

/// Set in `meta` of an inner node, whose two low bits hold the axis; otherwise `meta` is a leaf's count.
const INNER: u32 = 1 << 31;

/// A node, unpacked.
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

/// A node's link and meta words: what a traversal must remember to come back to the node without fetching it again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeRef {
    pub(crate) link: u32,
    meta: u32,
}

impl NodeRef {
    #[inline(always)]
    pub(crate) fn is_inner(self) -> bool {
        self.meta & INNER != 0
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

impl BvhNode {
    pub(crate) fn inner(bounds: Aabb, axis: usize, left: u32) -> Self {
        debug_assert!(axis < 3);
        Self { min: bounds.min, link: left, max: bounds.max, meta: INNER | axis as u32 }
    }

    pub(crate) fn leaf(bounds: Aabb, first: u32, count: u32) -> Self {
        debug_assert!(count < INNER);
        Self { min: bounds.min, link: first, max: bounds.max, meta: count }
    }

    /// The node's box.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }

    #[inline(always)]
    pub(crate) fn reference(&self) -> NodeRef {
        NodeRef { link: self.link, meta: self.meta }
    }

    /// What the node is.
    pub fn kind(&self) -> BvhNodeKind {
        let node = self.reference();
        if node.is_inner() {
            BvhNodeKind::Inner { axis: node.axis(), left: node.link }
        } else {
            BvhNodeKind::Leaf { first: node.link, count: node.count() }
        }
    }
}

/// A binary BVH over triangles; every triangle is in exactly one leaf.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(crate) nodes: Vec<BvhNode>,
    pub(crate) references: Vec<u32>,
    /// In reference order.
    pub(crate) triangles: Vec<PreparedTriangle>,
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

impl Bvh {
    /// Nodes; root first, siblings adjacent.
    pub fn nodes(&self) -> &[BvhNode] {
        &self.nodes
    }

    /// Triangle indices (file order) of all leaves: a permutation.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Longest path from the root, in edges.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Expected cost of a random ray that meets the root (surface area heuristic, Goldsmith & Salmon 1987):
    /// `(Ct * sum of inner areas + Ci * sum of count * leaf area) / root area`. `None` when the root has no area.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        let root = self.nodes[0].bounds().half_area();
        let total: f64 = self
            .nodes
            .iter()
            .map(|node| {
                let area = node.bounds().half_area();
                match node.kind() {
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
            self.nodes.iter().filter_map(|node| match node.kind() {
                BvhNodeKind::Leaf { count, .. } => Some(count),
                BvhNodeKind::Inner { .. } => None,
            })
        };
        BvhStatistics {
            nodes: self.nodes.len() as u64,
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
        let mut reached = 0_usize;
        let mut pending = vec![(0_u32, self.nodes[0].bounds(), 0_u32)];
        while let Some((index, outer, depth)) = pending.pop() {
            let node =
                self.nodes.get(index as usize).ok_or_else(|| format!("node {index} does not exist"))?;
            reached += 1;
            let bounds = node.bounds();
            if self.references.is_empty() {
                break;
            }
            if bounds.union(outer) != outer {
                return Err(format!("the box of node {index} sticks out of its parent's"));
            }
            if depth > self.depth {
                return Err(format!("node {index} is deeper than the stated depth {}", self.depth));
            }
            match node.kind() {
                BvhNodeKind::Inner { left, .. } if left <= index => {
                    return Err(format!("node {index} links back to {left}"));
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
        if reached != self.nodes.len() {
            return Err(format!("{} nodes, but only {reached} are reachable", self.nodes.len()));
        }
        Ok(())
    }
}
