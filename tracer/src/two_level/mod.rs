//! Two-level acceleration structures, as ray-tracing APIs have them: a BVH per mesh (BLAS) in the mesh's own space, and a BVH over
//! the world boxes of the instances of the meshes (TLAS). Nodes of both are of one kind, binary or of a format of wide nodes.
//!
//! # Numbering
//! Ids of nodes are unique over the whole structure: the TLAS has `0..n`, each BLAS begins at the next even id after what is before
//! it, in the order of the meshes. So every root has an even id and the left node of every binary pair an odd one. Positions of references
//! are unique over the BLASes, which begin at 0 with the first mesh; the references of the TLAS are a list of their own, of numbers
//! of instances. A hit names a triangle of the flattened scene: instance after instance, each in file order, as
//! [`scenes::Scene::triangles`] lists them.

mod advice;
mod bottom_level;
mod empty_space;
mod overlap;
mod sampling;
mod short_stack;
mod stack;
mod statistics;
mod structure;
mod tlas;
mod topology;
mod transform;

pub use advice::SMALL_BLAS_TRIANGLES;
pub use bottom_level::BottomLevel;
pub use statistics::{BlasStatistics, TwoLevelStatistics};
pub use structure::{MaskedInstance, TwoLevel};
pub use topology::{BlasPlace, Levels};
