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
