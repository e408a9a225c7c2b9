//! The nearest crossing of a ray and a scene, exactly.
//!
//! Walks the nodes of a BVH of the tracer with boxes and arithmetic of its own, in f64, so that it shares no test and no traversal
//! with what it judges.

use crate::exact::{Crossing, crossing};
use glam::DVec3;
use scenes::Triangle;
use tracer::bvh::{Bvh, BvhOptions};
use tracer::{Ray, Topology, TopologyNode};

/// Relative and absolute room in boxes, far above what f64 rounds.
const ROOM: f64 = 1e-9;

/// A scene.
pub(crate) struct Reference<'a> {
    triangles: &'a [Triangle],
    topology: Topology,
    /// Smallest and largest corner of what is below each node.
    boxes: Vec<[DVec3; 2]>,
}

impl<'a> Reference<'a> {
    pub(crate) fn new(triangles: &'a [Triangle]) -> Self {
        let bvh = Bvh::build(triangles, &BvhOptions::EQUAL_COSTS);
        let topology = Topology::of_bvh(&bvh);
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut boxes = vec![empty; topology.nodes.len()];
        // Children lie behind their parent.
        for (index, node) in topology.nodes.iter().enumerate().rev() {
            boxes[index] = match *node {
                TopologyNode::Inner { left } => {
                    let [a, b] = [boxes[left as usize], boxes[left as usize + 1]];
                    [a[0].min(b[0]), a[1].max(b[1])]
                }
                TopologyNode::Wide { .. } => unreachable!("the tree is binary"),
                TopologyNode::Leaf { first, count } => {
                    let references = &topology.references[first as usize..][..count as usize];
                    let corners = references.iter().flat_map(|&triangle| triangles[triangle as usize].v);
                    let grow = |[low, high]: [DVec3; 2], corner: DVec3| [low.min(corner), high.max(corner)];
                    corners.map(|corner| corner.as_dvec3()).fold(empty, grow)
                }
            };
        }
        Self { triangles, topology, boxes }
    }

    /// The triangles.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        self.triangles
    }

    /// The nearest crossing and its triangle; of equally near ones the lowest triangle.
    pub(crate) fn nearest(&self, ray: &Ray) -> Option<(u32, Crossing)> {
        let mut best: Option<(u32, Crossing)> = None;
        let mut open: Vec<(f64, usize)> = self.entry(ray, 0).map(|entry| (entry, 0)).into_iter().collect();
        while let Some((entry, node)) = open.pop() {
            let end = best.map_or(f64::INFINITY, |(_, found)| found.t);
            if entry > end + ROOM * end.abs() {
                continue;
            }
            match self.topology.nodes[node] {
                TopologyNode::Inner { left } => {
                    let children = [left as usize, left as usize + 1];
                    let [a, b] = children.map(|child| self.entry(ray, child).map(|entry| (entry, child)));
                    // The nearer one last, to be taken first.
                    let a_is_nearer = matches!((a, b), (Some(a), Some(b)) if a.0 < b.0);
                    open.extend(if a_is_nearer { [b, a] } else { [a, b] }.into_iter().flatten());
                }
                TopologyNode::Wide { .. } => unreachable!("the tree is binary"),
                TopologyNode::Leaf { first, count } => {
                    for &triangle in &self.topology.references[first as usize..][..count as usize] {
                        let Some(found) = crossing(ray, &self.triangles[triangle as usize]) else { continue };
                        let nearer = |&(id, old): &(u32, Crossing)| {
                            found.t < old.t || (found.t <= old.t && triangle < id)
                        };
                        if best.as_ref().is_none_or(nearer) {
                            best = Some((triangle, found));
                        }
                    }
                }
            }
        }
        best
    }

    /// Where the ray enters the box of a node, if it meets it; rather too early than too late.
    fn entry(&self, ray: &Ray, node: usize) -> Option<f64> {
        let [low, high] = self.boxes[node];
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (mut entry, mut exit) = (f64::from(ray.t_min), f64::from(ray.t_max));
        for axis in 0..3 {
            let reach = (low[axis] - origin[axis]).abs().max((high[axis] - origin[axis]).abs());
            let (low, high) = (low[axis] - ROOM * reach, high[axis] + ROOM * reach);
            if direction[axis] == 0.0 {
                if origin[axis] < low || origin[axis] > high {
                    return None;
                }
                continue;
            }
            let [a, b] = [(low - origin[axis]) / direction[axis], (high - origin[axis]) / direction[axis]];
            entry = entry.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        (entry <= exit).then_some(entry)
    }
}
