//! Triangle records: three vertices and three vertex normals, in the three layouts of Sousa et al. 2019, section 3.1.
//!
//! | layout | record, `p` is padding to 16 bytes | bytes | an intersection reads | shading reads |
//! |---|---|---|---|---|
//! | padded | `v0 p v1 p v2 p n0 p n1 p n2 p` | 96 | bytes 0 to 48 | bytes 48 to 96 |
//! | compact | `v0 n0.x v1 n0.y v2 n0.z n1 p n2 p` | 80 | bytes 0 to 48 | bytes 0 to 80 |
//! | split | `v0 p v1 p v2 p`, and in a second buffer `n0 p n1 p n2 p` | 48 + 48 | the first | the second |
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

    /// Bytes of a record in the buffer that intersections read.
    pub fn vertex_record_bytes(self) -> u32 {
        match self {
            Self::Padded => 96,
            Self::Compact => 80,
            Self::Split => 48,
        }
    }

    /// Bytes of a record in the second buffer; 0 without one.
    pub fn normal_record_bytes(self) -> u32 {
        match self {
            Self::Padded | Self::Compact => 0,
            Self::Split => 48,
        }
    }

    /// Bytes of its record that an intersection reads.
    pub fn intersection_bytes(self) -> Range<u32> {
        0..48
    }

    /// Bytes of its record that shading reads: of the second buffer where there is one.
    pub fn shading_bytes(self) -> Range<u32> {
        match self {
            Self::Padded => 48..96,
            Self::Compact => 0..80,
            Self::Split => 0..48,
        }
    }
}
