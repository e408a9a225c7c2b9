//! The wide BVH as data.

use super::format::NodeFormat;
use crate::aabb::{Aabb, PlaneSlack};
use crate::bvh::{NodeRef, leaf::Leaves};
use crate::topology::TopologyNode;
use crate::triangle::{RayTriangle, TriangleGroup};
use glam::Vec3;

/// A node: the boxes of its children as a shader computes them from its record, axis by axis, so that one vector operation serves them all, and
/// the children's links.
#[derive(Clone, Copy, Debug)]
pub(super) struct WideNode<const W: usize> {
    /// Lower planes in x, y, z, then upper ones. Where there is no child, the box contains nothing.
    pub(super) planes: [[f32; W]; 6],
    /// Of an inner child its node, of a leaf its first group.
    pub(super) links: [NodeRef; W],
    pub(super) children: u32,
}

impl<const W: usize> WideNode<W> {
    pub(super) const EMPTY: Self = Self {
        planes: {
            let (low, high) = ([f32::INFINITY; W], [f32::NEG_INFINITY; W]);
            [low, low, low, high, high, high]
        },
        links: [NodeRef::NOTHING; W],
        children: 0,
    };

    pub(super) fn new(boxes: &[Aabb], links: &[NodeRef; W]) -> Self {
        let mut node = Self { links: *links, children: boxes.len() as u32, ..Self::EMPTY };
        for (child, bounds) in boxes.iter().enumerate() {
            for axis in 0..3 {
                node.planes[axis][child] = bounds.min[axis];
                node.planes[axis + 3][child] = bounds.max[axis];
            }
        }
        node
    }

    /// Box and links of each child.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Aabb, NodeRef)> + '_ {
        (0..self.children as usize).map(|child| {
            let corner =
                |first: usize| Vec3::from_array(std::array::from_fn(|axis| self.planes[first + axis][child]));
            (Aabb { min: corner(0), max: corner(3) }, self.links[child])
        })
    }
}

/// The nodes of a wide BVH, whatever its leaves hold: triangles, or the instances of a TLAS.
///
/// A node holds the boxes of its children, and whether each is a node or a leaf: leaves have no record of their own. Node 0 is the root. The inner
/// children of a node follow each other, behind it.
#[derive(Clone, Debug)]
pub(crate) struct WideNodes<const W: usize> {
    pub(super) nodes: Vec<WideNode<W>>,
    /// Of each node; the root is its own.
    pub(super) parents: Vec<u32>,
    pub(super) format: NodeFormat,
    pub(super) depth: u32,
}

impl<const W: usize> WideNodes<W> {
    /// Number of nodes.
    pub(crate) fn len(&self) -> u32 {
        self.nodes.len() as u32
    }

    /// Longest path from the root to a node, in edges.
    pub(crate) fn depth(&self) -> u32 {
        self.depth
    }

    /// Entries that the stack of a traversal may take: all children of a node on the path but the one that the path goes through.
    pub(crate) fn stack_entries(&self) -> u32 {
        (W as u32 - 1) * (self.depth + 1)
    }

    /// Box and link of each child of a node.
    pub(crate) fn children(&self, node: u32) -> impl Iterator<Item = (Aabb, NodeRef)> + '_ {
        self.nodes[node as usize].iter()
    }

    /// The box around the boxes of all leaves; empty without one.
    pub(crate) fn bounds(&self) -> Aabb {
        self.children(0).fold(Aabb::EMPTY, |all, (bounds, _)| all.union(bounds))
    }

    /// The links of each node.
    pub(crate) fn links(&self) -> impl Iterator<Item = TopologyNode> + '_ {
        let mut next = 1;
        self.nodes.iter().map(move |node| {
            let inner = || node.iter().filter(|(_, link)| link.is_inner()).map(|(_, link)| link.link);
            let first = inner().min().unwrap_or(next);
            let count = inner().count() as u32;
            next = first + count;
            TopologyNode::Wide { first, count, leaves: node.children - count }
        })
    }
}

/// A BVH whose nodes have up to `W` children, over triangles prepared for a test as `P`; every triangle is in exactly one leaf.
#[derive(Clone, Debug)]
pub struct WideBvh<P: RayTriangle, const W: usize> {
    pub(super) tree: WideNodes<W>,
    pub(super) slack: PlaneSlack,
    pub(super) references: Vec<u32>,
    /// Positions of the second triangles of pairs, rising.
    pub(super) seconds: Vec<u32>,
    pub(super) groups: Vec<P::Group>,
}

/// Facts about a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideStatistics {
    /// Nodes.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// Children of all nodes, leaves among them.
    pub children: u64,
    /// References in the largest leaf.
    pub largest_leaf: u32,
}

