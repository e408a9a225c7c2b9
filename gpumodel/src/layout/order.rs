//! The order of node records in their buffer. Records of binary trees hold explicit links to both children, so every order is legal. Those of
//! wide ones hold one link, to the first of their inner children, which follow each other.

use std::collections::VecDeque;
use tracer::Topology;

/// Not placed yet; not met from the root.
const UNPLACED: u32 = u32::MAX;

/// In which order the nodes of a tree lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeOrder {
    /// As a recursive builder writes them: a node, its left subtree, its right subtree. A left child follows its parent. In a wide tree: the
    /// children of a node, then what is below the first of them, and so on.
    #[default]
    DepthFirst,
    /// Level by level from the root, from left to right.
    BreadthFirst,
    /// The recursive order of van Emde Boas trees (Prokop 1999): the upper half of the levels, then each subtree below it, from
    /// left to right, all of them in the same way. Without knowing the line, a path then takes few lines of any size.
    VanEmdeBoas,
    /// As the trace numbers them: siblings side by side.
    AsBuilt,
}

impl NodeOrder {
    /// All orders.
    pub const ALL: [Self; 4] = [Self::DepthFirst, Self::BreadthFirst, Self::VanEmdeBoas, Self::AsBuilt];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthFirst => "depth-first",
            Self::BreadthFirst => "breadth-first",
            Self::VanEmdeBoas => "van-emde-boas",
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
        let count = topology.nodes.len();
        let mut positions = vec![UNPLACED; count];
        let mut next = 0;
        let mut place = |node: u32| {
            positions[node as usize] = next;
            next += 1;
        };
        match self {
            // Numbered so; a depth-first walk that goes from child to child would part them.
            Self::DepthFirst if topology.is_wide() => (0..count as u32).for_each(place),
            Self::DepthFirst | Self::BreadthFirst => self.for_each(topology, |node, _| place(node)),
            Self::VanEmdeBoas => Subtrees::new(topology).place(0, u32::MAX, &mut place),
            Self::AsBuilt => (0..count as u32).for_each(place),
        }
        for position in positions.iter_mut().filter(|position| **position == UNPLACED) {
            *position = next;
            next += 1;
        }
        positions
    }

    /// Visits each node that the root reaches once, with its parent: breadth first in that order, else depth first. A file's
    /// links may share a subtree; it belongs to the parent that is met first. The root is its own parent.
    fn for_each(self, topology: &Topology, mut visit: impl FnMut(u32, u32)) {
        let mut met = vec![false; topology.nodes.len()];
        let mut open = VecDeque::from([(0_u32, 0_u32)]);
        let breadth_first = self == Self::BreadthFirst;
        while let Some((node, parent)) = if breadth_first { open.pop_front() } else { open.pop_back() } {
            if std::mem::replace(&mut met[node as usize], true) {
                continue;
            }
            visit(node, parent);
            let children = topology.nodes[node as usize].children();
            if breadth_first {
                open.extend(children.map(|child| (child, node)));
            } else {
                open.extend(children.rev().map(|child| (child, node)));
            }
        }
    }
}

/// A tree, whatever links its file has, and the heights of its subtrees.
struct Subtrees<'a> {
    topology: &'a Topology,
    /// The one parent that a node belongs to.
    parents: Vec<u32>,
    /// Levels of a node's subtree, its own among them.
    heights: Vec<u32>,
}

impl<'a> Subtrees<'a> {
    fn new(topology: &'a Topology) -> Self {
        let count = topology.nodes.len();
        let (mut parents, mut order) = (vec![UNPLACED; count], Vec::with_capacity(count));
        NodeOrder::DepthFirst.for_each(topology, |node, parent| {
            parents[node as usize] = parent;
            order.push(node);
        });
        let mut heights = vec![1; count];
        for &node in order[1..].iter().rev() {
            let parent = parents[node as usize] as usize;
            heights[parent] = heights[parent].max(heights[node as usize] + 1);
        }
        Self { topology, parents, heights }
    }

