//! Buffers and their addresses. All buffers are disjoint and begin at multiples of 4096 bytes, so of every line.
//!
//! | buffer | records | found by |
//! |---|---|---|
//! | node | [`NodeLayout`] | node, through its [`NodeOrder`](super::NodeOrder) |
//! | primitive, normal | [`PrimitiveLayout`] | BVH: position in the leaves, in whose order triangles lie; kd: triangle in file order |
//! | index (kd only) | u32 triangle per reference | position in the leaves |
//! | stack (only where it is in memory) | 8 bytes per entry | resident warp, entry, lane: lanes lie side by side |

use super::VEC4_BYTES;
use super::node::NodeLayout;
use crate::error::Error;
use crate::replay::ReplayConfig;
use cachesim::LineSize;
use tracer::{Accel, TileSource};

/// Bytes of a stack entry: a node and a distance.
pub(crate) const STACK_ENTRY_BYTES: u32 = 8;
/// Where buffers may begin: a multiple of any line.
const ALIGNMENT: u64 = 4096;
const NOWHERE: u32 = u32::MAX;

/// What a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(crate) enum BufferKind {
    Node = 0,
    Primitive = 1,
    Index = 2,
    Normal = 3,
    Stack = 4,
}

impl BufferKind {
    pub(crate) const ALL: [Self; 5] = [Self::Node, Self::Primitive, Self::Index, Self::Normal, Self::Stack];
}

/// Records that are read in 16-byte loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reads {
    /// Loads of one lane.
    pub(crate) loads: u32,
    /// All loads of a record lie in one line, wherever the record is.
    pub(crate) one_line: bool,
}

impl Reads {
    fn new(bytes: u32, stride_bytes: u32, line: LineSize) -> Self {
        let aligned = bytes == stride_bytes && line.bytes().is_multiple_of(u64::from(bytes));
        Self { loads: bytes / VEC4_BYTES as u32, one_line: aligned }
    }
}

