//! SAH BVH by a full sweep over sorted centroids (Wald 2007, "On fast construction of SAH-based bounding volume hierarchies",
//! section 2; Sousa et al. 2019: "each event is simply a primitive centroid").
//!
//! Centroids are sorted once per axis; a node evaluates every split of its three sorted lists and partitions the other two
//! stably, so that building costs O(N log N). Splitting a list by index, not space by a plane, leaves two non-empty children even
//! where all centroids coincide.

use super::tree::{Bvh, BvhNode, BvhNodeKind};
use crate::aabb::{Aabb, PlaneSlack};
use crate::triangle::RayTriangle;
use rayon::prelude::*;
use scenes::Triangle;

/// How to build a BVH.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhOptions {
    /// Cost of visiting an inner node, Ct.
    pub traversal_cost: f64,
    /// Cost of testing one triangle, Ci.
    pub intersection_cost: f64,
    /// Longest path from the root, in edges, at least `ceil(log2(triangles))`. Splits that could not be completed within it are
    /// not taken, so leaves do not grow because of it.
    pub max_depth: u32,
    /// Most triangles of a leaf, at least 1: more are split even where that does not pay.
    pub max_leaf: u32,
}

impl BvhOptions {
    /// The costs that Sousa et al. 2019 found efficient on a mobile GPU.
    pub const MOBILE: Self =
        Self { traversal_cost: 3.0, intersection_cost: 1.5, max_depth: Self::MAX_DEPTH, max_leaf: u32::MAX };
    /// Equal costs, as most CPU builders have them.
    pub const EQUAL_COSTS: Self =
        Self { traversal_cost: 1.0, intersection_cost: 1.0, max_depth: Self::MAX_DEPTH, max_leaf: u32::MAX };
    /// Deepest tree that the traversal stack and the 64-bit restart trail can hold.
    pub const MAX_DEPTH: u32 = 63;
}

/// Most triangles that a structure can hold: step ids have 28 bits.
pub(crate) const MAX_TRIANGLES: usize = 1 << 27;

/// Below this many primitives a subtree is built on one thread.
const PARALLEL_THRESHOLD: usize = 4096;

/// A node whose place is taken but whose content is not known yet; also the root of an empty tree.
const PENDING: BvhNode = BvhNode { bounds: Aabb::EMPTY, kind: BvhNodeKind::Leaf { first: 0, count: 0 } };

/// A node of the tree under construction, before its final index is known.
enum Draft {
    Leaf { bounds: Aabb, first: u32, count: u32 },
    Inner { bounds: Aabb, axis: usize, children: Box<[Draft; 2]> },
}

/// What the recursion shares.
struct Builder<'a> {
    boxes: &'a [Aabb],
    options: BvhOptions,
    /// Per primitive, whether it goes left; each subtree touches its own primitives only.
    sides: Vec<std::sync::atomic::AtomicBool>,
}

/// A node's primitives: three index lists of one set, each sorted by centroid on its axis, and scratch of the same length.
struct Task<'t> {
    lists: [&'t mut [u32]; 3],
    areas: &'t mut [f64],
    scratch: &'t mut [u32],
    /// Position of the first primitive in the final reference list.
    first: u32,
    depth: u32,
}

struct Split {
    axis: usize,
    left: usize,
    cost: f64,
}

/// A tree over boxes, before anything is stored for its leaves.
pub(crate) struct Swept {
    /// Root first, siblings adjacent, children behind their parent.
    pub(crate) nodes: Vec<BvhNode>,
    /// Indices of boxes, leaf after leaf, each exactly once.
    pub(crate) references: Vec<u32>,
    /// Longest path from the root, in edges.
    pub(crate) depth: u32,
}

