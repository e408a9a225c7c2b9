//! Reflections at rough surfaces: the mirror reflection at a microfacet normal that the viewer sees, drawn as GGX has them.
//!
//! The distribution is Walter et al. 2007's, with Disney's alpha, the square of the perceptual roughness. Normals are drawn as seen from the
//! viewer by Dupuy & Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023.

use super::{above, on_circle, to_world};
use glam::Vec3;

/// `incoming` (unit length) reflected at a microfacet of the surface with unit `normal`, which faces it; `roughness` is perceptual,
/// above 0. A reflection into the surface, about to be reflected again, is mirrored to above.
pub(crate) fn glossy_reflection(incoming: Vec3, normal: Vec3, roughness: f32, point: [f32; 2]) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let view = Vec3::new(-incoming.dot(tangent), -incoming.dot(bitangent), (-incoming.dot(normal)).max(0.0));
    let microfacet = to_world(visible_normal(view, roughness * roughness, point).to_array(), normal);
    above(incoming.reflect(microfacet).normalize_or(normal), normal)
}

/// A microfacet normal; all is relative to the surface, whose normal is z.
fn visible_normal(view: Vec3, alpha: f32, [u, v]: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(view.x * alpha, view.y * alpha, view.z).normalize_or(Vec3::Z);
    // A direction of the cap around the axis that ends at the stretched view, mirrored.
    let above_view = (1.0 - v) * (1.0 + stretched.z);
    let height = above_view - stretched.z;
    let radius = (1.0 - height * height).clamp(0.0, 1.0).sqrt();
    let [x, y] = on_circle(u);
    // `above_view` is height + view.z without cancellation: never 0, as v is below 1.
    let half = Vec3::new(radius * x + stretched.x, radius * y + stretched.y, above_view);
    Vec3::new(half.x * alpha, half.y * alpha, half.z).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: u32 = 512;

    /// The middles of a fine grid over the square.
    fn grid() -> impl Iterator<Item = [f32; 2]> {
        let middle = |i: u32| (i as f32 + 0.5) / EDGE as f32;
        (0..EDGE).flat_map(move |x| (0..EDGE).map(move |y| [middle(x), middle(y)]))
    }

    /// Walter et al. 2007, equation 33, over the cosine of a normal.
    fn ggx(cosine: f64, alpha: f64) -> f64 {
        let squared = alpha * alpha;
        squared / (std::f64::consts::PI * (cosine * cosine * (squared - 1.0) + 1.0).powi(2))
    }

    /// The share of microfacets that a viewer sees: Walter et al. 2007, equation 34.
    fn shown(cosine: f64, alpha: f64) -> f64 {
        let tangent_squared = 1.0 / (cosine * cosine) - 1.0;
        2.0 / (1.0 + (1.0 + alpha * alpha * tangent_squared).sqrt())
    }

    #[test]
    fn seen_from_above_the_mean_squared_cosine_is_the_closed_form() {
        // tan^2 = alpha^2 w / (1 - w) with w uniform; integrated, cos^2 is 1/b + alpha^2 ln(alpha^2) / b^2 with b = 1 - alpha^2.
        for alpha in [0.05_f64, 0.16, 0.5, 0.9] {
            let squares =
                grid().map(|point| f64::from(visible_normal(Vec3::Z, alpha as f32, point).z).powi(2));
            let mean = squares.sum::<f64>() / f64::from(EDGE * EDGE);
            let (squared, b) = (alpha * alpha, 1.0 - alpha * alpha);
            let expected = 1.0 / b + squared * squared.ln() / (b * b);
            assert!((mean - expected).abs() < 1e-4, "{alpha}: {mean}, expected {expected}");
        }
    }

    #[test]
    fn seen_aslant_normals_are_as_dense_as_the_distribution_of_visible_ones() {
        const BINS: usize = 16;
        for (slant, alpha) in [(0.0_f64, 0.3_f64), (0.8, 0.3), (1.2, 0.16), (1.5, 0.6)] {
            let view = glam::DVec3::new(slant.sin(), 0.0, slant.cos());
            let mut drawn = [[0.0_f64; BINS]; BINS];
            for point in grid() {
                let normal = visible_normal(view.as_vec3(), alpha as f32, point);
                let [x, y] = [normal.x, normal.y].map(|part| ((part * 0.5 + 0.5) * BINS as f32) as usize);
                drawn[x.min(BINS - 1)][y.min(BINS - 1)] += 1.0 / f64::from(EDGE * EDGE);
            }
            // The density over the projected disk: G1 max(0, v.h) D / (v.n), over h.n for the projection; summed over a finer grid.
            const FINE: usize = 64;
            let mut expected = [[0.0_f64; BINS]; BINS];
            let step = 2.0 / (BINS * FINE) as f64;
            for (x, y) in (0..BINS * FINE).flat_map(|x| (0..BINS * FINE).map(move |y| (x, y))) {
                let [hx, hy] = [x, y].map(|i| (i as f64 + 0.5) * step - 1.0);
                let rest = 1.0 - hx * hx - hy * hy;
                if rest <= 0.0 {
                    continue;
                }
                let normal = glam::DVec3::new(hx, hy, rest.sqrt());
                let density =
                    shown(view.z, alpha) * view.dot(normal).max(0.0) * ggx(normal.z, alpha) / view.z;
                expected[x / FINE][y / FINE] += density / normal.z * step * step;
            }
            let total: f64 = expected.iter().flatten().sum();
            assert!((total - 1.0).abs() < 0.01, "the reference is a density: {total}");
            let distance: f64 =
                drawn.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
            assert!(distance < 0.02, "at {slant}, {alpha}: total variation {distance}");
        }
    }

    #[test]
    fn directions_are_unit_and_above_even_at_grazing_views_and_corners_of_the_square() {
        let last = 1.0 - f32::EPSILON / 2.0;
        let normal = Vec3::new(1.0, 2.0, -0.5).normalize();
        let (tangent, _) = normal.any_orthonormal_pair();
        for cosine in [1.0, 0.1, 1e-4, 1e-8, 0.0, -1e-8] {
            let incoming = (tangent - normal * cosine).normalize();
            for roughness in [1e-4, 0.1, 0.4, 1.0] {
                for u in [0.0, 0.25, 0.5, last] {
                    for v in [0.0, 0.5, last] {
                        let direction = glossy_reflection(incoming, normal, roughness, [u, v]);
                        let at = format!("{cosine} {roughness} {u} {v}: {direction}");
                        assert!(direction.is_normalized() && direction.dot(normal) > 0.0, "{at}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_smooth_surface_reflects_like_a_mirror() {
        let incoming = Vec3::new(1.0, -1.0, 0.3).normalize();
        for point in [[0.1, 0.2], [0.9, 0.5]] {
            let glossy = glossy_reflection(incoming, Vec3::Y, 0.01, point);
            assert!(glossy.distance(super::super::mirror_reflection(incoming, Vec3::Y)) < 1e-3, "{glossy}");
        }
    }
}
