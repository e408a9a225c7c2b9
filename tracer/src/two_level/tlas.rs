//! The upper level: a BVH over the world boxes of instances, with nodes of the kind that the BLASes have.

use crate::aabb::{Aabb, PlaneSlack, SlabRay};
use crate::bvh::{BvhNodeKind, BvhOptions, NodePair, NodeRef, PairTree, Swept, stack, sweep};
use crate::error::Error;
use crate::observe::Observer;
use crate::ray::{Hit, Ray};
use crate::topology::{Topology, TopologyNode};
use crate::wide::{self, NodeFormat, WideNodes};

/// A tree over the boxes of instances.
pub trait TopLevel: Sized + Send + Sync {
    /// What it is built with.
    type Format: Copy;

    /// The tree over `boxes`, finite or empty; an instance with an empty box is left out, as no ray can hit it. `condition` is the
    /// largest of the transforms', see [`Transform::condition`](super::transform::Transform::condition): hits in object space
    /// are off by as much more than those in world space.
    ///
    /// # Errors
    /// When the format cannot hold the boxes.
    fn build(boxes: &[Aabb], condition: f64, format: Self::Format) -> Result<Self, Error>;
    /// Number of nodes.
    fn node_count(&self) -> u32;
    /// Longest path from the root to a node, in edges.
    fn depth(&self) -> u32;
    /// Most entries that a full stack takes.
    fn stack_entries(&self) -> u32;
    /// Links, and numbers of instances as references.
    fn topology(&self) -> Topology;
    /// Whether `holds` says so of an instance in a leaf that is reached through boxes of which `enters` says so.
    fn any_instance(&self, enters: impl Fn(&Aabb) -> bool, holds: impl Fn(u32) -> bool) -> bool;
    /// Walks it with a full stack, nearest child first. `at_leaf` gets the instances of a leaf, the number of stack entries, the best hit so
    /// far and the observer, and says whether the walk is over.
    fn walk<const ANY: bool, O: Observer>(
        &self,
        ray: &Ray,
        best: &mut Hit,
        observer: &mut O,
        at_leaf: impl FnMut(&[u32], u32, &mut Hit, &mut O) -> bool,
    );
}

/// What leaves hold: each links to its first position among numbers of instances, leaf after leaf, each at most once.
#[derive(Clone, Debug)]
pub(super) struct InstanceLists(Vec<u32>);

impl InstanceLists {
    /// The instances of a leaf.
    #[inline(always)]
    pub(super) fn of(&self, leaf: NodeRef) -> &[u32] {
        &self.0[leaf.link as usize..][..leaf.count() as usize]
    }
}

/// A TLAS of binary nodes.
#[derive(Clone, Debug)]
pub struct BinaryTlas {
    root_bounds: Aabb,
    root: NodeRef,
    pairs: Vec<NodePair>,
    instances: InstanceLists,
    depth: u32,
    slack: PlaneSlack,
}

/// A TLAS of nodes with up to `W` children.
#[derive(Clone, Debug)]
pub struct WideTlas<const W: usize> {
    pub(super) tree: WideNodes<W>,
    pub(super) instances: InstanceLists,
    pub(super) slack: PlaneSlack,
}

impl BinaryTlas {
    /// An instance costs far more than a box, so leaves hold one each, unless no split would separate their boxes at all.
    const OPTIONS: BvhOptions =
        BvhOptions { traversal_cost: 0.0, intersection_cost: 1.0, ..BvhOptions::EQUAL_COSTS };

    fn with_options(boxes: &[Aabb], condition: f64, options: &BvhOptions) -> Self {
        let (numbers, boxes): (Vec<u32>, Vec<Aabb>) =
            (0..).zip(boxes).filter(|(_, bounds)| !bounds.is_empty()).unzip();
        let Swept { nodes, mut references, depth } = sweep(&boxes, options);
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
            instances: InstanceLists(references),
            depth,
            slack: PlaneSlack::new(&boxes).thicker(condition as f32),
        }
    }

    fn pair_tree(&self) -> PairTree<'_> {
        PairTree { root_bounds: &self.root_bounds, root: self.root, pairs: &self.pairs }
    }
}