/// The addresses of a frame's buffers, in units of 16 bytes unless they are lines.
#[derive(Debug)]
pub(crate) struct Buffers {
    /// Bytes of all node records.
    pub(crate) structure_bytes: u64,
    pub(crate) node_reads: Reads,
    pub(crate) intersection_reads: Reads,
    pub(crate) shading_reads: Reads,
    /// Lines of a load are its address shifted right by this.
    pub(crate) line_shift: u32,
    /// As `line_shift`, of private memory.
    pub(crate) stack_line_shift: u32,
    /// First line of the stacks.
    pub(crate) stack_base_line: u32,
    /// Lines of the stacks of one resident warp.
    pub(crate) stack_stride_lines: u32,
    /// Entries of a lane's stack in memory; 0 without one.
    pub(crate) stack_entries: u32,
    nodes: Vec<u32>,
    /// Positions in the leaves.
    positions: u32,
    /// Per position, the triangle record; empty where triangles lie in leaf order.
    record_of_position: Vec<u32>,
    /// Per triangle, its record; empty where triangles lie in file order.
    record_of_triangle: Vec<u32>,
    triangles: u32,
    intersections: Records,
    shading: Records,
    index_base: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Records {
    base: u32,
    stride: u32,
}

impl Buffers {
    /// Lays out what `source` traverses. `warps` can be resident at once; lines are those of the paths of storage
    /// buffers and of private memory.
    pub(crate) fn new<S: TileSource>(
        source: &S,
        config: &ReplayConfig,
        warps: u32,
        line: LineSize,
        private_line: LineSize,
    ) -> Result<Self, Error> {
        let (header, topology) = (source.header(), source.topology());
        let fail = |problem: String, remedy: &str| Error::Trace {
            scene: header.scene.clone(),
            problem,
            remedy: remedy.to_owned(),
        };
        topology.validate().map_err(|problem| fail(problem, "record the trace again"))?;
        let node = NodeLayout::of(header)?;
        let primitive = config.primitive_layout;
        let leaf_order = header.accel == Accel::Bvh;
        let references = topology.references.len() as u64;
        let records = if leaf_order { references } else { u64::from(topology.triangles) };

        let mut next = 0_u64;
        let mut place = |bytes: u64| {
            let base = next;
            next += bytes.next_multiple_of(ALIGNMENT);
            base
        };
        let node_base = place(topology.nodes.len() as u64 * u64::from(node.bytes));
        let vertex_base = place(records * u64::from(primitive.vertex_record_bytes()));
        let split = primitive.normal_record_bytes() > 0;
        let normal_base = place(records * u64::from(primitive.normal_record_bytes()));
        let index_base = (!leaf_order).then(|| place(references * 4));
        let stack_entries = header.stack_entries;
        let stack_bytes =
            u64::from(stack_entries) * u64::from(STACK_ENTRY_BYTES) * u64::from(config.gpu.cores.warp_width);
        let stack_stride = stack_bytes.next_multiple_of(private_line.bytes());
        let stack_base = place(stack_stride * u64::from(warps));
        let end = next / VEC4_BYTES;
        if end > u64::from(u32::MAX) {
            return Err(fail(
                format!("its buffers take {next} bytes, expected less than 64 GiB"),
                "reduce the scene",
            ));
        }
        let vec4 = |bytes: u64| (bytes / VEC4_BYTES) as u32;

        let node_vec4 = node.bytes / VEC4_BYTES as u32;
        let positions = config.node_order.positions(topology);
        let nodes = positions.into_iter().map(|position| vec4(node_base) + position * node_vec4).collect();
        let (record_of_position, record_of_triangle) = if leaf_order {
            let mut records = vec![NOWHERE; topology.triangles as usize];
            for (position, &triangle) in (0..).zip(&topology.references) {
                let record = &mut records[triangle as usize];
                *record = position.min(*record);
            }
            (Vec::new(), records)
        } else {
            (topology.references.clone(), Vec::new())
        };

        let stride = primitive.vertex_record_bytes();
        let shading = primitive.shading_bytes();
        let (shading_base, shading_stride) =
            if split { (normal_base, primitive.normal_record_bytes()) } else { (vertex_base, stride) };
        let intersection = primitive.intersection_bytes();
        Ok(Self {
            structure_bytes: topology.nodes.len() as u64 * u64::from(node.bytes),
            node_reads: Reads::new(node.bytes, node.bytes, line),
            intersection_reads: Reads::new(intersection.len() as u32, stride, line),
            shading_reads: Reads::new(shading.len() as u32, shading_stride, line),
            line_shift: line.log2() - VEC4_BYTES.ilog2(),
            stack_line_shift: private_line.log2(),
            stack_base_line: (stack_base >> private_line.log2()) as u32,
            stack_stride_lines: (stack_stride >> private_line.log2()) as u32,
            stack_entries,
            nodes,
            positions: references as u32,
            record_of_position,
            record_of_triangle,
            triangles: topology.triangles,
            intersections: Records {
                base: vec4(vertex_base + u64::from(intersection.start)),
                stride: vec4(u64::from(stride)),
            },
            shading: Records {
                base: vec4(shading_base + u64::from(shading.start)),
                stride: vec4(u64::from(shading_stride)),
            },
            index_base: index_base.map(vec4),
        })
    }

    /// Whether primitives are found through an index list.
    pub(crate) fn has_index_list(&self) -> bool {
        self.index_base.is_some()
    }

    /// Address of a node's record.
    #[inline(always)]
    pub(crate) fn node(&self, node: u32) -> Option<u32> {
        self.nodes.get(node as usize).copied()
    }

    /// Address of what an intersection with the triangle at a position in the leaves reads.
    #[inline(always)]
    pub(crate) fn intersection(&self, position: u32) -> Option<u32> {
        let record = if self.record_of_position.is_empty() {
            (position < self.positions).then_some(position)?
        } else {
            *self.record_of_position.get(position as usize)?
        };
        Some(self.intersections.base + record * self.intersections.stride)
    }

    /// Line of the index list that holds a position in the leaves.
    #[inline(always)]
    pub(crate) fn index_line(&self, position: u32) -> u32 {
        (self.index_base.unwrap_or(0) + position / 4) >> self.line_shift
    }

    /// Address of what shading a triangle, in file order, reads.
    #[inline(always)]
    pub(crate) fn shading(&self, triangle: u32) -> Option<u32> {
        if triangle >= self.triangles {
            return None;
        }
        let record = if self.record_of_triangle.is_empty() {
            triangle
        } else {
            self.record_of_triangle[triangle as usize]
        };
        (record != NOWHERE).then(|| self.shading.base + record * self.shading.stride)
    }

    /// Line of a lane's stack entry, counted from the first line of its warp's stacks.
    #[inline(always)]
    pub(crate) fn stack_line(&self, entry: u32, lane: u32, warp_width: u32) -> u32 {
        debug_assert!(entry < self.stack_entries);
        ((entry * warp_width + lane) * STACK_ENTRY_BYTES) >> self.stack_line_shift
    }
}
