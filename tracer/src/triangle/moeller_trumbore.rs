//! Ray-triangle intersection by Moller & Trumbore 1997, without an absolute epsilon.

use super::{GROUP, GroupHits, RayTriangle, TriangleGroup};
use crate::ray::Ray;
use glam::{Vec3, Vec4};
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

impl RayTriangle for PreparedTriangle {
    type Ray<'a> = &'a Ray;
    type Group = MoellerTrumboreGroup;

    #[inline(always)]
    fn prepare(ray: &Ray) -> &Ray {
        ray
    }

    #[inline(always)]
    fn test(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        self.intersect(ray, t_max)
    }
}

/// Up to [`GROUP`] consecutive triangles of a reference list, coordinate by coordinate, so that one vector operation serves all.
///
/// Lanes without a triangle hold a point, which no ray hits: its determinant is zero or NaN, and a NaN is never inside.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MoellerTrumboreGroup {
    v0: [Vec4; 3],
    e1: [Vec4; 3],
    e2: [Vec4; 3],
    first: u32,
}

#[inline(always)]
fn cross(a: [Vec4; 3], b: [Vec4; 3]) -> [Vec4; 3] {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

#[inline(always)]
fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl TriangleGroup<PreparedTriangle> for MoellerTrumboreGroup {
    fn new(first: u32, triangles: &[PreparedTriangle]) -> Self {
        debug_assert!(triangles.len() <= GROUP);
        let pack = |corner: fn(&PreparedTriangle) -> Vec3| {
            std::array::from_fn(|axis| {
                let lane = |lane| triangles.get(lane).map_or(0.0, |triangle| corner(triangle)[axis]);
                Vec4::from_array(std::array::from_fn(lane))
            })
        };
        Self {
            v0: pack(|triangle| triangle.v0),
            e1: pack(|triangle| triangle.e1),
            e2: pack(|triangle| triangle.e2),
            first,
        }
    }

    #[inline(always)]
    fn first(&self) -> u32 {
        self.first
    }

    /// [`PreparedTriangle::intersect`] of all lanes, bit for bit: the same operations in the same order.
    #[inline(always)]
    fn intersect(&self, ray: &Ray, t_max: f32) -> GroupHits {
        let splat = |v: Vec3| v.to_array().map(Vec4::splat);
        let (origin, direction) = (splat(ray.origin), splat(ray.direction));
        let p = cross(direction, self.e2);
        let det = dot(self.e1, p);
        let inv_det = Vec4::ONE / det;
        let s: [Vec4; 3] = std::array::from_fn(|axis| origin[axis] - self.v0[axis]);
        let u = dot(s, p) * inv_det;
        let q = cross(s, self.e1);
        let v = dot(direction, q) * inv_det;
        let t = dot(self.e2, q) * inv_det;
        let inside = det.cmpne(Vec4::ZERO)
            & u.cmpge(Vec4::ZERO)
            & v.cmpge(Vec4::ZERO)
            & (u + v).cmple(Vec4::ONE)
            & t.cmpge(Vec4::splat(ray.t_min))
            & t.cmple(Vec4::splat(t_max));
        GroupHits { t, u, v, lanes: inside.bitmask() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_gives_the_bits_of_each_of_its_triangles() {
        let values = [0.0, -0.0, 1.0, -1.0, 0.3, 0.5, 2.0, -0.7, 1e30, -1e-30, f32::INFINITY, f32::NAN];
        let mut state = 1_u32;
        let mut next = |limit: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as usize % limit
        };
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..100_000 {
            let kinds = if next(4) == 0 { values.len() } else { 8 };
            let mut point = || Vec3::new(values[next(kinds)], values[next(kinds)], values[next(kinds)]);
            let ray = Ray { origin: point(), t_min: 0.0, direction: point(), t_max: 10.0 };
            let all: [PreparedTriangle; GROUP] =
                std::array::from_fn(|_| PreparedTriangle::from(&Triangle { v: [point(), point(), point()] }));
            let filled = &all[..1 + next(GROUP)];
            let found = MoellerTrumboreGroup::new(0, filled).intersect(&ray, ray.t_max);
            for lane in 0..GROUP {
                let expected = filled.get(lane).and_then(|triangle| triangle.intersect(&ray, ray.t_max));
                let hit = (found.lanes >> lane & 1 == 1).then(|| found.of_lane(lane));
                let bits = |hit: Option<(f32, f32, f32)>| hit.map(|(t, u, v)| [t, u, v].map(f32::to_bits));
                assert_eq!(bits(hit), bits(expected), "{ray:?} {filled:?}");
                hits += u32::from(hit.is_some());
                misses += u32::from(hit.is_none());
            }
        }
        assert!(hits > 1000 && misses > 1000, "{hits} hits and {misses} misses: both have to occur");
    }
}
