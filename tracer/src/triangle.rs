//! Ray-triangle intersection by Moller & Trumbore 1997, without an absolute epsilon.

use crate::ray::Ray;
use glam::Vec3;
use scenes::Triangle;

/// A triangle prepared for the test: a vertex and two edges, each edge rounded once to f32 exactly as the test itself would.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PreparedTriangle {
    v0: Vec3,
    e1: Vec3,
    e2: Vec3,
}

impl From<&Triangle> for PreparedTriangle {
    fn from(triangle: &Triangle) -> Self {
        let [v0, v1, v2] = triangle.v;
        Self { v0, e1: v1 - v0, e2: v2 - v0 }
    }
}

impl PreparedTriangle {
    /// Tests the triangle over `[ray.t_min, t_max]`; returns `(t, u, v)` of a hit.
    ///
    /// Only `det == 0` (and NaN) is rejected as parallel: an absolute threshold on the determinant is a threshold on the
    /// triangle's size and drops every hit of a small mesh.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        let p = ray.direction.cross(self.e2);
        let det = self.e1.dot(p);
        let inv_det = 1.0 / det;
        let s = ray.origin - self.v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(self.e1);
        let v = ray.direction.dot(q) * inv_det;
        let t = self.e2.dot(q) * inv_det;
        // `&` instead of `&&`: one well-predicted branch in place of five.
        let inside =
            (det != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t >= ray.t_min) & (t <= t_max);
        inside.then_some((t, u, v))
    }
}
