//! Checks of what the literature says about structures and traversals, from finished trees and recorded steps alone.
//!
//! They share no code with the builders and traversals that they check.

use crate::observe::Op;
use crate::topology::{Topology, TopologyNode};
use crate::trace::{RaySet, Step};

/// Relative rounding that a sum of areas may have.
const ROUNDING: f64 = 1e-6;

/// Inner nodes whose split, by the surface area heuristic, costs more than a leaf of their references would:
/// `Ct + Ci (A_L n_L + A_R n_R) / A > Ci n`, beyond rounding. `areas` are those of the nodes' boxes or cells, `n` are distinct
/// triangles. A builder that stops where splitting does not pay makes none. The nodes of a wide BVH are not split in two: it has none.
pub fn splits_costlier_than_leaf(topology: &Topology, areas: &[f64], [ct, ci]: [f64; 2]) -> u64 {
    let mut below: Vec<Vec<u32>> = vec![Vec::new(); topology.nodes.len()];
    let mut costlier = 0;
    // Children lie behind their parent.
    for (index, node) in topology.nodes.iter().enumerate().rev() {
        below[index] = match *node {
            TopologyNode::Leaf { first, count } => {
                let mut triangles = topology.references[first as usize..][..count as usize].to_vec();
                triangles.sort_unstable();
                triangles
            }
            TopologyNode::Inner { left } => {
                let children = [left as usize, left as usize + 1];
                let [lower, upper] = children.map(|child| std::mem::take(&mut below[child]));
                let inside: f64 = children
                    .iter()
                    .zip([lower.len(), upper.len()])
                    .map(|(&child, count)| areas[child] * count as f64)
                    .sum();
                let all = union(&lower, &upper);
                let (split, leaf) = (ct + ci * inside / areas[index], ci * all.len() as f64);
                costlier += u64::from(areas[index] > 0.0 && split > leaf * (1.0 + ROUNDING));
                all
            }
            TopologyNode::Wide { .. } => Vec::new(),
        };
    }
    costlier
}

/// Union of two rising lists.
fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = Vec::with_capacity(a.len() + b.len());
    all.extend_from_slice(a);
    all.extend_from_slice(b);
    all.sort_unstable();
    all.dedup();
    all
}

/// Leaves, over all rays of the set, whose triangles a ray tests although it has tested them before.
pub fn leaves_tested_twice(topology: &Topology, set: &RaySet) -> u64 {
    let mut is_first = vec![false; topology.references.len()];
    for node in &topology.nodes {
        if let TopologyNode::Leaf { first, count: 1.. } = *node {
            is_first[first as usize] = true;
        }
    }
    let mut twice = 0;
    let mut tested: Vec<u32> = Vec::new();
    for ray in 0..set.ends.len() {
        let steps = set.steps[set.range(ray)].iter();
        let primitives = steps.filter(|step| step.op() == Op::Primitive).map(|step| step.id());
        tested.clear();
        tested.extend(primitives.filter(|&position| is_first[position as usize]));
        tested.sort_unstable();
        twice += tested.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    }
    twice
}

/// Restarts of a kd push-down traversal, over all rays, from a node other than the lowest one whose cell was known to hold all that
/// the ray had yet to visit when the descent before began.
///
/// The judge is the traversal with a full stack: where it pushes, a node has two children to visit, and it visits the
/// leaves in the same order. `stack` and `push_down` are the same rays through the same tree.
pub fn restarts_above_push_down(topology: &Topology, stack: &RaySet, push_down: &RaySet) -> u64 {
    let mut wrong = 0;
    let mut visits = Visits::default();
    for ray in 0..stack.ends.len().min(push_down.ends.len()) {
        visits.read(topology, &stack.steps[stack.range(ray)]);
        let mut leaves = 0;
        let mut at_descent = 0;
        for step in &push_down.steps[push_down.range(ray)] {
            match step.op() {
                Op::Node if is_leaf(topology, step.id()) => leaves += 1,
                Op::Restart => {
                    wrong += u64::from(visits.lowest(at_descent) != Some(step.id()));
                    at_descent = leaves;
                }
                _ => {}
            }
        }
    }
    wrong
}

fn is_leaf(topology: &Topology, node: u32) -> bool {
    matches!(topology.nodes[node as usize], TopologyNode::Leaf { .. })
}

/// What a ray finds at the inner nodes that a traversal with a full stack visits.
#[derive(Default)]
struct Visits {
    /// Node, the child entered first, and the one that was pushed.
    inner: Vec<(u32, u32, Option<u32>)>,
    /// Node, and how many leaves had been visited when the traversal came to it; by node.
    arrivals: Vec<(u32, u32)>,
}

