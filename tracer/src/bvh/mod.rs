//! Binary bounding volume hierarchies: the tree, its builder and its traversals.

pub(crate) mod leaf;
mod pair_tree;
pub mod parent_link;
mod refit;
pub mod restart_trail;
pub mod stack;
mod sweep;
mod tree;

pub(crate) use pair_tree::PairTree;
pub use refit::Refit;
pub use sweep::BvhOptions;
pub(crate) use sweep::{MAX_TRIANGLES, Swept, sweep};
pub use tree::{Bvh, BvhNode, BvhNodeKind, BvhStatistics};
pub(crate) use tree::{NodePair, NodeRef};
