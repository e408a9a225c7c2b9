//! How the nodes of a structure are fetched where it has two levels, and where it has one.

use tracer::{NodeFetch, Topology, TraceHeader};

/// Which nodes are of the TLAS, which have records of another kind than those of the TLAS, and which are fetched without a sibling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Levels {
    /// Nodes below this are of the TLAS; 0 with one level.
    tlas_nodes: u32,
    /// Bits of an id that are 0 for a root alone.
    root_mask: u32,
    /// Wide nodes begin here where the TLAS above them is binary, as in traces from before a TLAS could be wide.
    wide_from: u32,
}

impl Levels {
    pub(crate) fn new(header: &TraceHeader, topology: &Topology) -> Self {
        let Some(levels) = &topology.levels else {
            return Self { tlas_nodes: 0, root_mask: u32::MAX, wide_from: u32::MAX };
        };
        let is_mixed = header.node_format.is_some() && header.node_fetch == NodeFetch::Pair;
        let wide_from = if is_mixed { levels.tlas_nodes } else { u32::MAX };
        Self { tlas_nodes: levels.tlas_nodes, root_mask: 1, wide_from }
    }

    /// Whether there is a TLAS.
    #[inline(always)]
    pub(crate) fn are_two(self) -> bool {
        self.tlas_nodes > 0
    }

    /// Whether the node is one of the TLAS.
    #[inline(always)]
    pub(crate) fn in_tlas(self, node: u32) -> bool {
        node < self.tlas_nodes
    }

    /// Whether the shader of BLASes is another one than that of the TLAS, so that a warp executes their node steps apart.
    #[inline(always)]
    pub(crate) fn are_unlike(self) -> bool {
        self.wide_from != u32::MAX
    }

    /// Whether a fetch in pairs reads the node's record alone: a root's, and that of a wide node.
    #[inline(always)]
    pub(crate) fn is_alone(self, node: u32) -> bool {
        node & self.root_mask == 0 || node >= self.wide_from
    }
}
