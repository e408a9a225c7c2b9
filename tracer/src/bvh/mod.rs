//! Binary bounding volume hierarchies: the tree, its builder and its traversals.

pub(crate) mod leaf;
pub mod parent_link;
pub mod restart_trail;
pub mod stack;
mod sweep;
mod tree;

pub(crate) use tree::NodeRef;

pub use sweep::BvhOptions;
pub(crate) use sweep::MAX_TRIANGLES;
pub use tree::{Bvh, BvhNode, BvhNodeKind, BvhStatistics};
