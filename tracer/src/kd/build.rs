//! SAH kd-tree construction in O(N log N) after Wald & Havran 2006: sort all events once, then divide the sorted lists.
//!
//! Cells with many triangles are divided one by one, their children in parallel; smaller ones are finished by one thread with
//! buffers that are used again. The tree does not depend on the number of threads.
//!
//! It ends: a split is taken only where it is cheaper than a leaf, at most [`KdOptions::depth_cap`] deep, and while the cell's
//! share of the reference budget lasts. A bonus for empty cells cannot make it repeat itself: an empty child has thickness, so
//! the other child is smaller than the cell.

use super::events::{Cell, EventLists};
use super::options::{KdOptions, Splits};
use super::partition::{Geometry, Partitioner};
use super::sweep::{Split, best_split};
use super::tree::{KdNode, KdTree};
use crate::aabb::Aabb;
use crate::error::Error;
use crate::triangle::PreparedTriangle;
use glam::Vec3;
use scenes::Triangle;

/// Cells of at most this many triangles are finished by one thread. Its scratch space then fits the first-level cache.
const ONE_THREAD: u32 = 16 * 1024;

/// Small trees are checked after building where debug assertions are on.
const CHECKED_TRIANGLES: usize = 4096;

impl KdTree {
    /// Builds a tree over `triangles` (finite corners; degenerate ones are welcome).
    ///
    /// The tree is the same for any number of threads.
    ///
    /// # Errors
    /// Options out of range, too many triangles, a corner that is not finite.
    pub fn build(triangles: &[Triangle], options: &KdOptions) -> Result<Self, Error> {
        options.check(triangles.len())?;
        if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
            return Err(Error::Options(format!(
                "triangle {index} has a corner that is not finite; remove it before building a kd-tree"
            )));
        }
        let boxes: Vec<Aabb> = triangles.iter().map(Aabb::of_triangle).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, &one| all.union(one));
        let subtree = if triangles.is_empty() {
            Subtree { nodes: vec![KdNode::leaf(0, 0)], ..Subtree::default() }
        } else {
            let builder = Builder { triangles, options, depth_cap: options.depth_cap(triangles.len()) };
            let lists = EventLists::sorted(&boxes);
            drop(boxes);
            let ids = (0..triangles.len() as u32).collect();
            // Adding zero makes -0.0 positive, as in the events.
            let cell = Cell { min: bounds.min + Vec3::ZERO, max: bounds.max + Vec3::ZERO };
            builder.grow(lists, ids, Place { cell, depth: 0, budget: budget(triangles.len()) })
        };
        let tree = Self {
            nodes: subtree.nodes,
            references: subtree.references,
            bounds,
            depth: subtree.depth,
            triangles: triangles.iter().map(PreparedTriangle::from).collect(),
        };
        if cfg!(debug_assertions) && triangles.len() <= CHECKED_TRIANGLES {
            let defect = tree.validate().err();
            debug_assert!(defect.is_none(), "kd-tree of {} triangles: {defect:?}", triangles.len());
        }
        Ok(tree)
    }
}

/// What all leaves together may use: one for each reference, and one for the leaf. Twice as many nodes fit in an index.
fn budget(triangles: usize) -> u64 {
    let wanted = KdOptions::REFERENCES_PER_TRIANGLE * triangles as u64 + KdOptions::FREE_REFERENCES;
    wanted.min(u64::from(KdNode::MAX_PAYLOAD) / 2)
}

/// Where in the tree a cell is.
#[derive(Clone, Copy)]
struct Place {
    cell: Cell,
    depth: u32,
    budget: u64,
}

impl Place {
    /// The children's places, or `None` where the budget does not allow them. What is left over is shared by need.
    fn split(&self, split: &Split, left: u32, right: u32) -> Option<[Self; 2]> {
        let needs = [left, right].map(|count| u64::from(count) + 1);
        let need = needs[0] + needs[1];
        let spare = self.budget.checked_sub(need)?;
        let (left_cell, right_cell) = self.cell.split(split.axis, split.position);
        let place = |cell, own| Self { cell, depth: self.depth + 1, budget: own + spare * own / need };
        Some([place(left_cell, needs[0]), place(right_cell, needs[1])])
    }
}

/// A finished part of the tree; its root is node 0, its links count from there.
#[derive(Default)]
struct Subtree {
    nodes: Vec<KdNode>,
    references: Vec<u32>,
    depth: u32,
}

impl Subtree {
    fn set_leaf(&mut self, slot: usize, lists: &EventLists, ids: &[u32]) {
        let first = self.references.len();
        self.references.extend(lists.ids().map(|id| ids[id as usize]));
        let references = &mut self.references[first..];
        references.sort_unstable();
        self.nodes[slot] = KdNode::leaf(first as u32, references.len() as u32);
    }

