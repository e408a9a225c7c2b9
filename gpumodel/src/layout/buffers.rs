//! Buffers and their addresses. All buffers are disjoint and begin at multiples of 4096 bytes, so of every line.
//!
//! | buffer | records | found by |
//! |---|---|---|
//! | node | [`NodeLayout`](super::NodeLayout): of a tree, or of a TLAS, the instances, and each BLAS | node, through its [`NodeOrder`](super::NodeOrder); instance |
//! | primitive, normal (only where normals are apart) | [`TriangleRecords`] | [`PrimitiveOrder`] |
//! | index (only where triangles are indexed) | u32 triangle per reference | position in the leaves |
//! | stack (only where it is in memory) | 8 bytes per entry | resident warp, entry, lane: lanes lie side by side |
//! | vertex (only for rasterisation) | three vertices per triangle of each mesh, no index list | triangle in file order |
//! | mask, micromap (only of alpha-tested triangles) | 64 bytes of texels; bits per micro-triangle | position in the leaves |
//! | image, attachment (only where a pass writes one for another) | 4x4 pixels side by side | tile, then Morton order |

use super::VEC4_BYTES;
use super::alpha::{Mask, Micromaps};
use super::instanced::InstancedTriangles;
use super::node::Instances;
use super::order::NodeOrder;
use super::primitive::TriangleRecords;
use super::reads::Reads;
use super::records::PrimitiveOrder;
use super::tree::{TreeBuffers, TreePlaces};
use crate::config::{RayUnit, Technique, VECTOR_BYTES};
use crate::error::Error;
use crate::replay::ReplayConfig;
use cachesim::LineSize;
use tracer::wide::NodeFormat;
use tracer::{TILE_RAYS, TileSource, Topology, TraceHeader};

/// Vertices of a triangle without an index list.
pub(crate) const CORNERS: u64 = 3;
/// Bytes of a stack entry: a node and a distance.
pub(crate) const STACK_ENTRY_BYTES: u32 = 8;
/// Bytes of a pixel of an image or attachment.
pub(crate) const PIXEL_BYTES: u64 = 4;
/// Where buffers may begin: a multiple of any line.
const ALIGNMENT: u64 = 4096;
pub(super) const NOWHERE: u32 = u32::MAX;

/// What a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(crate) enum BufferKind {
    Node = 0,
    Primitive = 1,
    Index = 2,
    Normal = 3,
    Stack = 4,
    Vertex = 5,
    Image = 6,
    Attachment = 7,
    Record = 8,
    /// Words that atomics change.
    Counter = 9,
}

impl BufferKind {
    pub(crate) const ALL: [Self; 10] = [
        Self::Node,
        Self::Primitive,
        Self::Index,
        Self::Normal,
        Self::Stack,
        Self::Vertex,
        Self::Image,
        Self::Attachment,
        Self::Record,
        Self::Counter,
    ];
}

/// How much memory each buffer takes, in bytes; 0 for one that the frame does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BufferBytes {
    /// Node records, and those of instances: one structure for an API.
    pub node: u64,
    /// Triangles for intersection, with their normals unless those are apart or left out.
    pub primitive: u64,
    /// Index lists of leaves.
    pub index: u64,
    /// Normals in a buffer of their own.
    pub normal: u64,
    /// Stacks of all warps that can be resident.
    pub stack: u64,
    /// Vertices for rasterisation.
    pub vertex: u64,
    /// Images and attachments that one pass writes and another reads.
    pub image: u64,
    /// Rays, hits and their orders, which one compute pass lists for another.
    pub record: u64,
    /// Masks of alpha-tested triangles.
    pub mask: u64,
    /// Opacity micromaps.
    pub micromap: u64,
}

impl BufferBytes {
    /// All buffers together.
    pub fn total(&self) -> u64 {
        let Self { node, primitive, index, normal, stack, vertex, image, record, mask, micromap } = self;
        [node, primitive, index, normal, stack, vertex, image, record, mask, micromap].into_iter().sum()
    }
}

fn order(header: &TraceHeader, config: &ReplayConfig) -> PrimitiveOrder {
    config.primitive_order.unwrap_or_else(|| PrimitiveOrder::of(header.accel))
}

/// Whether triangles of a leaf that share an edge are in one record.
pub(crate) fn in_pairs(header: &TraceHeader) -> bool {
    header.node_format.is_some_and(NodeFormat::has_pairs)
}

/// Records of triangles, where each has one.
fn records(header: &TraceHeader, topology: &Topology, config: &ReplayConfig) -> u64 {
    match order(header, config) {
        PrimitiveOrder::Leaf => topology.references.len() as u64,
        PrimitiveOrder::Indexed => u64::from(topology.stored_triangles()),
    }
}

