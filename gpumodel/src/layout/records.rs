//! What-ifs on how node records and triangles lie in memory.

use super::node::NodeLayout;
use crate::error::Error;
use tracer::{Accel, NodeFetch, TraceHeader};

/// What a node record holds and how far records lie apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeRecords {
    /// As Sousa et al. 2019 have it: 16, 32 or 48 bytes without gaps ([`NodeLayout`]).
    #[default]
    Packed,
    /// The same records, each padded to the next power of two bytes, so that none straddles two lines.
    Padded,
    /// An inner node holds the boxes of both children in 64 bytes (Aila and Laine 2009): one record per step instead of two, none for a
    /// leaf, and none for the root, whose box is a constant. Only for traversals that test siblings together.
    ChildBoxes,
}

/// Bytes of a record with the boxes of both children: 2 x (minimum 12, maximum 12, link 4, triangle count 4).
pub(crate) const CHILD_BOXES_BYTES: u32 = 64;

impl NodeRecords {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Packed, Self::Padded, Self::ChildBoxes];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packed => "packed",
            Self::Padded => "padded",
            Self::ChildBoxes => "child-boxes",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|records| records.name() == name)
    }

    /// Bytes that a fetch reads, and bytes from record to record.
    ///
    /// # Errors
    /// When the traversal does not test siblings together and yet their boxes are to be in one record.
    pub(crate) fn bytes(self, header: &TraceHeader, layout: &NodeLayout) -> Result<(u32, u32), Error> {
        match self {
            Self::Packed => Ok((layout.bytes, layout.bytes)),
            Self::Padded => Ok((layout.bytes, layout.bytes.next_power_of_two())),
            Self::ChildBoxes if header.accel == Accel::TwoLevel => Err(Error::Trace {
                scene: header.scene.clone(),
                problem: "it has two levels, and with the boxes of children in their parent the box of a BLAS's root is in no record"
                    .to_owned(),
                remedy: "use packed or padded node records, or a trace of bvh stack or restart-trail"
                    .to_owned(),
            }),
            Self::ChildBoxes if header.node_fetch == NodeFetch::Pair => {
                Ok((CHILD_BOXES_BYTES, CHILD_BOXES_BYTES))
            }
            Self::ChildBoxes => Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!(
                    "its {} traversal '{}' does not fetch siblings in pairs: there are no two to put into one record",
                    header.accel.name(),
                    header.traversal
                ),
                remedy: "use packed or padded node records, or a trace of bvh stack or restart-trail"
                    .to_owned(),
            }),
        }
    }
}

/// Where the triangle at a position in the leaves lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PrimitiveOrder {
    /// Triangles lie in the order of the leaves, one record per reference: those of a leaf are neighbours, and a triangle in
    /// several leaves has several records.
    Leaf,
    /// Triangles lie in file order, one record each, found through a list of 4-byte indices in the order of the leaves.
    Indexed,
}

impl PrimitiveOrder {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Leaf, Self::Indexed];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Leaf => "leaf",
            Self::Indexed => "indexed",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|order| order.name() == name)
    }

    /// What a structure uses unless told otherwise: a BVH, whose leaves share no triangle, keeps triangles in the order of its leaves;
    /// structures that divide space use an index list.
    pub fn of(accel: Accel) -> Self {
        match accel {
            Accel::Bvh | Accel::WideBvh | Accel::TwoLevel => Self::Leaf,
            _ => Self::Indexed,
        }
    }
}