    /// The tree of an inner node: root, the two children, the rest of the left subtree, the rest of the right one.
    fn join(split: &Split, left: &Self, right: &Self) -> Self {
        let mut nodes = Vec::with_capacity(1 + left.nodes.len() + right.nodes.len());
        nodes.push(KdNode::inner(split.axis, split.position, 1));
        let left_shift = 2;
        let right_shift = left.nodes.len() as u32 + 1;
        let right_first = left.references.len() as u32;
        let of_left = |node: &KdNode| node.moved(left_shift, 0);
        let of_right = |node: &KdNode| node.moved(right_shift, right_first);
        nodes.push(of_left(&left.nodes[0]));
        nodes.push(of_right(&right.nodes[0]));
        nodes.extend(left.nodes[1..].iter().map(of_left));
        nodes.extend(right.nodes[1..].iter().map(of_right));
        Self {
            nodes,
            references: [&left.references[..], &right.references].concat(),
            depth: left.depth.max(right.depth),
        }
    }
}

struct Builder<'a> {
    triangles: &'a [Triangle],
    options: &'a KdOptions,
    depth_cap: u32,
}

impl Builder<'_> {
    fn best_split(&self, lists: &EventLists, place: &Place) -> Option<Split> {
        if place.depth < self.depth_cap { best_split(lists, &place.cell, self.options) } else { None }
    }

    fn geometry<'b>(&'b self, ids: &'b [u32]) -> Option<Geometry<'b>> {
        (self.options.splits == Splits::Perfect).then_some(Geometry { triangles: self.triangles, ids })
    }

    /// Builds the subtree of a cell; `ids` maps the triangles of `lists` to those of the scene.
    fn grow(&self, lists: EventLists, ids: Vec<u32>, place: Place) -> Subtree {
        if lists.count <= ONE_THREAD {
            return OneThread::build(self, &lists, &ids, place);
        }
        let leaf = |lists: &EventLists| {
            let mut leaf =
                Subtree { nodes: vec![KdNode::leaf(0, 0)], depth: place.depth, ..Subtree::default() };
            leaf.set_leaf(0, lists, &ids);
            leaf
        };
        let Some(split) = self.best_split(&lists, &place) else { return leaf(&lists) };
        let (mut left, mut right) = (EventLists::default(), EventLists::default());
        let geometry = self.geometry(&ids);
        let mut partitioner = Partitioner::new(ids.len());
        partitioner.divide(&lists, &split, &place.cell, geometry.as_ref(), &mut left, &mut right);
        let Some([left_place, right_place]) = place.split(&split, left.count, right.count) else {
            return leaf(&lists);
        };
        drop(lists);
        drop(partitioner);
        let left_ids = renumber(&mut left, &ids);
        let right_ids = renumber(&mut right, &ids);
        drop(ids);
        let (left, right) = rayon::join(
            || self.grow(left, left_ids, left_place),
            || self.grow(right, right_ids, right_place),
        );
        Subtree::join(&split, &left, &right)
    }
}

/// Renumbers the triangles of `lists` from 0, in their old order; returns which triangle of the scene each is.
fn renumber(lists: &mut EventLists, ids: &[u32]) -> Vec<u32> {
    let mut number = vec![u32::MAX; ids.len()];
    lists.ids().for_each(|id| number[id as usize] = 0);
    let mut kept = Vec::with_capacity(lists.count as usize);
    for (number, &id) in number.iter_mut().zip(ids).filter(|(number, _)| **number == 0) {
        *number = kept.len() as u32;
        kept.push(id);
    }
    for event in lists.axes.iter_mut().flatten() {
        *event = event.with_id(number[event.id() as usize]);
    }
    kept
}

/// Builds a subtree depth first; the event lists of one cell for each level are alive, and their buffers are used again.
struct OneThread<'a> {
    builder: &'a Builder<'a>,
    ids: &'a [u32],
    partitioner: Partitioner,
    pool: Vec<[EventLists; 2]>,
    tree: Subtree,
}

impl<'a> OneThread<'a> {
    fn build(builder: &'a Builder<'a>, lists: &EventLists, ids: &'a [u32], place: Place) -> Subtree {
        let tree = Subtree { nodes: vec![KdNode::leaf(0, 0)], ..Subtree::default() };
        let mut this =
            Self { builder, ids, partitioner: Partitioner::new(ids.len()), pool: Vec::new(), tree };
        this.fill(0, lists, place);
        this.tree
    }

    /// Recursion is as deep as the tree, at most [`KdOptions::MAX_DEPTH`].
    fn fill(&mut self, slot: usize, lists: &EventLists, place: Place) {
        if !self.fill_inner(slot, lists, place) {
            self.tree.depth = self.tree.depth.max(place.depth);
            self.tree.set_leaf(slot, lists, self.ids);
        }
    }

    fn fill_inner(&mut self, slot: usize, lists: &EventLists, place: Place) -> bool {
        let Some(split) = self.builder.best_split(lists, &place) else { return false };
        let mut children = self.pool.pop().unwrap_or_default();
        let [left, right] = &mut children;
        let geometry = self.builder.geometry(self.ids);
        self.partitioner.divide(lists, &split, &place.cell, geometry.as_ref(), left, right);
        let places = place.split(&split, left.count, right.count);
        if let Some(places) = places {
            let first = self.tree.nodes.len();
            self.tree.nodes[slot] = KdNode::inner(split.axis, split.position, first as u32);
            self.tree.nodes.extend([KdNode::leaf(0, 0); 2]);
            for (child, (lists, place)) in children.iter().zip(places).enumerate() {
                self.fill(first + child, lists, place);
            }
        }
        self.pool.push(children);
        places.is_some()
    }
}
