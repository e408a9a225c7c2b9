//! Where a ray crosses a triangle, decided exactly.
//!
//! Coordinates are dyadic rationals, so the three volumes whose signs say on which side of each edge the ray passes are too. They are
//! computed in f64, with a bound on the error; where that leaves a sign in doubt, or the distance fewer than nine digits, again in
//! integers of any length.

use glam::DVec3;
use num_bigint::{BigInt, Sign};
use num_traits::ToPrimitive;
use scenes::Triangle;
use tracer::Ray;

/// Unit roundoff of f32.
pub(crate) const U: f64 = 1.0 / (1 << 24) as f64;

/// Relative error of a product sum of six terms in f64, with room.
const DOUBT: f64 = 16.0 * f64::EPSILON;

/// Cancellation up to which f64 keeps nine digits.
const WELL: f64 = 1e5;

/// Where a ray's line meets a triangle's plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Ray parameter, to 1e-9 or better.
    pub(crate) t: f64,
    /// Weights of the three vertices; all at least 0 inside the triangle.
    pub(crate) weights: [f64; 3],
    /// Condition of the weights: by how many roundings' worth each rounding of a test may move them. Longest edge times farthest
    /// vertex, seen from the origin, times the length of the direction, over the determinant.
    pub(crate) condition: f64,
    /// By how much a test in f32 may be off in `t`.
    pub(crate) t_doubt: f64,
}

/// Roundings that can add up in a weight or a distance of either test: about ten in the numerator and ten in the determinant, and some
/// room as norms are taken for each.
pub(crate) const ROUNDINGS: f64 = 32.0;

impl Crossing {
    /// By how much a test in f32 may be off in a weight.
    pub(crate) fn doubt(&self) -> f64 {
        ROUNDINGS * U * self.condition
    }

    /// The smallest weight: below 0 outside.
    pub(crate) fn least_weight(&self) -> f64 {
        self.weights.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Where the ray crosses the closed triangle within its interval. A ray in the triangle's plane crosses nothing, nor does any ray a
/// triangle without area.
pub(crate) fn crossing(ray: &Ray, triangle: &Triangle) -> Option<Crossing> {
    let relative = Relative::new(ray, triangle);
    let volumes = relative.volumes();
    let sides = |side: f64| volumes.iter().any(|&(volume, doubt)| side * volume > doubt);
    if sides(1.0) && sides(-1.0) {
        return None;
    }
    let sure = volumes.iter().all(|&(volume, doubt)| volume.abs() > doubt);
    let found = relative.plane(ray, triangle, sure)?;
    let inside =
        found.least_weight() >= 0.0 && found.t >= f64::from(ray.t_min) && found.t <= f64::from(ray.t_max);
    inside.then_some(found)
}

/// Where the ray's line crosses the plane of the triangle, inside or not, before the ray or behind it.
pub(crate) fn plane_crossing(ray: &Ray, triangle: &Triangle) -> Option<Crossing> {
    Relative::new(ray, triangle).plane(ray, triangle, false)
}

/// A triangle seen from a ray's origin, in f64.
struct Relative {
    corners: [DVec3; 3],
    direction: DVec3,
}

impl Relative {
    fn new(ray: &Ray, triangle: &Triangle) -> Self {
        let origin = ray.origin.as_dvec3();
        let corners = triangle.v.map(|corner| corner.as_dvec3() - origin);
        Self { corners, direction: ray.direction.as_dvec3() }
    }

    /// The volumes of direction and each edge, with bounds on their errors.
    fn volumes(&self) -> [(f64, f64); 3] {
        let [a, b, c] = self.corners;
        [(b, c), (c, a), (a, b)].map(|(p, q)| {
            let size = DVec3::new(
                (p.y * q.z).abs() + (p.z * q.y).abs(),
                (p.z * q.x).abs() + (p.x * q.z).abs(),
                (p.x * q.y).abs() + (p.y * q.x).abs(),
            );
            (self.direction.dot(p.cross(q)), DOUBT * self.direction.abs().dot(size))
        })
    }

    /// In f64 if the signs of the volumes are `sure` and nothing cancels, else in integers.
    fn plane(&self, ray: &Ray, triangle: &Triangle, sure: bool) -> Option<Crossing> {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let (det, height) = (self.direction.dot(normal), a.dot(normal));
        let reach = a.length().max(b.length()).max(c.length());
        let edge = (b - a).length().max((c - a).length()).max((c - b).length());
        let length = self.direction.length();
        let size = edge * reach * length;
        let well = size < WELL * det.abs() && a.length() * normal.length() < WELL * height.abs();
        let (t, weights, det) = if sure && well {
            let volumes = self.volumes().map(|(volume, _)| volume);
            let sum: f64 = volumes.iter().sum();
            (height / det, volumes.map(|volume| volume / sum), det)
        } else {
            in_integers(ray, triangle)?
        };
        let condition = size / det.abs();
        let t_doubt = ROUNDINGS * U * (condition * edge / length + t.abs());
        Some(Crossing { t, weights, condition, t_doubt })
    }
}

/// Distance, weights of the vertices and determinant of a crossing, from integers.
fn in_integers(ray: &Ray, triangle: &Triangle) -> Option<(f64, [f64; 3], f64)> {
    let places: Vec<f32> =
        triangle.v.iter().chain([&ray.origin]).flat_map(|point| point.to_array()).collect();
    let (points, place_unit) = integers(&places);
    let (d, direction_unit) = integers(&ray.direction.to_array());
    let vector = |vertex: usize| -> [BigInt; 3] {
        std::array::from_fn(|axis| &points[3 * vertex + axis] - &points[9 + axis])
    };
    let [a, b, c] = [vector(0), vector(1), vector(2)];
    let volumes = [dot(&d, &cross(&b, &c)), dot(&d, &cross(&c, &a)), dot(&d, &cross(&a, &b))];
    let det: BigInt = volumes.iter().sum();
    if det.sign() == Sign::NoSign {
        return None;
    }
    let edge = |p: &[BigInt; 3]| -> [BigInt; 3] { std::array::from_fn(|axis| &p[axis] - &a[axis]) };
    let numerator = dot(&a, &cross(&edge(&b), &edge(&c)));
    let t = ratio(&numerator, &det) * 2.0_f64.powi(place_unit - direction_unit);
    let det_value = det.to_f64()? * 2.0_f64.powi(2 * place_unit + direction_unit);
    Some((t, volumes.map(|volume| ratio(&volume, &det)), det_value))
}

/// The numbers as multiples of a power of two, and that power's exponent.
fn integers(values: &[f32]) -> (Vec<BigInt>, i32) {
    let split = |value: f32| {
        let bits = value.to_bits();
        let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, (bits & 0x7f_ffff) as i64);
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 23 };
        (if value < 0.0 { -mantissa } else { mantissa }, exponent.max(1) - 150)
    };
    let parts: Vec<(i64, i32)> = values.iter().map(|&value| split(value)).collect();
    let unit = parts.iter().filter(|part| part.0 != 0).map(|part| part.1).min().unwrap_or(0);
    let shifted = |(mantissa, exponent): (i64, i32)| match mantissa {
        0 => BigInt::ZERO,
        _ => BigInt::from(mantissa) << (exponent - unit) as u32,
    };
    (parts.into_iter().map(shifted).collect(), unit)
}

