//! Node records, byte by byte.
//!
//! The sizes are those of Sousa et al. 2019, Table 1: 16 bytes for a kd-tree that is only descended, 48 for one that is
//! climbed, 32 for a BVH, 48 for a BVH with parent links. Their field lists are in figures that we could not read: the lists
//! here are our reconstruction, constrained by the sizes and by the alignment rules of std430. They have no grid on the GPU: its
//! cells are ours, of the smallest size that loads of 16 bytes can read.

use crate::error::Error;
use tracer::wide::NodeFormat;
use tracer::{Accel, NodeFetch, TraceHeader};

/// Records of the instances of a two-level structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instances {
    /// Their layout.
    pub(crate) layout: NodeLayout,
    /// Bytes of the leaf that names the instance, from the beginning: it is read first, and tells where the rest is. 0 without one.
    pub(crate) leaf_bytes: u32,
    /// Bytes that a traversal reads behind that.
    pub(crate) read_bytes: u32,
}

impl Instances {
    /// Those that a trace's traversal reads.
    pub(crate) fn of(header: &TraceHeader) -> Self {
        match (header.node_fetch, header.node_format) {
            (NodeFetch::Single, Some(NodeFormat::Adreno8)) => {
                Self { layout: NodeLayout::INSTANCE_ADRENO_8, leaf_bytes: 64, read_bytes: 64 }
            }
            _ => Self { layout: NodeLayout::INSTANCE, leaf_bytes: 0, read_bytes: 64 },
        }
    }
}

/// A field of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// What it holds.
    pub name: &'static str,
    /// Bytes from the start of the record.
    pub offset: u32,
    /// Its size in bytes.
    pub bytes: u32,
}

/// A node record. A fetch reads all of it, in loads of 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeLayout {
    /// Which traversals read it.
    pub name: &'static str,
    /// Bytes of a record: a multiple of 16.
    pub bytes: u32,
    /// Its fields, without gaps.
    pub fields: &'static [Field],
}

const fn field(name: &'static str, offset: u32, bytes: u32) -> Field {
    Field { name, offset, bytes }
}

impl NodeLayout {
    /// kd-tree, walked downwards: stack, restart and push-down.
    pub const KD: Self = Self::checked(
        "kd",
        16,
        &[
            field("split", 0, 4),
            field("axis, leaf flag", 4, 4),
            field("left child, or first reference", 8, 4),
            field("right child, or reference count", 12, 4),
        ],
    );
    /// kd-tree with cells and parent links: backtrack.
    pub const KD_BACKTRACK: Self = Self::checked(
        "kd backtrack",
        48,
        &[
            field("cell minimum", 0, 12),
            field("split", 12, 4),
            field("cell maximum", 16, 12),
            field("parent", 28, 4),
            field("left child", 32, 4),
            field("right child", 36, 4),
            field("axis, leaf flag, reference count", 40, 4),
            field("first reference", 44, 4),
        ],
    );
    /// BVH: stack and restart trail.
    pub const BVH: Self = Self::checked(
        "bvh",
        32,
        &[
            field("box minimum", 0, 12),
            field("left child, or first triangle", 12, 4),
            field("box maximum", 16, 12),
            field("right child, or leaf flag and triangle count", 28, 4),
        ],
    );
    /// BVH with parent links.
    pub const BVH_PARENT_LINK: Self = Self::checked(
        "bvh parent-link",
        48,
        &[
            field("box minimum", 0, 12),
            field("left child", 12, 4),
            field("box maximum", 16, 12),
            field("right child", 28, 4),
            field("parent", 32, 4),
            field("first triangle", 36, 4),
            field("triangle count", 40, 4),
            field("axis", 44, 4),
        ],
    );
    /// Wide BVH of four children, boxes in f32.
    pub const WIDE_FULL_4: Self = Self::checked(
        "wide full-4",
        128,
        &[
            field("lower planes of four children in x, y, z", 0, 48),
            field("upper planes", 48, 48),
            field("child, or first triangle", 96, 16),
            field("leaf flag, triangle count", 112, 16),
        ],
    );
    /// Wide BVH of eight children, boxes in f32.
    pub const WIDE_FULL_8: Self = Self::checked(
        "wide full-8",
        256,
        &[
            field("lower planes of eight children in x, y, z", 0, 96),
            field("upper planes", 96, 96),
            field("child, or first triangle", 192, 32),
            field("leaf flag, triangle count", 224, 32),
        ],
    );
    /// Wide BVH of eight children, boxes in 8-bit steps: Ylitie, Karras and Laine 2017, whose fields these are.
    pub const WIDE_COMPRESSED_8: Self = Self::checked(
        "wide compressed-8",
        80,
        &[
            field("origin", 0, 12),
            field("exponents", 12, 3),
            field("which children are inner", 15, 1),
            field("first inner child", 16, 4),
            field("first triangle", 20, 4),
            field("triangles and place of each child", 24, 8),
            field("lower and upper planes", 32, 48),
        ],
    );
    /// Wide BVH of eight children, boxes in 8-bit steps: Adreno 7xx, Mesa's `tu_bvh.h`, whose fields these are.
    pub const WIDE_ADRENO_8: Self = Self::checked(
        "wide adreno-8",
        64,
        &[
            field("first child", 0, 4),
            field("origin, upper halves", 4, 6),
            field("lower and upper planes", 10, 48),
            field("exponents", 58, 3),
            field("child count", 61, 1),
            field("types", 62, 2),
        ],
    );