impl Visits {
    fn read(&mut self, topology: &Topology, steps: &[Step]) {
        self.inner.clear();
        self.arrivals.clear();
        let mut leaves = 0;
        for (index, step) in steps.iter().enumerate().filter(|(_, step)| step.op() == Op::Node) {
            let node = step.id();
            self.arrivals.push((node, leaves));
            match topology.nodes[node as usize] {
                TopologyNode::Leaf { .. } => leaves += 1,
                TopologyNode::Wide { .. } => {}
                TopologyNode::Inner { left } => {
                    let mut after = steps[index + 1..].iter();
                    let pushed = after.clone().next().is_some_and(|step| step.op() == Op::Push);
                    if let Some(first) = after.find(|step| step.op() == Op::Node).map(|step| step.id()) {
                        let other = if first == left { left + 1 } else { left };
                        self.inner.push((node, first, pushed.then_some(other)));
                    }
                }
            }
        }
        self.inner.sort_unstable();
        self.arrivals.sort_unstable();
    }

    /// The lowest node that holds all that is left after `leaves` leaves.
    fn lowest(&self, leaves: u32) -> Option<u32> {
        let mut node = self.arrivals.first()?.0;
        loop {
            let Ok(place) = self.inner.binary_search_by_key(&node, |&(inner, ..)| inner) else {
                return Some(node);
            };
            node = match self.inner[place] {
                (_, first, None) => first,
                (_, _, Some(far)) => {
                    let arrival = self.arrivals.binary_search_by_key(&far, |&(node, _)| node).ok();
                    match arrival.map(|place| self.arrivals[place].1) {
                        Some(at) if at <= leaves => far,
                        _ => return Some(node),
                    }
                }
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::NO_HIT;

    /// Node 0 with leaves 1 and 2 of two and one triangles.
    fn two_leaves() -> Topology {
        Topology {
            nodes: vec![
                TopologyNode::Inner { left: 1 },
                TopologyNode::Leaf { first: 0, count: 2 },
                TopologyNode::Leaf { first: 2, count: 1 },
            ],
            references: vec![0, 1, 1],
            triangles: 2,
            ..Topology::default()
        }
    }

    fn rays(rays: &[&[(Op, u32)]]) -> RaySet {
        let mut set = RaySet::default();
        for steps in rays {
            set.steps.extend(steps.iter().map(|&(op, id)| Step::new(op, id)));
            set.end_ray(NO_HIT).expect("few steps");
        }
        set
    }

    #[test]
    fn a_split_counts_where_it_costs_more_than_the_leaf_and_not_where_as_much() {
        // Two distinct triangles as a leaf cost 2 Ci; split: Ct + Ci (0.5 * 2 + 0.25 * 1).
        let costlier = |ct| splits_costlier_than_leaf(&two_leaves(), &[4.0, 2.0, 1.0], [ct, 1.0]);
        assert_eq!((costlier(0.7), costlier(0.75), costlier(0.76)), (0, 0, 1));
    }

    #[test]
    fn a_leaf_is_tested_twice_only_by_the_same_ray() {
        use Op::Primitive;
        let once: &[(Op, u32)] = &[(Primitive, 0), (Primitive, 1), (Primitive, 2)];
        let twice: &[(Op, u32)] = &[(Primitive, 0), (Primitive, 1), (Primitive, 0), (Primitive, 1)];
        assert_eq!(leaves_tested_twice(&two_leaves(), &rays(&[once, once])), 0);
        assert_eq!(leaves_tested_twice(&two_leaves(), &rays(&[once, twice])), 1);
    }

    #[test]
    fn a_restart_is_right_at_the_lowest_node_that_held_the_rest() {
        use Op::{Node, Pop, Push, Restart};
        // 0 -> (1, 2); 1 -> (3, 4), all else leaves. The ray enters only 1 of 0, then both of 1.
        let leaf = TopologyNode::Leaf { first: 0, count: 0 };
        let nodes = vec![TopologyNode::Inner { left: 1 }, TopologyNode::Inner { left: 3 }, leaf, leaf, leaf];
        let topology = Topology { nodes, ..Topology::default() };
        let stack = rays(&[&[(Node, 0), (Node, 1), (Push, 0), (Node, 3), (Pop, 0), (Node, 4)]]);
        let with = |restart| {
            let steps = [(Node, 0), (Node, 1), (Node, 3), (Restart, restart), (Node, 1), (Node, 4)];
            restarts_above_push_down(&topology, &stack, &rays(&[&steps]))
        };
        assert_eq!((with(1), with(0), with(3)), (0, 1, 1));
    }
}
