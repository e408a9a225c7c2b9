//! The order of node records in their buffer. Records hold explicit links to both children, so every order is legal.

use std::collections::VecDeque;
use tracer::{Topology, TopologyNode};

/// In which order the nodes of a tree lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeOrder {
    /// As a recursive builder writes them: a node, its left subtree, its right subtree. A left child follows its parent.
    #[default]
    DepthFirst,
    /// Level by level from the root, from left to right.
    BreadthFirst,
    /// As the trace numbers them: siblings side by side.
    AsBuilt,
}

impl NodeOrder {
    /// All orders.
    pub const ALL: [Self; 3] = [Self::DepthFirst, Self::BreadthFirst, Self::AsBuilt];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthFirst => "depth-first",
            Self::BreadthFirst => "breadth-first",
            Self::AsBuilt => "as-built",
        }
    }

    /// The order of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|order| order.name() == name)
    }

    /// Position in memory of each node. Nodes that the root does not reach come last, as numbered; the topology must be
    /// valid.
    pub(crate) fn positions(self, topology: &Topology) -> Vec<u32> {
        const UNPLACED: u32 = u32::MAX;
        let count = topology.nodes.len();
        if self == Self::AsBuilt {
            return (0..count as u32).collect();
        }
        let mut positions = vec![UNPLACED; count];
        let mut next = 0;
        let mut open = VecDeque::from([0_u32]);
        while let Some(node) = if self == Self::DepthFirst { open.pop_back() } else { open.pop_front() } {
            let position = &mut positions[node as usize];
            // A file's links may share a subtree; its first visit places it.
            if *position != UNPLACED {
                continue;
            }
            *position = next;
            next += 1;
            if let TopologyNode::Inner { left } = topology.nodes[node as usize] {
                let children = if self == Self::DepthFirst { [left + 1, left] } else { [left, left + 1] };
                open.extend(children);
            }
        }
        for position in positions.iter_mut().filter(|position| **position == UNPLACED) {
            *position = next;
            next += 1;
        }
        positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::complete_tree;

    #[test]
    fn every_order_is_a_permutation() {
        let tree = complete_tree(64);
        for order in NodeOrder::ALL {
            let mut positions = order.positions(&tree);
            positions.sort_unstable();
            assert!(positions.into_iter().eq(0..127), "{order:?}");
        }
    }

    #[test]
    fn in_depth_first_order_a_left_child_follows_its_parent_and_a_right_one_its_siblings_subtree() {
        // Node 0 has children 1 and 2; 1 has 3 and 4; 2 has 5 and 6.
        let tree = complete_tree(4);
        assert_eq!(NodeOrder::DepthFirst.positions(&tree), [0, 1, 4, 2, 3, 5, 6]);
    }

    #[test]
    fn in_breadth_first_order_levels_follow_each_other() {
        // An unbalanced tree: 0 -> (1, 2), 2 -> (3, 4), 1 -> (5, 6).
        let leaf = TopologyNode::Leaf { first: 0, count: 0 };
        let nodes = vec![
            TopologyNode::Inner { left: 1 },
            TopologyNode::Inner { left: 5 },
            TopologyNode::Inner { left: 3 },
            leaf,
            leaf,
            leaf,
            leaf,
        ];
        let tree = Topology { nodes, references: Vec::new(), triangles: 0 };
        assert_eq!(NodeOrder::BreadthFirst.positions(&tree), [0, 1, 2, 5, 6, 3, 4]);
    }

    #[test]
    fn names_name_their_orders() {
        for order in NodeOrder::ALL {
            assert_eq!(NodeOrder::from_name(order.name()), Some(order));
        }
        assert_eq!(NodeOrder::from_name("random"), None);
    }
}
