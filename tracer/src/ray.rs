//! Rays and hits, in f32 as a GPU has them.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A ray segment `origin + t * direction`, `t` in `[t_min, t_max]`.
///
/// The direction need not have unit length; `t` is in units of its length. Any field may be NaN or infinite:
/// a traversal then ends within its loop bound and reports whatever the comparisons of IEEE 754 give.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Start of the ray, world space.
    pub origin: Vec3,
    /// Smallest accepted parameter.
    pub t_min: f32,
    /// Direction, any non-zero length.
    pub direction: Vec3,
    /// Largest accepted parameter.
    pub t_max: f32,
}

impl Ray {
    /// A ray over `[0, f32::INFINITY]`.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }
}

/// What a query asks of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Query {
    /// The nearest hit in `[t_min, t_max]`.
    #[serde(rename = "closest-hit")]
    Closest,
    /// Whether there is any hit in `[t_min, t_max]`: the first one found ends the traversal.
    #[serde(rename = "any-hit")]
    Any,
}

impl Query {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Any, Self::Closest];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closest => "closest-hit",
            Self::Any => "any-hit",
        }
    }

    /// The query of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|query| query.name() == name)
    }
}

/// The primitive id of a miss.
pub const NO_HIT: u32 = u32::MAX;

/// In a [`RaySet`](crate::RaySet), the primitive id of a ray that its pixel did not cast although the ray that it would start from hit.
pub const NOT_CAST: u32 = u32::MAX - 1;

/// The answer of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter of the hit; the ray's `t_max` on a miss.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex.
    pub v: f32,
    /// Triangle index in file order, or [`NO_HIT`].
    pub primitive: u32,
}

impl Hit {
    /// No hit up to `t_max`.
    pub fn miss(t_max: f32) -> Self {
        Self { t: t_max, u: 0.0, v: 0.0, primitive: NO_HIT }
    }

    /// Whether a triangle was hit.
    pub fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }
}
