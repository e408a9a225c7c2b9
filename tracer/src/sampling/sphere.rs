//! Points of a light that is a sphere, for soft shadows.

use super::on_circle;
use glam::Vec3;

/// A point on the sphere around `centre`, uniform over the half that faces `seen_from`.
///
/// Archimedes: the height of a uniform point is uniform. Points of the other half are mirrored through the centre.
pub(crate) fn point_of_sphere(centre: Vec3, radius: f32, seen_from: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let height = 1.0 - 2.0 * v;
    let [x, y] = on_circle(u);
    let around = (1.0 - height * height).max(0.0).sqrt();
    let direction = Vec3::new(around * x, around * y, height);
    let facing = if direction.dot(seen_from - centre) < 0.0 { -direction } else { direction };
    centre + facing * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_uniform_over_the_half_that_is_seen() {
        // Over a half, the cosine with the direction of the viewer is uniform in 0 to 1.
        const EDGE: u32 = 256;
        let centre = Vec3::new(1.0, -2.0, 0.5);
        for seen_from in [Vec3::new(4.0, 5.0, -6.0), Vec3::new(1.0, -2.0, 9.0)] {
            let towards = (seen_from - centre).normalize();
            let mut bins = [0_u32; 8];
            for (x, y) in (0..EDGE).flat_map(|x| (0..EDGE).map(move |y| (x, y))) {
                let point = [x, y].map(|i| (i as f32 + 0.5) / EDGE as f32);
                let from_centre = point_of_sphere(centre, 3.0, seen_from, point) - centre;
                assert!((from_centre.length() - 3.0).abs() < 1e-5);
                let cosine = from_centre.dot(towards) / 3.0;
                assert!(cosine > -1e-6, "{cosine}");
                bins[((cosine * 8.0) as usize).min(7)] += 1;
            }
            let expected = EDGE * EDGE / 8;
            assert!(bins.iter().all(|count| count.abs_diff(expected) <= expected / 50), "{bins:?}");
        }
    }
}