impl TopLevel for BinaryTlas {
    type Format = ();

    fn build(boxes: &[Aabb], condition: f64, (): ()) -> Result<Self, Error> {
        Ok(Self::with_options(boxes, condition, &Self::OPTIONS))
    }

    /// Odd.
    fn node_count(&self) -> u32 {
        2 * self.pairs.len() as u32 + 1
    }

    fn depth(&self) -> u32 {
        self.depth
    }

    fn stack_entries(&self) -> u32 {
        self.depth
    }

    fn topology(&self) -> Topology {
        let node = |index| {
            let (_, links) = self.pair_tree().node(index);
            if links.is_inner() {
                TopologyNode::Inner { left: links.link }
            } else {
                TopologyNode::Leaf { first: links.link, count: links.count() }
            }
        };
        Topology {
            nodes: (0..self.node_count()).map(node).collect(),
            references: self.instances.0.clone(),
            ..Topology::default()
        }
    }

    fn any_instance(&self, enters: impl Fn(&Aabb) -> bool, holds: impl Fn(u32) -> bool) -> bool {
        let mut pending = vec![0];
        while let Some(index) = pending.pop() {
            let (bounds, node) = self.pair_tree().node(index);
            if !enters(&bounds) {
                continue;
            }
            if node.is_inner() {
                pending.extend([node.link + 1, node.link]);
            } else if self.instances.of(node).iter().any(|&number| holds(number)) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn walk<const ANY: bool, O: Observer>(
        &self,
        ray: &Ray,
        best: &mut Hit,
        observer: &mut O,
        mut at_leaf: impl FnMut(&[u32], u32, &mut Hit, &mut O) -> bool,
    ) {
        let slab = SlabRay::new(ray, &self.slack);
        stack::walk::<ANY, O>(
            self.pair_tree(),
            &slab,
            ray.t_min,
            best,
            observer,
            |leaf, stacked, best, observer| at_leaf(self.instances.of(leaf), stacked, best, observer),
        );
    }
}

impl<const W: usize> TopLevel for WideTlas<W> {
    type Format = NodeFormat;

    /// A leaf is an instance, as in the drivers of Adreno and of AMD, whatever the format allows for triangles.
    fn build(boxes: &[Aabb], condition: f64, format: NodeFormat) -> Result<Self, Error> {
        let options = BvhOptions { max_leaf: 1, ..BinaryTlas::OPTIONS };
        let binary = BinaryTlas::with_options(boxes, condition, &options);
        let tree = WideNodes::collapse(binary.pair_tree(), format)?;
        Ok(Self { tree, instances: binary.instances, slack: binary.slack })
    }

    fn node_count(&self) -> u32 {
        self.tree.len()
    }

    fn depth(&self) -> u32 {
        self.tree.depth()
    }

    fn stack_entries(&self) -> u32 {
        self.tree.stack_entries()
    }

    fn topology(&self) -> Topology {
        Topology {
            nodes: self.tree.links().collect(),
            references: self.instances.0.clone(),
            ..Topology::default()
        }
    }

    fn any_instance(&self, enters: impl Fn(&Aabb) -> bool, holds: impl Fn(u32) -> bool) -> bool {
        let mut pending = vec![0];
        while let Some(node) = pending.pop() {
            for (_, link) in self.tree.children(node).filter(|(bounds, _)| enters(bounds)) {
                if link.is_inner() {
                    pending.push(link.link);
                } else if self.instances.of(link).iter().any(|&number| holds(number)) {
                    return true;
                }
            }
        }
        false
    }

    #[inline(always)]
    fn walk<const ANY: bool, O: Observer>(
        &self,
        ray: &Ray,
        best: &mut Hit,
        observer: &mut O,
        mut at_leaf: impl FnMut(&[u32], u32, &mut Hit, &mut O) -> bool,
    ) {
        let slab = SlabRay::new(ray, &self.slack);
        wide::stack::walk::<ANY, W, O>(
            &self.tree,
            &slab,
            ray.t_min,
            best,
            observer,
            |leaf, stacked, best, observer| at_leaf(self.instances.of(leaf), stacked, best, observer),
        );
    }
}