/// Builds the tree over boxes that are finite and not empty. The same comes out on any number of threads.
///
/// The number of boxes and the depth limit are those of [`Bvh::build_for`].
pub(crate) fn sweep(boxes: &[Aabb], options: &BvhOptions) -> Swept {
    if boxes.is_empty() {
        return Swept { nodes: vec![PENDING], references: Vec::new(), depth: 0 };
    }
    let mut lists: [Vec<u32>; 3] = std::array::from_fn(|_| (0..boxes.len() as u32).collect::<Vec<u32>>());
    lists.par_iter_mut().enumerate().for_each(|(axis, list)| sort_by_centroid(list, boxes, axis));

    let builder = Builder {
        boxes,
        options: *options,
        sides: boxes.iter().map(|_| std::sync::atomic::AtomicBool::new(false)).collect(),
    };
    let mut areas = vec![0.0; boxes.len()];
    let mut scratch = vec![0; boxes.len()];
    let [x, y, z] = &mut lists;
    let draft = builder.subtree(Task {
        lists: [x, y, z],
        areas: &mut areas,
        scratch: &mut scratch,
        first: 0,
        depth: 0,
    });

    let mut nodes = vec![PENDING];
    let depth = place(draft, 0, 0, &mut nodes);
    // Every leaf left its primitives, in order, in all three lists.
    let [references, ..] = lists;
    Swept { nodes, references, depth }
}

impl Bvh {
    /// [`Bvh::build_for`] the test of Moller & Trumbore.
    ///
    /// # Panics
    /// As [`Bvh::build_for`].
    pub fn build(triangles: &[Triangle], options: &BvhOptions) -> Self {
        Self::build_for(triangles, options)
    }
}

impl<P: RayTriangle> Bvh<P> {
    /// Builds the tree. The same bytes come out on any number of threads.
    ///
    /// # Panics
    /// With more than 2^27 triangles, or a depth limit that cannot hold them: the caller checks both, see
    /// [`AccelerationStructure::build`](crate::AccelerationStructure::build).
    pub fn build_for(triangles: &[Triangle], options: &BvhOptions) -> Self {
        assert!(triangles.len() <= MAX_TRIANGLES);
        assert!(options.max_depth <= BvhOptions::MAX_DEPTH);
        assert!(triangles.len() <= 1_usize << options.max_depth.min(40));
        let boxes: Vec<Aabb> = triangles.par_iter().map(Aabb::of_triangle).collect();
        let Swept { nodes, references, depth } = sweep(&boxes, options);
        let prepared: Vec<P> = references.iter().map(|&id| P::from(&triangles[id as usize])).collect();
        let bvh = Self::from_nodes(&nodes, references, &prepared, depth, PlaneSlack::new(&boxes));
        debug_assert!(triangles.len() > 50_000 || bvh.validate(triangles) == Ok(()));
        bvh
    }
}

/// Sorts by centroid, then by primitive id, so that the order is total.
fn sort_by_centroid(list: &mut [u32], boxes: &[Aabb], axis: usize) {
    list.par_sort_unstable_by_key(|&id| {
        let Aabb { min, max } = boxes[id as usize];
        // Halved before adding: a sum of two coordinates near f32::MAX would overflow.
        let centroid = 0.5 * min[axis] + 0.5 * max[axis] + 0.0;
        let bits = centroid.to_bits();
        let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        u64::from(ordered) << 32 | u64::from(id)
    });
}