fn cross(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    std::array::from_fn(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

fn dot(a: &[BigInt], b: &[BigInt]) -> BigInt {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A quotient to 64 bits.
fn ratio(numerator: &BigInt, denominator: &BigInt) -> f64 {
    let shift = 64 + denominator.bits() as i64 - numerator.bits() as i64;
    let quotient = if shift >= 0 {
        (numerator << shift as u64) / denominator
    } else {
        numerator / (denominator << shift.unsigned_abs())
    };
    quotient.to_f64().unwrap_or(f64::NAN) * 2.0_f64.powi(-shift as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::Vec3;

    #[test]
    fn integers_give_what_f64_gives_where_that_is_sure() {
        let mut random = Random(1);
        let mut hits = 0;
        for _ in 0..2000 {
            let triangle = Triangle { v: [0; 3].map(|_| random.point()) };
            let ray = Ray::new(random.point(), random.direction());
            let whole = in_integers(&ray, &triangle)
                .filter(|(t, weights, _)| *t >= 0.0 && weights.iter().all(|weight| *weight >= 0.0));
            let found = crossing(&ray, &triangle);
            assert_eq!(found.is_some(), whole.is_some());
            if let (Some(found), Some((t, weights, _))) = (found, whole) {
                hits += 1;
                assert!((found.t - t).abs() <= 1e-9 * t, "{} and {t}", found.t);
                for (ours, exact) in found.weights.into_iter().zip(weights) {
                    assert!((ours - exact).abs() <= 1e-9);
                }
            }
        }
        assert!(hits > 50, "{hits}");
    }

    #[test]
    fn a_ray_through_a_vertex_or_an_edge_crosses_and_one_a_float_beside_it_does_not() {
        let triangle =
            Triangle { v: [Vec3::new(0.1, 0.1, 1.0), Vec3::new(0.7, 0.1, 1.0), Vec3::new(0.1, 0.9, 1.0)] };
        let along = |x: f32, y: f32| crossing(&Ray::new(Vec3::new(x, y, 0.0), Vec3::Z), &triangle);
        assert_eq!(along(0.1, 0.1).map(|found| (found.t, found.weights)), Some((1.0, [1.0, 0.0, 0.0])));
        assert!(along(0.3, 0.1).is_some() && along(0.3, 0.1_f32.next_down()).is_none());
        assert!(along(0.1, 0.5).is_some() && along(0.1_f32.next_down(), 0.5).is_none());
        // In the triangle's plane, and without area.
        assert!(crossing(&Ray::new(Vec3::new(0.0, 0.2, 1.0), Vec3::X), &triangle).is_none());
        let point = Triangle { v: [Vec3::Z; 3] };
        assert!(crossing(&Ray::new(Vec3::ZERO, Vec3::Z), &point).is_none());
    }
}
