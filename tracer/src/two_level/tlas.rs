//! The upper level: a binary BVH over the world boxes of instances.

use crate::aabb::{Aabb, PlaneSlack};
use crate::bvh::{BvhNodeKind, BvhOptions, NodePair, NodeRef, PairTree, Swept, sweep};

/// The tree. A leaf links to its first position in `references`.
#[derive(Clone, Debug)]
pub(super) struct Tlas {
    root_bounds: Aabb,
    root: NodeRef,
    pairs: Vec<NodePair>,
    /// Numbers of instances, leaf after leaf, each at most once.
    pub(super) references: Vec<u32>,
    pub(super) depth: u32,
    pub(super) slack: PlaneSlack,
}

impl Tlas {
    /// An instance costs far more than a box, so leaves hold one each, unless no split would separate their boxes at all.
    const OPTIONS: BvhOptions =
        BvhOptions { traversal_cost: 0.0, intersection_cost: 1.0, ..BvhOptions::EQUAL_COSTS };

    /// The tree over `boxes`, finite or empty; an instance with an empty box is left out, as no ray can hit it. `condition` is the
    /// largest of the transforms', see [`Transform::condition`](super::transform::Transform::condition): hits in object space
    /// are off by as much more than those in world space.
    pub(super) fn new(boxes: &[Aabb], condition: f64) -> Self {
        let (numbers, boxes): (Vec<u32>, Vec<Aabb>) =
            (0..).zip(boxes).filter(|(_, bounds)| !bounds.is_empty()).unzip();
        let Swept { nodes, mut references, depth } = sweep(&boxes, &Self::OPTIONS);
        for reference in &mut references {
            *reference = numbers[*reference as usize];
        }
        let links: Vec<NodeRef> = nodes
            .iter()
            .map(|node| match node.kind {
                BvhNodeKind::Inner { axis, left } => NodeRef::inner(axis, left),
                BvhNodeKind::Leaf { first, count } => NodeRef::leaf(first, count),
            })
            .collect();
        Self {
            root_bounds: nodes[0].bounds,
            root: links[0],
            pairs: NodePair::pack(&nodes, &links),
            references,
            depth,
            slack: PlaneSlack::new(&boxes).thicker(condition as f32),
        }
    }

    pub(super) fn pair_tree(&self) -> PairTree<'_> {
        PairTree { root_bounds: &self.root_bounds, root: self.root, pairs: &self.pairs }
    }

    /// Number of nodes; odd.
    pub(super) fn node_count(&self) -> u32 {
        2 * self.pairs.len() as u32 + 1
    }

    /// The instances of a leaf.
    #[inline]
    pub(super) fn instances(&self, leaf: NodeRef) -> &[u32] {
        &self.references[leaf.link as usize..][..leaf.count() as usize]
    }
}