impl<P: RayTriangle, const W: usize> WideBvh<P, W> {
    /// The format of its nodes.
    pub fn format(&self) -> NodeFormat {
        self.tree.format
    }

    /// Longest path from the root to a node, in edges.
    pub fn depth(&self) -> u32 {
        self.tree.depth()
    }

    /// Triangle indices (file order) of all leaves: a permutation.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Positions in [`Self::references`] whose triangle shares its record with the one before, rising.
    pub fn seconds(&self) -> &[u32] {
        &self.seconds
    }

    /// Entries that the stack of a traversal may take: all children of a node on the path but the one that the path goes through.
    pub fn stack_entries(&self) -> u32 {
        self.tree.stack_entries()
    }

    /// The box around the boxes of all leaves; empty without triangles.
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// What leaves refer to; the tree's first triangle has index `base` in hits.
    #[inline(always)]
    pub(super) fn leaves(&self, base: u32) -> Leaves<'_, P> {
        Leaves { references: &self.references, groups: &self.groups, base }
    }

    /// The links of each node.
    pub(crate) fn links(&self) -> impl Iterator<Item = TopologyNode> + '_ {
        self.tree.links()
    }

    /// Half the area of each node's box.
    fn half_areas(&self) -> Vec<f64> {
        let around = |node: &WideNode<W>| {
            node.iter().fold(Aabb::EMPTY, |all, (bounds, _)| all.union(bounds)).half_area()
        };
        self.tree.nodes.iter().map(around).collect()
    }

    /// Expected cost of a random ray that meets the box of the root (surface area heuristic): `(Ct * sum of node areas + Ci * sum of count * leaf
    /// area) / root area`, where boxes are as large as their format makes them. `None` when the root has no area.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        let areas = self.half_areas();
        let leaves = self.tree.nodes.iter().flat_map(WideNode::iter).filter(|(_, link)| !link.is_inner());
        let tests: f64 = leaves.map(|(bounds, link)| f64::from(link.count()) * bounds.half_area()).sum();
        let total = traversal_cost * areas.iter().sum::<f64>() + intersection_cost * tests;
        (areas[0] > 0.0).then(|| total / areas[0])
    }

    /// Counts over all nodes.
    pub fn statistics(&self) -> WideStatistics {
        let mut statistics =
            WideStatistics { nodes: self.tree.nodes.len() as u64, leaves: 0, children: 0, largest_leaf: 0 };
        for (_, link) in self.tree.nodes.iter().flat_map(WideNode::iter) {
            statistics.children += 1;
            if !link.is_inner() {
                statistics.leaves += 1;
                statistics.largest_leaf = statistics.largest_leaf.max(link.count());
            }
        }
        statistics
    }

    /// Checks what every traversal relies on: children exist and lie behind their parent, each node has one parent, the boxes of a node's children
    /// lie in its box where boxes are not quantised, leaves partition the references and are no larger than the format allows, and triangles
    /// lie in their leaf's box.
    ///
    /// # Errors
    /// A sentence that names the first node that breaks a rule.
    pub fn validate(&self, triangles: &[scenes::Triangle]) -> Result<(), String> {
        let mut parents = vec![0_u32; self.tree.nodes.len()];
        let mut seen = vec![false; triangles.len()];
        for (index, node) in self.tree.nodes.iter().enumerate() {
            for (bounds, link) in node.iter() {
                if link.is_inner() {
                    let child = link.link as usize;
                    if child <= index || child >= self.tree.nodes.len() {
                        return Err(format!("node {index} links to {child}"));
                    }
                    parents[child] += 1;
                    let below =
                        self.tree.nodes[child].iter().fold(Aabb::EMPTY, |all, (bounds, _)| all.union(bounds));
                    if self.tree.format.origin().is_none() && bounds.union(below) != bounds {
                        return Err(format!("the box of node {child} sticks out of its parent's"));
                    }
                    continue;
                }
                if self.tree.format.leaf_triangles().is_some_and(|most| link.count() > most) {
                    return Err(format!("a leaf of node {index} has {} triangles", link.count()));
                }
                let first = self.groups[link.link as usize].first() as usize;
                for &triangle in &self.references[first..first + link.count() as usize] {
                    if std::mem::replace(&mut seen[triangle as usize], true) {
                        return Err(format!("triangle {triangle} is in two leaves"));
                    }
                    if bounds.union(Aabb::of_triangle(&triangles[triangle as usize])) != bounds {
                        return Err(format!("triangle {triangle} sticks out of a leaf of node {index}"));
                    }
                }
            }
        }
        if let Some(node) = (1..parents.len()).find(|&node| parents[node] != 1) {
            return Err(format!("node {node} has {} parents", parents[node]));
        }
        match seen.iter().position(|&seen| !seen) {
            Some(missing) => Err(format!("triangle {missing} is in no leaf")),
            None => Ok(()),
        }
    }
}
