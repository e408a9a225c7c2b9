//! Triangle records: three vertices and three vertex normals, in the three layouts of Sousa et al. 2019, section 3.1.
//!
//! | layout | record, `p` is padding to 16 bytes | bytes | an intersection reads | shading reads |
//! |---|---|---|---|---|
//! | padded | `v0 p v1 p v2 p n0 p n1 p n2 p` | 96 | bytes 0 to 48 | bytes 48 to 96 |
//! | compact | `v0 n0.x v1 n0.y v2 n0.z n1 p n2 p` | 80 | bytes 0 to 48 | bytes 0 to 80 |
//! | split | `v0 p v1 p v2 p`, and in a second buffer `n0 p n1 p n2 p` | 48 + 48 | the first | the second |
//!
//! Where normals are left out, all three are `v0 p v1 p v2 p`, 48 bytes, which both read.
//!
//! Where triangles of a leaf that share an edge are in pairs, a pair or a triangle alone has a record of 64 bytes, and normals are apart.
//!
//! That a triangle has three normals of its own is our reading of "the first normal is stored in the paddings".

use std::ops::Range;

/// How vertices and normals of a triangle lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PrimitiveLayout {
    /// One record, every vector padded to 16 bytes.
    #[default]
    Padded,
    /// One record, the first normal in the padding of the vertices.
    Compact,
    /// Vertices and normals in buffers of their own.
    Split,
}

impl PrimitiveLayout {
    /// All layouts.
    pub const ALL: [Self; 3] = [Self::Padded, Self::Compact, Self::Split];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Padded => "padded",
            Self::Compact => "compact",
            Self::Split => "split",
        }
    }

    /// The layout of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layout| layout.name() == name)
    }

    /// Its records.
    pub fn records(self) -> TriangleRecords {
        match self {
            Self::Padded => TriangleRecords { vertex_bytes: 96, normal_bytes: 0, shading: 48..96 },
            Self::Compact => TriangleRecords { vertex_bytes: 80, normal_bytes: 0, shading: 0..80 },
            Self::Split => TriangleRecords { vertex_bytes: 48, normal_bytes: 48, shading: 0..48 },
        }
    }
}

/// The records of a triangle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TriangleRecords {
    /// Bytes of its record in the buffer that intersections read.
    pub vertex_bytes: u32,
    /// Bytes of its record in the second buffer; 0 without one.
    pub normal_bytes: u32,
    /// Bytes that shading reads: of the second buffer where there is one.
    pub shading: Range<u32>,
}

impl TriangleRecords {
    /// Of triangles without normals, in any layout: `v0 p v1 p v2 p`. Shading makes the flat normal from the vertices.
    pub const WITHOUT_NORMALS: Self = Self { vertex_bytes: 48, normal_bytes: 0, shading: Self::INTERSECTION };

    /// Bytes of the first record that an intersection reads.
    pub const INTERSECTION: Range<u32> = 0..48;

    /// Bytes of a record of a pair of triangles, all of which an intersection reads: `v0 p v1 p v2 p v3 p`, and in the paddings which corners and
    /// numbers its triangles have. A triangle without a partner has a record of its own. AMD's GPURT has as many bytes for as much.
    pub const PAIR_BYTES: u32 = 64;

    /// Of a frame's triangles: in pairs or each by itself, with normals or without. Normals of pairs are in a buffer of their own, whatever
    /// the layout, since the triangles of a pair may have different ones where they meet.
    pub(crate) fn of(layout: PrimitiveLayout, in_pairs: bool, with_normals: bool) -> Self {
        match (in_pairs, with_normals) {
            (false, true) => layout.records(),
            (false, false) => Self::WITHOUT_NORMALS,
            (true, true) => Self { vertex_bytes: Self::PAIR_BYTES, ..PrimitiveLayout::Split.records() },
            (true, false) => {
                Self { vertex_bytes: Self::PAIR_BYTES, normal_bytes: 0, shading: 0..Self::PAIR_BYTES }
            }
        }
    }

    /// Bytes of both records.
    pub fn bytes(&self) -> u32 {
        self.vertex_bytes + self.normal_bytes
    }
}
