//! kd-trees: the tree, its builder and its traversals.
//!
//! The builder is that of Wald & Havran 2006: one sort, then event lists that stay sorted while they are divided. The
//! traversals visit the same cells in the same order and differ in how they find the next one: from a stack ([`stack`]), by
//! starting again ([`restart`], [`push_down`]) or by climbing ([`backtrack`]). What decides whether a ray meets a cell is in one
//! place, `descent.rs`.

pub mod backtrack;
mod build;
mod cells;
mod clip;
mod descent;
mod events;
mod options;
mod partition;
pub mod push_down;
pub mod restart;
pub mod stack;
mod statistics;
mod sweep;
mod tree;
mod validate;

pub use cells::KdCells;
pub use options::{FlatCells, KdOptions, Splits};
pub use push_down::MAX_SHORT_STACK;
pub use statistics::KdStatistics;
pub use tree::{KdNode, KdNodeKind, KdTree};
pub use validate::KdDefect;
