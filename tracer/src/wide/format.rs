//! What a wide node's record can hold, as far as it decides which nodes a ray visits. Its bytes are the replay's business.

use serde::{Deserialize, Serialize};

/// A format of wide nodes. Trace files had its names without hyphens before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum NodeFormat {
    /// Four children, their boxes in f32.
    #[serde(rename = "full-4", alias = "full4")]
    Full4,
    /// Eight children, their boxes in f32.
    #[serde(rename = "full-8", alias = "full8")]
    Full8,
    /// Eight children, their boxes in 8-bit steps from an origin in f32; at most three triangles in a leaf (Ylitie, Karras and Laine
    /// 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs").
    #[serde(rename = "compressed-8", alias = "compressed8")]
    Compressed8,
    /// As [`Self::Compressed8`], whose tree it has; triangles of a leaf that share an edge are in one record.
    #[serde(rename = "compressed-8-pairs")]
    Compressed8Pairs,
    /// Eight children, their boxes in 8-bit steps from an origin in the upper half of an f32; one triangle in a leaf (Adreno 7xx,
    /// Mesa's `tu_bvh.h`).
    #[serde(rename = "adreno-8", alias = "adreno8")]
    Adreno8,
}

/// How the origin of the steps of quantised boxes is stored, per axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// As an f32.
    Single,
    /// As the upper 16 bits of an f32.
    UpperHalf,
}

impl NodeFormat {
    /// All formats.
    pub const ALL: [Self; 5] =
        [Self::Full4, Self::Full8, Self::Compressed8, Self::Compressed8Pairs, Self::Adreno8];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full4 => "full-4",
            Self::Full8 => "full-8",
            Self::Compressed8 => "compressed-8",
            Self::Compressed8Pairs => "compressed-8-pairs",
            Self::Adreno8 => "adreno-8",
        }
    }

    /// The format of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Most children of a node.
    pub fn width(self) -> u32 {
        match self {
            Self::Full4 => 4,
            Self::Full8 | Self::Compressed8 | Self::Compressed8Pairs | Self::Adreno8 => 8,
        }
    }

    /// Most triangles that a child which is a leaf may have; `None` where its record does not limit them.
    pub fn leaf_triangles(self) -> Option<u32> {
        match self {
            Self::Full4 | Self::Full8 => None,
            Self::Compressed8 | Self::Compressed8Pairs => Some(3),
            Self::Adreno8 => Some(1),
        }
    }

    /// Whether triangles of a leaf that share an edge are in one record.
    pub fn has_pairs(self) -> bool {
        self == Self::Compressed8Pairs
    }

    /// How the origin of quantised boxes is stored; `None` where boxes are not quantised.
    pub fn origin(self) -> Option<Origin> {
        match self {
            Self::Full4 | Self::Full8 => None,
            Self::Compressed8 | Self::Compressed8Pairs => Some(Origin::Single),
            Self::Adreno8 => Some(Origin::UpperHalf),
        }
    }
}
