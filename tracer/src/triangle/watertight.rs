//! Watertight ray-triangle intersection (Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013).
//!
//! The triangle is moved to the ray's origin and sheared so that the ray runs along an axis. What is left is whether the origin lies
//! in a plane triangle: three edge functions of two vertices each. A vertex is moved and sheared alike in each triangle that has it,
//! and the edge function of an edge changes its sign, and nothing else, with the direction of the edge. So a ray
//! cannot pass between two triangles that share an edge. Where an edge function is 0 the paper computes all three again in f64, where
//! products of f32 are exact; here that is also done where one of them underflows or overflows, so that the test holds at any
//! scale that f32 coordinates have. Distances are weighted means of the vertices', for the same reason.

use super::{GROUP, GroupHits, RayTriangle, TriangleGroup};
use crate::ray::Ray;
use glam::{Vec3, Vec4};
use scenes::Triangle;

/// A triangle as the watertight test takes it: its vertices, since edges rounded on their own would not meet. One without area
/// is NaN, which no ray hits: moved and sheared it would have some.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct WatertightTriangle {
    v: [Vec3; 3],
}

impl From<&Triangle> for WatertightTriangle {
    fn from(triangle: &Triangle) -> Self {
        Self { v: if triangle.is_degenerate() { [Vec3::NAN; 3] } else { triangle.v } }
    }
}

/// A ray with its shear.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    origin: Vec3,
    t_min: f32,
    /// The axes of the plane, then the one along which the direction is longest. Swapped where the direction is negative, so that
    /// triangles keep their winding.
    axes: [usize; 3],
    /// Direction along the first two axes over that along the third.
    shear: [f32; 2],
    /// Direction along the third axis; NaN, with which nothing is hit, unless the direction is finite.
    forward: f32,
}

impl WatertightTriangle {
    /// Tests the triangle over `[ray.t_min, t_max]`; returns `(t, u, v)` of a hit.
    ///
    /// Only a determinant of 0 (and NaN) is rejected as parallel.
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32, f32)> {
        self.test(Self::prepare(ray), t_max)
    }
}

impl RayTriangle for WatertightTriangle {
    type Ray<'a> = ShearedRay;
    type Group = WatertightGroup;

    #[inline]
    fn prepare(ray: &Ray) -> ShearedRay {
        let z = ray.direction.abs().max_position();
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let forward = ray.direction[z];
        let [x, y] = if forward < 0.0 { [y, x] } else { [x, y] };
        let shear = [ray.direction[x] / forward, ray.direction[y] / forward];
        let forward = if ray.direction.is_finite() { forward } else { f32::NAN };
        ShearedRay { origin: ray.origin, t_min: ray.t_min, axes: [x, y, z], shear, forward }
    }

    #[inline(always)]
    fn test(&self, ray: ShearedRay, t_max: f32) -> Option<(f32, f32, f32)> {
        let [x, y, z] = ray.axes;
        let moved = self.v.map(|vertex| vertex - ray.origin);
        let [a, b, c] = moved.map(|v| [v[x] - ray.shear[0] * v[z], v[y] - ray.shear[1] * v[z]]);
        let edges = [edge(c, b), edge(a, c), edge(b, a)];
        let sum: f32 = edges.iter().sum();
        let weights = if edges.iter().all(|edge| edge.is_normal()) && sum.is_normal() {
            barycentrics(edges)?
        } else {
            let [a, b, c] = [a, b, c].map(|[x, y]| [f64::from(x), f64::from(y)]);
            barycentrics([edge(c, b), edge(a, c), edge(b, a)])?.map(|weight| weight as f32)
        };
        let [at_a, at_b, at_c] = moved.map(|v| v[z] / ray.forward);
        let t = weights[0] * at_a + weights[1] * at_b + weights[2] * at_c;
        ((t >= ray.t_min) & (t <= t_max)).then_some((t, weights[1], weights[2]))
    }
}

/// Twice the area of the triangle of the origin, `q` and `p`.
#[inline(always)]
fn edge<T: std::ops::Mul<Output = T> + std::ops::Sub<Output = T> + Copy>(p: [T; 2], q: [T; 2]) -> T {
    p[0] * q[1] - p[1] * q[0]
}

/// Shares of the edge functions in their sum: the weights of the vertices. `None` where the signs differ or the sum is 0.
#[inline(always)]
fn barycentrics<T>([u, v, w]: [T; 3]) -> Option<[T; 3]>
where
    T: std::ops::Add<Output = T> + std::ops::Div<Output = T> + PartialOrd + Default + Copy,
{
    let zero = T::default();
    let inside = ((u >= zero) & (v >= zero) & (w >= zero)) | ((u <= zero) & (v <= zero) & (w <= zero));
    let sum = u + v + w;
    (inside && sum != zero).then(|| [u / sum, v / sum, w / sum])
}

/// Up to [`GROUP`] triangles, tested one after the other.
#[derive(Clone, Copy, Debug)]
pub struct WatertightGroup {
    /// Lanes without a triangle hold a point, which no ray hits.
    triangles: [WatertightTriangle; GROUP],
    first: u32,
}

