//! Where the tree and the stacks lie, which no choice of how triangles lie moves.

use super::buffers::{NOWHERE, STACK_ENTRY_BYTES};
use super::node::{Instances, NodeLayout};
use super::reads::Reads;
use super::records::NodeRecords;
use crate::error::Error;
use crate::replay::ReplayConfig;
use tracer::{NodeFetch, Topology, TopologyNode, TraceHeader};

/// The addresses that a traversal reads between triangles, in units of 16 bytes unless they are lines. Variants of a frame in which
/// these are equal ask the same of memory there.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct TreeBuffers {
    /// Of a node's record; of two levels, that of a BLAS.
    pub(crate) reads: Reads,
    /// Of a node's record in a TLAS, and of an instance's.
    pub(crate) tlas_reads: Reads,
    pub(crate) instance_reads: Reads,
    /// Of the leaf before it, where there is one, and how long that is, in 16 bytes.
    pub(crate) instance_leaf: Option<(Reads, u32)>,
    /// Lines of a load are its address shifted right by this.
    pub(crate) line_shift: u32,
    /// As `line_shift`, of private memory, in bytes.
    pub(crate) stack_line_shift: u32,
    /// Entries of a lane's stack in memory; 0 without one.
    pub(crate) stack_entries: u32,
    pub(super) nodes: Vec<u32>,
    /// Address of the first instance's record, the number of these, and from record to record.
    pub(super) instances: (u32, u32, u32),
}

impl TreeBuffers {
    /// Address of a node's record.
    #[inline(always)]
    pub(crate) fn node(&self, node: u32) -> Option<u32> {
        self.nodes.get(node as usize).copied().filter(|&address| address != NOWHERE)
    }

    /// How a node's record is read.
    #[inline(always)]
    pub(crate) fn reads_of(&self, in_tlas: bool) -> Reads {
        if in_tlas { self.tlas_reads } else { self.reads }
    }

    /// Loads of an instance's record, and of its leaf.
    pub(crate) fn instance_loads(&self) -> u32 {
        self.instance_reads.loads + self.instance_leaf.map_or(0, |(reads, _)| reads.loads)
    }

    /// Bytes that these read.
    pub(crate) fn instance_bytes(&self) -> u32 {
        self.instance_reads.bytes() + self.instance_leaf.map_or(0, |(reads, _)| reads.bytes())
    }

    /// Address of an instance's record.
    #[inline(always)]
    pub(crate) fn instance(&self, instance: u32) -> Option<u32> {
        let (first, count, stride) = self.instances;
        (instance < count).then(|| first + instance * stride)
    }

    /// Line of a lane's stack entry, counted from the first line of its warp's stacks.
    #[inline(always)]
    pub(crate) fn stack_line(&self, entry: u32, lane: u32, warp_width: u32) -> u32 {
        debug_assert!(entry < self.stack_entries);
        ((entry * warp_width + lane) * STACK_ENTRY_BYTES) >> self.stack_line_shift
    }
}

/// Where the records of a structure lie.
pub(super) struct TreePlaces {
    /// Bytes that a fetch of a node reads, and bytes from record to record: of a TLAS, and of any other tree.
    pub(super) tlas_bytes: (u32, u32),
    pub(super) bytes: (u32, u32),
    /// Per node, its record, in bytes from the first one's; `None` where there is none.
    pub(super) nodes: Vec<Option<u64>>,
    /// As `nodes`, of the first instance; and the number of these.
    pub(super) instances: (u64, u32),
    /// Bytes of all records.
    pub(super) total_bytes: u64,
}

/// Bytes at multiples of which acceleration structures begin, so each BLAS, and here the instances: Vulkan,
/// VUID-VkAccelerationStructureCreateInfoKHR-offset-03734.
const STRUCTURE_ALIGNMENT: u64 = 256;

impl TreePlaces {
    /// Lays out a tree, or a TLAS, its instances, and BLAS after BLAS.
    ///
    /// # Errors
    /// When no layout is known for the trace's traversal, or its nodes cannot have records as the configuration says.
    pub(super) fn new(
        header: &TraceHeader,
        topology: &Topology,
        config: &ReplayConfig,
    ) -> Result<Self, Error> {
        let bytes = config.node_records.bytes(header, &NodeLayout::of(header)?)?;
        let mut all = Self {
            tlas_bytes: bytes,
            bytes,
            nodes: vec![None; topology.nodes.len()],
            instances: (0, 0),
            total_bytes: 0,
        };
        let Some(levels) = &topology.levels else {
            all.add(0, topology, bytes.1, config);
            return Ok(all);
        };
        // Below a binary TLAS, whose nodes are fetched in pairs, BLASes may be wide.
        if header.node_fetch == NodeFetch::Pair {
            all.tlas_bytes = config.node_records.bytes(header, &NodeLayout::BVH)?;
        }
        for (number, (root, tree)) in topology.trees().iter().enumerate() {
            all.align();
            if number > 0 {
                all.add(*root, tree, bytes.1, config);
                continue;
            }
            all.add(*root, tree, all.tlas_bytes.1, config);
            all.align();
            all.instances = (all.total_bytes, levels.meshes.len() as u32);
            all.total_bytes += levels.meshes.len() as u64 * u64::from(Instances::of(header).layout.bytes);
        }
        Ok(all)
    }

    fn align(&mut self) {
        self.total_bytes = self.total_bytes.next_multiple_of(STRUCTURE_ALIGNMENT);
    }

    /// Appends the records of a tree whose root has the number `root`.
    fn add(&mut self, root: u32, tree: &Topology, stride: u32, config: &ReplayConfig) {
        let (places, records) = node_places(config, tree);
        for (node, place) in self.nodes[root as usize..].iter_mut().zip(places) {
            *node = (place != NOWHERE).then(|| self.total_bytes + u64::from(place) * u64::from(stride));
        }
        self.total_bytes += records * u64::from(stride);
    }
}

/// Per node, the place of the record that a fetch of it reads, and the number of records. With the boxes of both children in their
/// parent, a fetch of a left child reads its parent's record; no other node has one to read.
fn node_places(config: &ReplayConfig, topology: &Topology) -> (Vec<u32>, u64) {
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
