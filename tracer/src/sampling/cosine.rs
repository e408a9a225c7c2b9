//! Directions over a hemisphere, as dense as their cosine with the normal: those of ambient occlusion and diffuse light.
//!
//! Points of a disk, lifted onto the hemisphere (Malley). The disk is Shirley & Chiu's, "A Low Distortion Map Between Disk and Square",
//! 1997, which keeps strata compact.

use super::{above, on_circle, to_world};
use glam::Vec3;

/// A unit direction above the surface with unit `normal`; the density is its cosine with the normal, over pi.
pub(crate) fn cosine_weighted(normal: Vec3, point: [f32; 2]) -> Vec3 {
    let [x, y] = disk(point);
    let height = (1.0 - x * x - y * y).max(0.0).sqrt();
    above(to_world([x, y, height], normal), normal)
}

/// Maps the unit square onto the unit disk, equal areas to equal areas.
fn disk([u, v]: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let (radius, turns) = if a.abs() > b.abs() { (a, b / a / 8.0) } else { (b, 0.25 - a / b / 8.0) };
    on_circle(turns).map(|part| radius * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: u32 = 256;

    /// The middles of a fine grid over the square.
    fn grid() -> impl Iterator<Item = [f32; 2]> {
        let middle = |i: u32| (i as f32 + 0.5) / EDGE as f32;
        (0..EDGE).flat_map(move |x| (0..EDGE).map(move |y| [middle(x), middle(y)]))
    }

    #[test]
    fn moments_of_the_cosine_are_those_of_its_density() {
        // With density cos / pi the mean of cos^n is 2 / (n + 2), and that of a direction is 2/3 of the normal.
        for normal in [Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, -2.0, 3.0).normalize()] {
            let count = f64::from(EDGE * EDGE);
            for n in 1..=4 {
                let powers =
                    grid().map(|point| f64::from(cosine_weighted(normal, point).dot(normal)).powi(n));
                let mean = powers.sum::<f64>() / count;
                assert!((mean - 2.0 / f64::from(n + 2)).abs() < 5e-4, "{n}: {mean}");
            }
            let mean =
                grid().map(|point| cosine_weighted(normal, point).as_dvec3()).sum::<glam::DVec3>() / count;
            assert!(mean.distance(normal.as_dvec3() * (2.0 / 3.0)) < 5e-4, "{mean}");
        }
    }

    #[test]
    fn equal_parts_of_the_square_are_equal_parts_of_the_disk() {
        // 8 rings of equal area by 8 sectors; each holds 1024 points of the grid but for those on its border, a tenth at most.
        let mut parts = [0_u32; 64];
        for point in grid() {
            let [x, y] = disk(point);
            let ring = ((x * x + y * y) * 8.0) as usize;
            let sector = ((y.atan2(x) / std::f32::consts::TAU + 0.5) * 8.0) as usize;
            parts[ring.min(7) * 8 + sector.min(7)] += 1;
        }
        assert!(parts.iter().all(|&count| count.abs_diff(1024) <= 102), "{parts:?}");
    }

    #[test]
    fn directions_are_unit_and_above_even_at_the_corners_of_the_square() {
        let last = 1.0 - f32::EPSILON / 2.0;
        for normal in [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(-3.0, 1.0, 0.01).normalize()] {
            for u in [0.0, 1e-7, 0.5, last] {
                for v in [0.0, 1e-7, 0.5, last] {
                    let direction = cosine_weighted(normal, [u, v]);
                    assert!(direction.is_normalized() && direction.dot(normal) > 0.0, "{u} {v}: {direction}");
                }
            }
        }
    }
}
