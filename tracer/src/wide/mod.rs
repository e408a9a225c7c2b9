//! Wide bounding volume hierarchies: nodes of four or eight children, in the formats that ray-tracing hardware and shaders read.

mod collapse;
mod format;
mod pairs;
mod quantise;
pub mod short_stack;
pub mod stack;
mod tree;

pub use format::{NodeFormat, Origin};
pub use quantise::Grid;
pub(crate) use tree::WideNodes;
pub use tree::{WideBvh, WideStatistics};