    /// Places the upper `levels` levels of the subtree of `root`, or all that it has. `levels / 2` of them, rounded down, come
    /// first. Each call has at most half the levels of its caller, rounded up: any tree takes a few dozen calls in depth.
    fn place(&self, root: u32, levels: u32, place: &mut impl FnMut(u32)) {
        let levels = levels.min(self.heights[root as usize]);
        if levels == 1 {
            place(root);
            return;
        }
        let upper = levels / 2;
        self.place(root, upper, place);
        let mut open = vec![(root, 0)];
        while let Some((node, level)) = open.pop() {
            if level == upper {
                self.place(node, levels - upper, place);
            } else {
                let children = self.topology.nodes[node as usize].children().rev();
                let own = children.filter(|&child| self.parents[child as usize] == node);
                open.extend(own.map(|child| (child, level + 1)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::complete_tree;
    use std::collections::BTreeSet;
    use tracer::TopologyNode;

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
        let tree = Topology { nodes, ..Topology::default() };
        assert_eq!(NodeOrder::BreadthFirst.positions(&tree), [0, 1, 2, 5, 6, 3, 4]);
    }

    #[test]
    fn the_van_emde_boas_order_of_15_nodes_is_that_of_the_textbook() {
        // Two levels of three nodes, then four subtrees of three nodes, from left to right. Nodes are numbered as a heap.
        let order = [0, 1, 2, 3, 7, 8, 4, 9, 10, 5, 11, 12, 6, 13, 14];
        let positions = NodeOrder::VanEmdeBoas.positions(&complete_tree(8));
        assert!(order.iter().map(|&node: &usize| positions[node]).eq(0..15));
    }

    /// A path of `count` inner nodes with a leaf at each, and one at the end. Node `2 i` is on the path.
    fn path(count: u32) -> Topology {
        let leaf = TopologyNode::Leaf { first: 0, count: 0 };
        let pairs = (0..count).flat_map(|i| [TopologyNode::Inner { left: 2 * i + 1 }, leaf]);
        // The inner child is the right one: the left child of node 2 i is 2 i + 1, a leaf.
        Topology { nodes: pairs.chain([leaf]).collect(), ..Topology::default() }
    }

    #[test]
    fn a_path_of_ten_thousand_nodes_is_placed_from_the_root_down() {
        let tree = path(10_000);
        tree.validate().expect("a legal file");
        let positions = NodeOrder::VanEmdeBoas.positions(&tree);
        assert_eq!(positions[0], 0);
        assert!((0..10_000).all(|i| positions[2 * i] < positions[2 * i + 2]));
        let mut sorted = positions;
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..20_001));
    }

    #[test]
    fn links_that_share_subtrees_and_nodes_out_of_reach_are_placed_once() {
        let leaf = TopologyNode::Leaf { first: 0, count: 0 };
        // Each node has the next two as children, so that there are more paths than could be walked; two nodes lie apart.
        let shared = (0..100).map(|node| TopologyNode::Inner { left: node + 1 });
        let nodes = shared.chain([leaf; 4]).collect();
        let tree = Topology { nodes, ..Topology::default() };
        tree.validate().expect("a legal file");
        for order in NodeOrder::ALL {
            let mut positions = order.positions(&tree);
            assert_eq!(positions[0], 0, "{order:?}");
            assert_eq!(positions[102..], [102, 103], "{order:?}");
            positions.sort_unstable();
            assert!(positions.into_iter().eq(0..104), "{order:?}");
        }
    }

    #[test]
    fn a_path_through_a_complete_tree_takes_fewest_lines_in_van_emde_boas_order_where_a_line_holds_8_nodes() {
        const LEAVES: u32 = 1 << 14;
        let tree = complete_tree(LEAVES);
        let mean_lines = |order: NodeOrder, nodes_per_line: u32| {
            let positions = order.positions(&tree);
            let lines_to = |leaf: u32| {
                let path = std::iter::successors(Some(LEAVES - 1 + leaf), |&node| {
                    node.checked_sub(1).map(|n| n / 2)
                });
                path.map(|node| positions[node as usize] / nodes_per_line).collect::<BTreeSet<_>>().len()
            };
            (0..LEAVES).map(lines_to).sum::<usize>() as f64 / f64::from(LEAVES)
        };
        let of = |nodes_per_line| {
            [NodeOrder::VanEmdeBoas, NodeOrder::DepthFirst, NodeOrder::BreadthFirst]
                .map(|order| mean_lines(order, nodes_per_line))
        };
        // Nodes of 16 bytes in lines of 64: subtrees of three nodes leave every second line broken, and depth first wins.
        let [recursive, depth_first, breadth_first] = of(4);
        assert_eq!(recursive, 9.375);
        assert!(depth_first < recursive && recursive < breadth_first, "{depth_first}, {breadth_first}");
        for nodes_per_line in [8, 16, 64] {
            let [recursive, depth_first, breadth_first] = of(nodes_per_line);
            assert!(
                recursive < depth_first && depth_first < breadth_first,
                "{nodes_per_line} nodes per line"
            );
        }
    }

    #[test]
    fn names_name_their_orders() {
        for order in NodeOrder::ALL {
            assert_eq!(NodeOrder::from_name(order.name()), Some(order));
        }
        assert_eq!(NodeOrder::from_name("random"), None);
    }
}
