//! Node records, byte by byte.
//!
//! The sizes are those of Sousa et al. 2019, Table 1: 16 bytes for a kd-tree that is only descended, 48 for one that is
//! climbed, 32 for a BVH, 48 for a BVH with parent links. Their field lists are in figures that we could not read: the lists
//! here are our reconstruction, constrained by the sizes and by the alignment rules of std430. They have no grid on the GPU: its
//! cells are ours, of the smallest size that loads of 16 bytes can read.

use crate::error::Error;
use tracer::{Accel, TraceHeader};

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

    /// Cell of a grid. Its place follows from its number. The compact grid of Lagae & Dutré 2008 has 4 bytes per cell, and reads
    /// two of them.
    pub const GRID: Self = Self::checked(
        "grid",
        16,
        &[field("first reference", 0, 4), field("reference count", 4, 4), field("unused", 8, 8)],
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

    /// The record that a trace's traversal reads.
    ///
    /// # Errors
    /// When the trace names a traversal that no layout is known for.
    pub fn of(header: &TraceHeader) -> Result<Self, Error> {
        match (header.accel, header.traversal.as_str()) {
            (Accel::Bvh, "stack" | "restart-trail") => Ok(Self::BVH),
            (Accel::Bvh, "parent-link") => Ok(Self::BVH_PARENT_LINK),
            (Accel::Kd, "stack" | "restart" | "push-down") => Ok(Self::KD),
            (Accel::Kd, "backtrack") => Ok(Self::KD_BACKTRACK),
            (Accel::Grid, "dda") => Ok(Self::GRID),
            (accel, other) => Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!("its {} traversal '{other}' has no node layout", accel.name()),
                remedy: "expected bvh stack, parent-link or restart-trail, kd stack, restart, push-down or backtrack, or grid dda"
                    .to_owned(),
            }),
        }
    }
}
