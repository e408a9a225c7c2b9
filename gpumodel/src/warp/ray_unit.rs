//! What a ray unit tests together, from what the lanes of a warp do in turn.

use crate::config::{RayScheduling, RayUnit};
use std::sync::Arc;
use tracer::{Op, Topology, TopologyNode};

/// What a ray unit tested.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct UnitTally {
    /// Box nodes, and triangles.
    pub(crate) nodes: [NodeTests; 2],
    /// Of the boxes, those of the TLAS, times the rays that met them.
    pub(crate) tlas_boxes: u64,
}

/// Tests of one kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NodeTests {
    /// Nodes tested with rays in up to one, two, three, and four quarters of a warp's lanes.
    pub(crate) by_quarters: [u64; 4],
    /// Boxes, or triangles, times the rays that met them.
    pub(crate) tests: u64,
    /// As `tests`, with the places for rays that stayed empty.
    pub(crate) places: u64,
}

/// How a ray unit tests the rays of a warp.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UnitTests {
    scheduling: RayScheduling,
    places: u32,
    warp_width: u32,
    /// Nodes of the TLAS; 0 with one level.
    tlas_nodes: u32,
    /// Of each node, the boxes that are tested at it: of a wide one those of its children, of a binary TLAS its own and its sibling's.
    boxes: Arc<[u8]>,
}

impl UnitTests {
    pub(super) fn new(unit: &RayUnit, warp_width: u32, topology: &Topology) -> Self {
        let tlas_nodes = topology.levels.as_ref().map_or(0, |levels| levels.tlas_nodes);
        let boxes = |(index, node): (u32, &TopologyNode)| match *node {
            TopologyNode::Wide { count, leaves, .. } => (count + leaves) as u8,
            TopologyNode::Inner { .. } | TopologyNode::Leaf { .. } if index < tlas_nodes => {
                1 + (index % 2) as u8
            }
            TopologyNode::Inner { .. } | TopologyNode::Leaf { .. } => 0,
        };
        Self {
            scheduling: unit.scheduling,
            places: unit.places(),
            warp_width,
            tlas_nodes,
            boxes: (0..).zip(&topology.nodes).map(boxes).collect(),
        }
    }

    /// Whether rays of a warp wait for each other.
    pub(super) fn in_lockstep(&self) -> bool {
        self.scheduling != RayScheduling::Ray
    }

    /// Whether a step is a test: to a unit that is an instruction, a leaf that holds an instance is a node of its own, with the instance's box.
    #[inline(always)]
    pub(super) fn tests(&self, op: Op) -> bool {
        match op {
            Op::Node | Op::Primitive => true,
            Op::Instance => self.scheduling == RayScheduling::Instruction,
            _ => false,
        }
    }

    /// Tests of the groups of `lanes`, each at one of `ids`.
    pub(super) fn count(&self, op: Op, lanes: &[u64], ids: &[u32], tally: &mut UnitTally) {
        let of_triangles = usize::from(op == Op::Primitive);
        let UnitTally { nodes, tlas_boxes } = tally;
        let tests = &mut nodes[of_triangles];
        let mut test = |id: u32, rays: u32, times: u32| {
            let boxes = match op {
                Op::Node => self.boxes.get(id as usize).copied().map_or(0, u64::from),
                _ => 1,
            };
            let quarter = (4 * rays).div_ceil(self.warp_width).clamp(1, 4) as usize - 1;
            tests.by_quarters[quarter] += u64::from(times);
            tests.tests += boxes * u64::from(rays * times);
            if op == Op::Instance || (op == Op::Node && id < self.tlas_nodes) {
                *tlas_boxes += boxes * u64::from(rays * times);
            }
            tests.places += boxes * u64::from(rays.next_multiple_of(self.places) * times);
        };
        for (index, (&group, &id)) in lanes.iter().zip(ids).enumerate() {
            match self.scheduling {
                RayScheduling::Ray | RayScheduling::Instruction => test(id, 1, group.count_ones()),
                RayScheduling::Warp if ids[..index].contains(&id) => {}
                RayScheduling::Warp => {
                    let at_node = lanes.iter().zip(ids).filter(|&(_, &other)| other == id);
                    test(id, at_node.fold(0, |all, (lanes, _)| all | lanes).count_ones(), 1);
                }
            }
        }
    }
}
