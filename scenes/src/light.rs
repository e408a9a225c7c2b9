//! Lights.

use glam::Vec3;

/// A light that shadow rays are sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from one point in all directions; one shadow ray per hit.
    Point {
        /// Where the light is, in world space.
        position: Vec3,
    },
}
