//! kd-trees: the tree, its builder and its traversals.

mod tree;

pub use tree::{KdNode, KdNodeKind, KdTree};
