//! SAH kd-tree construction in O(N log N) after Wald & Havran 2006: sort all events once, then divide the sorted lists.
//!
//! Cells with many triangles are divided one by one, their children in parallel; smaller ones are finished by one thread with
//! buffers that are used again. The tree does not depend on the number of threads.
//!
//! It ends: a split is taken only where it is cheaper than a leaf, at most [`KdOptions::depth_cap`] deep, and while the
//! budget of references lasts. A bonus for empty cells cannot make it repeat itself: an empty child has thickness, so
//! the other child is smaller than the cell.

use super::events::{Cell, EventLists};
use super::options::{KdOptions, Splits};
use super::partition::{Geometry, Partitioner};
use super::sweep::{Split, best_split};
use super::tree::{KdNode, KdTree};
use crate::aabb::{Aabb, PlaneSlack};
use crate::error::Error;
use crate::triangle::RayTriangle;
use glam::Vec3;
use scenes::Triangle;

/// Cells of at most this many triangles are finished by one thread. Its scratch space then fits the first-level cache.
const ONE_THREAD: u32 = 16 * 1024;

/// Small trees are checked after building where debug assertions are on.
const CHECKED_TRIANGLES: usize = 4096;

impl KdTree {
    /// [`KdTree::build_for`] the test of Moller & Trumbore.
    ///
    /// # Errors
    /// As [`KdTree::build_for`].
    pub fn build(triangles: &[Triangle], options: &KdOptions) -> Result<Self, Error> {
        Self::build_for(triangles, options)
    }
}

impl<P: RayTriangle> KdTree<P> {
    /// Builds a tree over `triangles` (finite corners; degenerate ones are welcome).
    ///
    /// The tree is the same for any number of threads.
    ///
    /// # Errors
    /// Options out of range, too many triangles, a corner that is not finite.
    pub fn build_for(triangles: &[Triangle], options: &KdOptions) -> Result<Self, Error> {
        options.check(triangles.len())?;
        if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
            return Err(Error::Options(format!(
                "triangle {index} has a corner that is not finite; remove it before building a kd-tree"
            )));
        }
        let boxes: Vec<Aabb> = triangles.iter().map(Aabb::of_triangle).collect();
        let slack = PlaneSlack::new(&boxes);
        let bounds = *slack.scene();
        let subtree = if triangles.is_empty() {
            Subtree { nodes: vec![KdNode::leaf(0, 0)], ..Subtree::default() }
        } else {
            let builder = Builder { triangles, options, depth_cap: options.depth_cap(triangles.len()) };
            let lists = EventLists::sorted(&boxes);
            drop(boxes);
            let ids = (0..triangles.len() as u32).collect();
            // Adding zero makes -0.0 positive, as in the events.
            let cell = Cell { min: bounds.min + Vec3::ZERO, max: bounds.max + Vec3::ZERO };
            builder.grow(lists, ids, Place { cell, depth: 0 }, budget(triangles.len()))
        };
        let tree = Self {
            nodes: subtree.nodes,
            references: subtree.references,
            bounds,
            slack,
            depth: subtree.depth,
            triangles: triangles.iter().map(P::from).collect(),
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

/// What a leaf of `count` references takes from the budget.
fn need(count: u32) -> u64 {
    u64::from(count) + 1
}

/// Where in the tree a cell is.
#[derive(Clone, Copy)]
struct Place {
    cell: Cell,
    depth: u32,
}

impl Place {
    fn split(&self, split: &Split) -> [Self; 2] {
        let (left, right) = self.cell.split(split.axis, split.position);
        [left, right].map(|cell| Self { cell, depth: self.depth + 1 })
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

    /// Builds the subtree of a cell; `ids` maps the triangles of `lists` to those of the scene. What the children need is theirs,
    /// the rest of the budget is shared in proportion.
    fn grow(&self, lists: EventLists, ids: Vec<u32>, place: Place, budget: u64) -> Subtree {
        if lists.count <= ONE_THREAD {
            return OneThread::build(self, &lists, &ids, place, budget);
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
        let needs = [need(left.count), need(right.count)];
        let Some(spare) = budget.checked_sub(needs[0] + needs[1]) else { return leaf(&lists) };
        let [left_budget, right_budget] = needs.map(|own| own + spare * own / (needs[0] + needs[1]));
        let [left_place, right_place] = place.split(&split);
        drop(lists);
        drop(partitioner);
        let left_ids = renumber(&mut left, &ids);
        let right_ids = renumber(&mut right, &ids);
        drop(ids);
        let (left, right) = rayon::join(
            || self.grow(left, left_ids, left_place, left_budget),
            || self.grow(right, right_ids, right_place, right_budget),
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
    /// What is left when every open cell has become a leaf.
    spare: u64,
    tree: Subtree,
}

impl<'a> OneThread<'a> {
    fn build(
        builder: &'a Builder<'a>,
        lists: &EventLists,
        ids: &'a [u32],
        place: Place,
        budget: u64,
    ) -> Subtree {
        let mut this = Self {
            builder,
            ids,
            partitioner: Partitioner::new(ids.len()),
            pool: Vec::new(),
            spare: budget.saturating_sub(need(lists.count)),
            tree: Subtree { nodes: vec![KdNode::leaf(0, 0)], ..Subtree::default() },
        };
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
        let rest = (self.spare + need(lists.count)).checked_sub(need(left.count) + need(right.count));
        if let Some(rest) = rest {
            self.spare = rest;
            let first = self.tree.nodes.len();
            self.tree.nodes[slot] = KdNode::inner(split.axis, split.position, first as u32);
            self.tree.nodes.extend([KdNode::leaf(0, 0); 2]);
            for (child, (lists, place)) in children.iter().zip(place.split(&split)).enumerate() {
                self.fill(first + child, lists, place);
            }
        }
        self.pool.push(children);
        rest.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Overlapping triangles along a diagonal.
    fn triangles(count: u32) -> Vec<Triangle> {
        let corner = |i: u32, k: u32| {
            let at = |salt: u32| ((i * 37 + k * 11 + salt).wrapping_mul(2_654_435_761) >> 20) as f32;
            Vec3::new(at(1), at(2), at(3)) + Vec3::splat(i as f32)
        };
        (0..count).map(|i| Triangle { v: [0, 1, 2].map(|k| corner(i, k)) }).collect()
    }

    /// References and leaves of a tree built within a budget.
    fn used(triangles: &[Triangle], budget: u64) -> u64 {
        let options = &KdOptions { traversal_cost: 0.0, ..KdOptions::MOBILE };
        let boxes: Vec<Aabb> = triangles.iter().map(Aabb::of_triangle).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, &one| all.union(one));
        let cell = Cell { min: bounds.min, max: bounds.max };
        let builder = Builder { triangles, options, depth_cap: 24 };
        let ids = (0..triangles.len() as u32).collect();
        let tree = builder.grow(EventLists::sorted(&boxes), ids, Place { cell, depth: 0 }, budget);
        let leaves = tree.nodes.len() as u64 / 2 + 1;
        tree.references.len() as u64 + leaves
    }

    #[test]
    fn a_tree_fills_its_budget_and_does_not_exceed_it() {
        for count in [1000, ONE_THREAD + 1000] {
            let triangles = triangles(count);
            let free = used(&triangles, 1 << 30);
            let least = u64::from(count) + 1;
            assert!(free > 3 * least, "{free}");
            for budget in [0, least, least + 1, 2 * least, 3 * least] {
                let used = used(&triangles, budget);
                assert!(used <= budget.max(least), "{used} of {budget}");
                assert!(used >= budget / 10 * 9, "{used} of {budget}");
            }
        }
    }
}