/// Bytes that normals take in the records of triangles and vertices, or would take where they are left out.
pub(crate) fn normal_bytes(header: &TraceHeader, topology: &Topology, config: &ReplayConfig) -> u64 {
    let record = |with_normals| TriangleRecords::of(config.primitive_layout, in_pairs(header), with_normals);
    let of_record = record(true).bytes() - record(false).bytes();
    let of_vertices = config.technique.raster.map_or(0, |_| CORNERS * u64::from(VECTOR_BYTES));
    records(header, topology, config) * u64::from(of_record)
        + u64::from(topology.stored_triangles()) * of_vertices
}

/// What the cores add to the addresses of a stream: where private memory lies, and where tile memory goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Places {
    /// First line of the stacks.
    pub(crate) stack_base_line: u32,
    /// Lines of the stacks of one resident warp.
    pub(crate) stack_stride_lines: u32,
    /// Bytes that all buffers take together.
    pub(crate) end: u64,
}

/// The addresses of a frame's buffers, in units of 16 bytes unless they are lines.
#[derive(Debug)]
pub(crate) struct Buffers {
    /// Bytes of all node records.
    pub(crate) structure_bytes: u64,
    /// Bytes that each buffer takes.
    pub(crate) sizes: BufferBytes,
    /// Bytes from vertex to vertex of what is rasterised; 0 where nothing is.
    pub(crate) vertex_stride: u32,
    pub(crate) tree: TreeBuffers,
    pub(crate) intersection_reads: Reads,
    pub(crate) shading_reads: Reads,
    /// Where shading reads.
    pub(crate) shading_kind: BufferKind,
    /// First line of the stacks.
    pub(crate) stack_base_line: u32,
    /// Lines of the stacks of one resident warp.
    pub(crate) stack_stride_lines: u32,
    /// Where a warp's call frames begin in its stack, in bytes.
    call_frames: u64,
    /// Positions in the leaves.
    positions: u32,
    /// Per position, the triangle record; empty where triangles lie in leaf order.
    record_of_position: Vec<u32>,
    /// Per triangle, its record; empty where triangles lie in file order.
    record_of_triangle: Vec<u32>,
    triangles: u32,
    instanced: Option<InstancedTriangles>,
    intersections: Records,
    shading: Records,
    index_base: Option<u32>,
    /// Where any-hit shaders sample the mask.
    mask: Mask,
    pub(crate) micromaps: Option<Micromaps>,
    /// Addresses in bytes: of the vertices, and of the image or the first attachment.
    pub(crate) vertex_base: u64,
    pub(crate) image_base: u64,
    /// Bytes from attachment to attachment.
    pub(crate) image_bytes: u64,
    /// Address in bytes of what follows the last buffer.
    pub(crate) end: u64,
}

/// Of each position in the leaves, the record: the second triangle of a pair has that of the first.
fn pair_records(topology: &Topology) -> Vec<u32> {
    let mut seconds = topology.seconds.iter().copied().peekable();
    let mut joined = 0;
    let record = |position: u32| {
        joined += u32::from(seconds.next_if_eq(&position).is_some());
        position - joined
    };
    (0..topology.references.len() as u32).map(record).collect()
}

#[derive(Clone, Copy, Debug)]
struct Records {
    base: u32,
    stride: u32,
}