impl Builder<'_> {
    fn subtree(&self, task: Task) -> Draft {
        let Task { lists, areas, scratch, first, depth } = task;
        let count = lists[0].len();
        let bounds = lists[0].iter().fold(Aabb::EMPTY, |all, &id| all.union(self.boxes[id as usize]));
        let most = self.options.max_leaf as usize;
        let leaf_cost = self.options.intersection_cost * count as f64;
        let split = self.best_split(&lists, areas, bounds, depth);
        let Some(Split { axis, left, .. }) = split.filter(|split| split.cost < leaf_cost || count > most)
        else {
            // One order for all three lists, the primitive id, whichever axis happens to be first.
            for list in lists {
                list.sort_unstable();
            }
            return Draft::Leaf { bounds, first, count: count as u32 };
        };

        use std::sync::atomic::Ordering::Relaxed;
        for (position, &id) in lists[axis].iter().enumerate() {
            self.sides[id as usize].store(position < left, Relaxed);
        }
        let mut lists = lists;
        for (other, list) in lists.iter_mut().enumerate() {
            if other != axis {
                stable_partition(list, scratch, |id| self.sides[id as usize].load(Relaxed));
            }
        }

        let [x, y, z] = lists;
        let (x_left, x_right) = x.split_at_mut(left);
        let (y_left, y_right) = y.split_at_mut(left);
        let (z_left, z_right) = z.split_at_mut(left);
        let (areas_left, areas_right) = areas.split_at_mut(left);
        let (scratch_left, scratch_right) = scratch.split_at_mut(left);
        let low = Task {
            lists: [x_left, y_left, z_left],
            areas: areas_left,
            scratch: scratch_left,
            first,
            depth: depth + 1,
        };
        let high = Task {
            lists: [x_right, y_right, z_right],
            areas: areas_right,
            scratch: scratch_right,
            first: first + left as u32,
            depth: depth + 1,
        };
        let (low, high) = if count < PARALLEL_THRESHOLD {
            (self.subtree(low), self.subtree(high))
        } else {
            rayon::join(|| self.subtree(low), || self.subtree(high))
        };
        Draft::Inner { bounds, axis, children: Box::new([low, high]) }
    }

    /// The cheapest split; among equals the lowest axis, then the fewest primitives on the left.
    fn best_split(
        &self,
        lists: &[&mut [u32]; 3],
        areas: &mut [f64],
        bounds: Aabb,
        depth: u32,
    ) -> Option<Split> {
        let count = lists[0].len();
        let levels_below = self.options.max_depth.saturating_sub(depth + 1);
        let child_limit = 1_usize << levels_below.min(usize::BITS - 2);
        if count < 2 || depth >= self.options.max_depth {
            return None;
        }
        let area = bounds.half_area();
        // A node without area is met by no random ray: any split is as good as another, so treat the children as certain.
        let scale = if area > 0.0 { self.options.intersection_cost / area } else { 0.0 };
        let flat_cost = if area > 0.0 { 0.0 } else { self.options.intersection_cost * count as f64 };
        let mut best: Option<Split> = None;
        for (axis, list) in lists.iter().enumerate() {
            let mut box_right = Aabb::EMPTY;
            for (slot, &id) in areas.iter_mut().zip(list.iter()).rev() {
                box_right = box_right.union(self.boxes[id as usize]);
                *slot = box_right.half_area();
            }
            let mut box_left = Aabb::EMPTY;
            for left in 1..count {
                box_left = box_left.union(self.boxes[list[left - 1] as usize]);
                let right = count - left;
                let weighted = box_left.half_area() * left as f64 + areas[left] * right as f64;
                let cost = self.options.traversal_cost + flat_cost + scale * weighted;
                let completes = left.max(right) <= child_limit;
                if completes && best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Split { axis, left, cost });
                }
            }
        }
        best
    }
}

/// Moves the elements for which `is_left` holds to the front; both groups keep their order.
fn stable_partition(list: &mut [u32], scratch: &mut [u32], is_left: impl Fn(u32) -> bool) {
    let (mut low, mut high) = (0, 0);
    for position in 0..list.len() {
        let id = list[position];
        let left = is_left(id);
        list[low] = id;
        scratch[high] = id;
        low += usize::from(left);
        high += usize::from(!left);
    }
    list[low..].copy_from_slice(&scratch[..high]);
}

/// Gives drafts their final indices, depth first with siblings adjacent; returns the depth of the subtree's deepest node.
///
/// Recursion is bounded by [`BvhOptions::MAX_DEPTH`].
fn place(draft: Draft, index: usize, depth: u32, nodes: &mut Vec<BvhNode>) -> u32 {
    match draft {
        Draft::Leaf { bounds, first, count } => {
            nodes[index] = BvhNode { bounds, kind: BvhNodeKind::Leaf { first, count } };
            depth
        }
        Draft::Inner { bounds, axis, children } => {
            let left = nodes.len();
            nodes[index] = BvhNode { bounds, kind: BvhNodeKind::Inner { axis, left: left as u32 } };
            nodes.extend([PENDING; 2]);
            let [low, high] = *children;
            let low = place(low, left, depth + 1, nodes);
            low.max(place(high, left + 1, depth + 1, nodes))
        }
    }
}
