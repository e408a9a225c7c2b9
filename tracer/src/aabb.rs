//! Axis-aligned boxes and the slab test of Williams et al. 2005.

use crate::ray::Ray;
use glam::Vec3;

/// An axis-aligned box; empty when any `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing and leaves every union unchanged.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box of three points.
    pub fn of_triangle(triangle: &scenes::Triangle) -> Self {
        let [a, b, c] = triangle.v;
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// The smallest box around both.
    #[inline(always)]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Edge lengths; negative where the box is empty.
    #[inline(always)]
    pub fn extent(self) -> Vec3 {
        self.max - self.min
    }

    /// Half the surface area, `dx dy + dy dz + dz dx`, in f64 so that extents up to `f32::MAX` do not overflow.
    /// 0 for an empty box.
    #[inline]
    pub fn half_area(self) -> f64 {
        let d = self.extent().as_dvec3();
        if d.min_element() < 0.0 { 0.0 } else { d.x * d.y + d.y * d.z + d.z * d.x }
    }
}

/// A ray with what the slab test needs once per ray.
///
/// Zero direction components become infinities of the same sign, as in IEEE division; the test below is written for that.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// Origin of the ray.
    pub origin: Vec3,
    /// Componentwise reciprocal of the direction.
    pub inverse: Vec3,
    /// Per axis, whether the reciprocal is negative, so that the upper plane is the nearer one.
    pub negative: [bool; 3],
}

/// Far distances are widened by 2 ulp, so that rounding cannot make the test miss a box that the exact ray touches
/// (Ize 2013, "Robust BVH Ray Traversal").
pub const FAR_WIDENING: f32 = 1.000_000_24;

impl SlabRay {
    /// Prepares a ray.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let inverse = ray.direction.recip();
        Self {
            origin: ray.origin,
            inverse,
            negative: [
                inverse.x.is_sign_negative(),
                inverse.y.is_sign_negative(),
                inverse.z.is_sign_negative(),
            ],
        }
    }

    /// Entry and exit distance of a box, clipped to `[t_min, t_max]`; the box is hit where entry <= exit.
    ///
    /// A NaN (origin on a slab plane, direction parallel to it: `0 * inf`) constrains nothing, on either plane alike: every
    /// comparison keeps the older bound when the new one is NaN.
    #[inline(always)]
    pub fn entry_exit(&self, min: Vec3, max: Vec3, t_min: f32, t_max: f32) -> (f32, f32) {
        let mut near = t_min;
        let mut far = t_max;
        let axes = [
            (min.x, max.x, self.origin.x, self.inverse.x, self.negative[0]),
            (min.y, max.y, self.origin.y, self.inverse.y, self.negative[1]),
            (min.z, max.z, self.origin.z, self.inverse.z, self.negative[2]),
        ];
        for (lo, hi, origin, inverse, negative) in axes {
            let (first, second) = if negative { (hi, lo) } else { (lo, hi) };
            let t0 = (first - origin) * inverse;
            let t1 = (second - origin) * inverse;
            near = if t0 > near { t0 } else { near };
            far = if t1 < far { t1 } else { far };
        }
        (near, far * FAR_WIDENING)
    }
}