    /// Cell of a grid. Its place follows from its number. The compact grid of Lagae & Dutré 2008 has 4 bytes per cell, and reads
    /// two of them.
    pub const GRID: Self = Self::checked(
        "grid",
        16,
        &[field("first reference", 0, 4), field("reference count", 4, 4), field("unused", 8, 8)],
    );

    /// Instance of a two-level structure: Mesa's `radv_bvh_instance_node`, 128 bytes. What a traversal needs is the first half.
    pub const INSTANCE: Self = Self::checked(
        "instance",
        128,
        &[
            field("BLAS", 0, 8),
            field("custom index, mask", 8, 4),
            field("shader binding table offset, flags", 12, 4),
            field("world to object, 3x4", 16, 48),
            field("instance id, BLAS offset", 64, 8),
            field("reserved", 72, 8),
            field("object to world, 3x4", 80, 48),
        ],
    );
    /// Instance below a TLAS of adreno-8 nodes: Mesa's `tu_leaf_node`, which holds the box and the mask for the instruction that tests nodes, and
    /// its `tu_instance_descriptor`, of which a shader needs the first half.
    pub const INSTANCE_ADRENO_8: Self = Self::checked(
        "instance adreno-8",
        192,
        &[
            field("instance id", 0, 4),
            field("box", 4, 24),
            field("mask, flags", 28, 4),
            field("reserved", 32, 28),
            field("types", 60, 4),
            field("BLAS", 64, 8),
            field("custom index", 72, 4),
            field("shader binding table offset, flags", 76, 4),
            field("world to object, 3x4", 80, 48),
            field("BLAS offset, reserved", 128, 16),
            field("object to world, 3x4", 144, 48),
        ],
    );

    /// A layout whose fields follow each other and fill whole vec4 loads.
    const fn checked(name: &'static str, bytes: u32, fields: &'static [Field]) -> Self {
        let mut end = 0;
        let mut index = 0;
        while index < fields.len() {
            assert!(fields[index].offset == end, "fields follow each other");
            end += fields[index].bytes;
            index += 1;
        }
        assert!(end == bytes && bytes.is_multiple_of(16), "fields fill whole loads");
        Self { name, bytes, fields }
    }

    /// The record that a trace's traversal reads; of two levels, that of its BLASes. A TLAS whose nodes are fetched in pairs has that of a BVH.
    ///
    /// # Errors
    /// When the trace names a traversal that no layout is known for.
    pub fn of(header: &TraceHeader) -> Result<Self, Error> {
        match (header.accel, header.traversal.as_str()) {
            (Accel::Bvh, "stack" | "restart-trail") => Ok(Self::BVH),
            (Accel::TwoLevel, "stack") if header.node_format.is_none() => Ok(Self::BVH),
            (Accel::Bvh, "parent-link") => Ok(Self::BVH_PARENT_LINK),
            (Accel::WideBvh | Accel::TwoLevel, "stack" | "short-stack") => match header.node_format {
                Some(NodeFormat::Full4) => Ok(Self::WIDE_FULL_4),
                Some(NodeFormat::Full8) => Ok(Self::WIDE_FULL_8),
                Some(NodeFormat::Compressed8 | NodeFormat::Compressed8Pairs) => Ok(Self::WIDE_COMPRESSED_8),
                Some(NodeFormat::Adreno8) => Ok(Self::WIDE_ADRENO_8),
                None => Err(Error::Trace {
                    scene: header.scene.clone(),
                    problem: "its header does not say what the nodes of its wide BVH hold".to_owned(),
                    remedy: "give it a node_format, see docs/trace-format.md".to_owned(),
                }),
            },
            (Accel::Kd, "stack" | "restart" | "push-down") => Ok(Self::KD),
            (Accel::Kd, "backtrack") => Ok(Self::KD_BACKTRACK),
            (Accel::Grid, "dda") => Ok(Self::GRID),
            (accel, other) => Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!("its {} traversal '{other}' has no node layout", accel.name()),
                remedy: "expected bvh stack, parent-link or restart-trail, wide-bvh stack or short-stack, kd stack, restart, push-down or backtrack, grid dda, or two-level stack or short-stack"
                    .to_owned(),
            }),
        }
    }
}
