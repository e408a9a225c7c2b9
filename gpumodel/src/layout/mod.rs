//! Where things lie in memory: the only place of the project where a node number becomes an address.

mod alpha;
mod buffers;
mod instanced;
mod node;
mod order;
mod primitive;
mod reads;
mod records;
mod tree;

pub use buffers::BufferBytes;
pub(crate) use buffers::{
    BufferKind, Buffers, CORNERS, PIXEL_BYTES, Places, STACK_ENTRY_BYTES, in_pairs, normal_bytes,
};
pub(crate) use node::Instances;
pub use node::{Field, NodeLayout};
pub use order::NodeOrder;
pub use primitive::{PrimitiveLayout, TriangleRecords};
pub(crate) use reads::Reads;
pub use records::{NodeRecords, PrimitiveOrder};

/// Bytes of the widest load of one lane, four 32-bit words: records are read in these, and addresses count them.
pub(crate) const VEC4_BYTES: u64 = 16;
