//! Where the tree and the stacks lie, which no choice of how triangles lie moves.

use super::buffers::{NOWHERE, Reads, STACK_ENTRY_BYTES};
use super::records::NodeRecords;
use crate::replay::ReplayConfig;
use tracer::{Topology, TopologyNode};

/// The addresses that a traversal reads between triangles, in units of 16 bytes unless they are lines. Variants of a frame in which
/// these are equal ask the same of memory there.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct TreeBuffers {
    /// Of a node's record.
    pub(crate) reads: Reads,
    /// Lines of a load are its address shifted right by this.
    pub(crate) line_shift: u32,
    /// As `line_shift`, of private memory, in bytes.
    pub(crate) stack_line_shift: u32,
    /// Entries of a lane's stack in memory; 0 without one.
    pub(crate) stack_entries: u32,
    pub(super) nodes: Vec<u32>,
}

impl TreeBuffers {
    /// Address of a node's record.
    #[inline(always)]
    pub(crate) fn node(&self, node: u32) -> Option<u32> {
        self.nodes.get(node as usize).copied().filter(|&address| address != NOWHERE)
    }

    /// Line of a lane's stack entry, counted from the first line of its warp's stacks.
    #[inline(always)]
    pub(crate) fn stack_line(&self, entry: u32, lane: u32, warp_width: u32) -> u32 {
        debug_assert!(entry < self.stack_entries);
        ((entry * warp_width + lane) * STACK_ENTRY_BYTES) >> self.stack_line_shift
    }
}

/// Per node, the place of the record that a fetch of it reads, and the number of records. With the boxes of both children in their
/// parent, a fetch of a left child reads its parent's record; no other node has one to read.
pub(super) fn node_places(config: &ReplayConfig, topology: &Topology) -> (Vec<u32>, u64) {
    let positions = config.node_order.positions(topology);
    let count = positions.len();
    if config.node_records != NodeRecords::ChildBoxes {
        return (positions, count as u64);
    }
    let mut inner: Vec<(u32, u32)> = Vec::new();
    for (node, &position) in topology.nodes.iter().zip(&positions) {
        if let TopologyNode::Inner { left } = *node {
            inner.push((position, left));
        }
    }
    inner.sort_unstable();
    let mut places = vec![NOWHERE; count];
    for (place, &(_, left)) in (0..).zip(&inner) {
        places[left as usize] = place;
    }
    (places, inner.len() as u64)
}