impl Buffers {
    /// Lays out what `source` traverses. `warps` can be resident at once; lines are those of the paths of storage
    /// buffers and of private memory.
    pub(crate) fn new<S: TileSource + ?Sized>(
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
        let is_wide = topology.is_wide() || header.node_format.is_some();
        if is_wide && config.node_order == NodeOrder::VanEmdeBoas {
            return Err(fail(
                "a node of its wide BVH links to the first of its inner children, and the others follow it: van-emde-boas order parts them"
                    .to_owned(),
                "use depth-first or breadth-first order",
            ));
        }
        let structure = TreePlaces::new(header, topology, config)?;
        let in_pairs = in_pairs(header);
        let primitive = TriangleRecords::of(config.primitive_layout, in_pairs, header.normals);
        let leaf_order = order(header, config) == PrimitiveOrder::Leaf;
        if in_pairs && !leaf_order {
            return Err(fail(
                "its triangles are in pairs by leaves, and an index list names them one by one".to_owned(),
                "use triangles in the order of the leaves",
            ));
        }
        let references = topology.references.len() as u64;
        let records = records(header, topology, config);
        let joined = if in_pairs { topology.seconds.len() as u64 } else { 0 };
        let vertex_records = records - joined;

        let mut next = 0_u64;
        let mut place = |bytes: u64| {
            let base = next;
            next += bytes.next_multiple_of(ALIGNMENT);
            base
        };
        let structure_bytes = structure.total_bytes;
        let node_base = place(structure_bytes);
        let vertex_base = place(vertex_records * u64::from(primitive.vertex_bytes));
        let split = primitive.normal_bytes > 0;
        let normal_base = place(records * u64::from(primitive.normal_bytes));
        let index_bytes = if leaf_order { 0 } else { references * 4 };
        let index_base = (!leaf_order).then(|| place(index_bytes));
        let by_ray_unit = config.gpu.ray_unit_for(header).is_some();
        let reads = if by_ray_unit { Reads::of_lines } else { Reads::new };
        let unit_walks = config.gpu.ray_unit_for(header).is_some_and(RayUnit::walks);
        let stack_entries = if unit_walks { 0 } else { header.stack_entries };
        let stack_bytes =
            u64::from(stack_entries) * u64::from(STACK_ENTRY_BYTES) * u64::from(config.gpu.cores.warp_width);
        let stack_stride = stack_bytes.next_multiple_of(private_line.bytes());
        let stack_base = place(stack_stride * u64::from(warps));
        let Technique { raster, present, .. } = &config.technique;
        let vertex_stride = raster.map_or(0, |raster| raster.vertex_stride(header.normals));
        let triangle_bytes = CORNERS * u64::from(vertex_stride);
        let raster_base = place(triangle_bytes * u64::from(topology.stored_triangles()));
        let pixels = u64::from(header.frame.tiles()) * u64::from(TILE_RAYS);
        let image_bytes = pixels * PIXEL_BYTES;
        let attachments = raster.as_ref().map_or(0, |raster| raster.attachments_in_memory().len() as u64);
        let images = image_bytes * (attachments + u64::from(present.is_some()));
        let image_base = place(images);
        let mask_bytes = u64::from(config.costs.alpha(header)?.mask_bytes);
        let mask = Mask { base: place(mask_bytes), bytes: mask_bytes };
        let instanced = InstancedTriangles::new(topology);
        let micromaps = Micromaps::new(header, topology, instanced.as_ref(), &mut place);
        let sizes = BufferBytes {
            node: structure_bytes,
            primitive: vertex_records * u64::from(primitive.vertex_bytes),
            index: index_bytes,
            normal: records * u64::from(primitive.normal_bytes),
            stack: stack_stride * u64::from(warps),
            vertex: triangle_bytes * u64::from(topology.stored_triangles()),
            image: images,
            record: 0,
            mask: mask_bytes,
            micromap: micromaps.as_ref().map_or(0, Micromaps::bytes),
        };
        let end = next / VEC4_BYTES;
        if end > u64::from(u32::MAX) {
            return Err(fail(
                format!("its buffers take {next} bytes, expected less than 64 GiB"),
                "reduce the scene",
            ));
        }
        let vec4 = |bytes: u64| (bytes / VEC4_BYTES) as u32;

        let of_nodes = |(bytes, stride): (u32, u32)| reads(bytes, stride, line);
        let address = |place: Option<u64>| place.map_or(NOWHERE, |bytes| vec4(node_base + bytes));
        let (first_instance, instances) = structure.instances;
        let Instances { layout: instance, leaf_bytes, read_bytes: instance_bytes } = Instances::of(header);
        let tree = TreeBuffers {
            reads: of_nodes(structure.bytes),
            tlas_reads: of_nodes(structure.tlas_bytes),
            instance_reads: if unit_walks {
                of_nodes((instance_bytes, instance.bytes))
            } else {
                Reads::new(instance_bytes, instance.bytes, line)
            },
            instance_leaf: (leaf_bytes > 0)
                .then(|| (of_nodes((leaf_bytes, instance.bytes)), vec4(u64::from(leaf_bytes)))),
            instances: (vec4(node_base + first_instance), instances, vec4(u64::from(instance.bytes))),
            line_shift: line.log2() - VEC4_BYTES.ilog2(),
            stack_line_shift: private_line.log2(),
            stack_entries,
            nodes: structure.nodes.into_iter().map(address).collect(),
        };
        let (record_of_position, record_of_triangle) = if leaf_order {
            let of_position = if in_pairs { pair_records(topology) } else { Vec::new() };
            let mut records = vec![NOWHERE; topology.stored_triangles() as usize];
            for (position, &triangle) in (0_u32..).zip(&topology.references) {
                let record = &mut records[triangle as usize];
                let shared = of_position.get(position as usize).filter(|_| !split);
                *record = shared.map_or(position, |&shared| shared).min(*record);
            }
            (of_position, records)
        } else {
            (topology.references.clone(), Vec::new())
        };

        let TriangleRecords { vertex_bytes: stride, normal_bytes, shading } = primitive;
        let (shading_kind, shading_base, shading_stride) = if split {
            (BufferKind::Normal, normal_base, normal_bytes)
        } else {
            (BufferKind::Primitive, vertex_base, stride)
        };
        let intersection =
            if in_pairs { 0..TriangleRecords::PAIR_BYTES } else { TriangleRecords::INTERSECTION };
        Ok(Self {
            structure_bytes,
            sizes,
            vertex_stride,
            tree,
            intersection_reads: reads(intersection.len() as u32, stride, line),
            shading_reads: Reads::new(shading.len() as u32, shading_stride, line),
            shading_kind,
            stack_base_line: (stack_base >> private_line.log2()) as u32,
            stack_stride_lines: (stack_stride >> private_line.log2()) as u32,
            call_frames: 0,
            positions: references as u32,
            record_of_position,
            record_of_triangle,
            triangles: topology.triangles,
            instanced,
            intersections: Records {
                base: vec4(vertex_base + u64::from(intersection.start)),
                stride: vec4(u64::from(stride)),
            },
            shading: Records {
                base: vec4(shading_base + u64::from(shading.start)),
                stride: vec4(u64::from(shading_stride)),
            },
            index_base: index_base.map(vec4),
            mask,
            micromaps,
            vertex_base: raster_base,
            image_base,
            image_bytes,
            end: next,
        })
    }