impl TriangleGroup<WatertightTriangle> for WatertightGroup {
    fn new(first: u32, triangles: &[WatertightTriangle]) -> Self {
        debug_assert!(triangles.len() <= GROUP);
        let point = WatertightTriangle { v: [Vec3::ZERO; 3] };
        let lane = |lane| triangles.get(lane).copied().unwrap_or(point);
        Self { triangles: std::array::from_fn(lane), first }
    }

    #[inline(always)]
    fn first(&self) -> u32 {
        self.first
    }

    #[inline(always)]
    fn intersect(&self, ray: ShearedRay, t_max: f32) -> GroupHits {
        let mut hits = GroupHits { t: Vec4::ZERO, u: Vec4::ZERO, v: Vec4::ZERO, lanes: 0 };
        for (lane, triangle) in self.triangles.iter().enumerate() {
            if let Some((t, u, v)) = triangle.test(ray, t_max) {
                (hits.t[lane], hits.u[lane], hits.v[lane]) = (t, u, v);
                hits.lanes |= 1 << lane;
            }
        }
        hits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that are equal, opposite, tiny, huge and none.
    const VALUES: [f32; 12] =
        [0.0, -0.0, 1.0, -1.0, 0.3, 0.5, 2.0, -0.7, 1e30, -1e-30, f32::INFINITY, f32::NAN];

    struct Picks(u32);

    impl Picks {
        fn below(&mut self, limit: usize) -> usize {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 16) as usize % limit
        }

        fn point(&mut self, kinds: usize) -> Vec3 {
            Vec3::from([0; 3].map(|_| VALUES[self.below(kinds)]))
        }
    }

    #[test]
    fn a_group_gives_the_bits_of_each_of_its_triangles_and_no_hit_is_a_nan() {
        let mut picks = Picks(1);
        let (mut hits, mut misses) = (0, 0);
        for _ in 0..50_000 {
            let kinds = if picks.below(4) == 0 { VALUES.len() } else { 8 };
            let ray = Ray { t_max: 10.0, ..Ray::new(picks.point(kinds), picks.point(kinds)) };
            let all: [WatertightTriangle; GROUP] = std::array::from_fn(|_| {
                WatertightTriangle::from(&Triangle { v: [0; 3].map(|_| picks.point(kinds)) })
            });
            let filled = &all[..1 + picks.below(GROUP)];
            let found =
                WatertightGroup::new(0, filled).intersect(WatertightTriangle::prepare(&ray), ray.t_max);
            for lane in 0..GROUP {
                let expected = filled.get(lane).and_then(|triangle| triangle.intersect(&ray, ray.t_max));
                let hit = (found.lanes >> lane & 1 == 1).then(|| found.of_lane(lane));
                assert_eq!(hit, expected, "{ray:?} {filled:?}");
                assert!(hit.is_none_or(|(t, u, v)| (0.0..=10.0).contains(&t) && !u.is_nan() && !v.is_nan()));
                hits += u32::from(hit.is_some());
                misses += u32::from(hit.is_none());
            }
        }
        assert!(hits > 1000 && misses > 1000, "{hits} hits and {misses} misses: both have to occur");
    }

    #[test]
    fn a_ray_through_a_shared_edge_hits_a_triangle_at_any_scale() {
        for exponent in [-60, -40, 0, 40, 60] {
            let scale = 2.0_f32.powi(exponent);
            let [a, b, c, d] =
                [(0.1, 0.2), (0.9, 0.7), (0.1, 0.9), (0.8, 0.1)].map(|(x, y)| scale * Vec3::new(x, y, 1.0));
            let pair = [[a, b, c], [b, a, d]].map(|v| WatertightTriangle::from(&Triangle { v }));
            for step in 1..1000 {
                let ray = Ray::new(Vec3::ZERO, (a + step as f32 / 1000.0 * (b - a)) / scale);
                let hits =
                    pair.iter().filter(|triangle| triangle.intersect(&ray, f32::INFINITY).is_some()).count();
                assert!(hits > 0, "2^{exponent}, step {step}");
            }
        }
    }

    #[test]
    fn lines_and_directions_that_are_not_finite_are_missed() {
        let line = [Vec3::new(-1.0, 0.1, 3.0), Vec3::new(0.3, 0.1, 3.0), Vec3::new(1.7, 0.1, 3.0)];
        let ray = Ray::new(Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.1, 0.1, 3.0));
        assert_eq!(WatertightTriangle::from(&Triangle { v: line }).intersect(&ray, 10.0), None);
        let wall = WatertightTriangle::from(&Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] });
        let from = |direction| wall.intersect(&Ray::new(Vec3::new(0.2, 0.2, -1.0), direction), 10.0);
        assert!(from(Vec3::Z).is_some_and(|(t, ..)| (t - 1.0).abs() <= f32::EPSILON));
        assert_eq!(from(Vec3::new(0.0, 0.0, f32::INFINITY)), None);
        assert_eq!(from(Vec3::ZERO), None);
    }
}
