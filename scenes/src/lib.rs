//! Scenes for ray-tracing cost models: meshes, cameras, lights, loading, seeded generators.
//!
//! [`load`] takes a built-in name or a path and returns a [`Scene`] that is ready to trace: finite coordinates, indices
//! in range, a valid camera, at least one light. What the file did not say is in [`Scene::notes`]; what it asks for
//! beyond bare triangles is in [`Scene::needs`]. The crate knows no acceleration structure and never prints.

mod builtin;
mod camera;
mod error;
mod geometry;
pub mod gltf;
mod known_cameras;
mod light;
mod load;
mod material;
pub mod mtl;
mod needs;
pub mod obj;
mod rays;
mod scene;
pub mod scene_file;

pub use builtin::{BUILTINS, Builtin, builtin, sin_cos};
pub use camera::Camera;
pub use error::Error;
pub use geometry::{Aabb, Instance, Mesh, Normals, Triangle};
pub use glam::{Affine3A, Vec3};
pub use light::Light;
pub use load::{FREE_EXPANSION, Geometry, MAX_EXPANSION, MAX_FILE_BYTES, load};
pub use material::{Material, Reflection};
pub use needs::{Feature, LeftOut, Needs};
pub use rays::{Gloss, RaySelection, RoughnessGates, SAMPLES, is_radius};
pub use scene::{Note, Scene};

/// Most triangles a scene may have after all instances are applied; a loader refuses more.
pub const MAX_TRIANGLES: usize = 1 << 25;
/// Most vertices, and most normals, that one mesh may have; a loader refuses more.
pub const MAX_VERTICES: usize = 1 << 25;
