//! Lights, and which rays a scene asks for.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A light that shadow rays are sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from one point in all directions; one shadow ray per hit.
    Point {
        /// Where the light is, in world space.
        position: Vec3,
    },
}

/// Which rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RaySelection {
    /// One ray per pixel from the eye.
    #[serde(default = "yes")]
    pub primary: bool,
    /// One ray per primary hit and light.
    #[serde(default = "yes")]
    pub shadow: bool,
}

fn yes() -> bool {
    true
}

impl Default for RaySelection {
    /// Primary and shadow rays.
    fn default() -> Self {
        RaySelection { primary: true, shadow: true }
    }
}