    /// Gives each of so many warps `bytes` of stack memory beside those of its traversals. All stacks then lie behind the other buffers.
    pub(crate) fn add_call_frames(&mut self, bytes: u64, warps: u32, private_line: LineSize) {
        if bytes == 0 {
            return;
        }
        let line = private_line.bytes();
        self.call_frames = u64::from(self.stack_stride_lines) * line;
        let stride = (self.call_frames + bytes).next_multiple_of(line);
        self.stack_base_line = (self.end >> private_line.log2()) as u32;
        self.stack_stride_lines = (stride >> private_line.log2()) as u32;
        self.sizes.stack = stride * u64::from(warps);
        self.end = (self.end + self.sizes.stack).next_multiple_of(ALIGNMENT);
    }

    /// Where 16 bytes of a warp's call frames are, from where its stack begins, in bytes.
    pub(crate) fn call_frame(&self, place: u32) -> u64 {
        self.call_frames + u64::from(place) * VEC4_BYTES
    }

    /// What the cores need to know of them.
    pub(crate) fn places(&self) -> Places {
        Places {
            stack_base_line: self.stack_base_line,
            stack_stride_lines: self.stack_stride_lines,
            end: self.end,
        }
    }

    /// Whether primitives are found through an index list.
    pub(crate) fn has_index_list(&self) -> bool {
        self.index_base.is_some()
    }

    /// Address of what an intersection with the triangle at a position in the leaves reads.
    #[inline(always)]
    pub(crate) fn intersection(&self, position: u32) -> Option<u32> {
        let record = self.record(position)?;
        Some(self.intersections.base + record * self.intersections.stride)
    }

    /// Address of the attributes of the triangle at a position in the leaves.
    pub(crate) fn attributes(&self, position: u32) -> Option<u32> {
        let record = self.record(position)?;
        Some(self.shading.base + record * self.shading.stride)
    }

    /// Address in bytes of what an any-hit shader samples of the mask for the triangle at a position in the leaves.
    pub(crate) fn mask(&self, position: u32) -> u64 {
        self.mask.base + u64::from(position) * Mask::TRIANGLE_BYTES % self.mask.bytes.max(1)
    }

    #[inline(always)]
    fn record(&self, position: u32) -> Option<u32> {
        Some(if self.record_of_position.is_empty() {
            (position < self.positions).then_some(position)?
        } else {
            *self.record_of_position.get(position as usize)?
        })
    }

    /// Line of the index list that holds a position in the leaves.
    #[inline(always)]
    pub(crate) fn index_line(&self, position: u32) -> u32 {
        (self.index_base.unwrap_or(0) + position / 4) >> self.tree.line_shift
    }

    /// Which of the triangles in memory one of the scene's is: of two levels, that of its mesh.
    #[inline(always)]
    pub(crate) fn stored(&self, triangle: u32) -> u32 {
        self.instanced.as_ref().map_or(triangle, |instanced| instanced.stored(triangle))
    }

    /// Address of what shading a triangle, in file order, reads.
    #[inline(always)]
    pub(crate) fn shading(&self, triangle: u32) -> Option<u32> {
        if triangle >= self.triangles {
            return None;
        }
        let stored = self.stored(triangle);
        let record = if self.record_of_triangle.is_empty() {
            stored
        } else {
            self.record_of_triangle[stored as usize]
        };
        (record != NOWHERE).then(|| self.shading.base + record * self.shading.stride)
    }
}

#[cfg(test)]
mod tests;
