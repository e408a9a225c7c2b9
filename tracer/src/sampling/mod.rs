//! Directions of rays that are drawn at random, each a function of a point of the unit square.
//!
//! Directions have unit length and lie above the surface: where rounding, a grazing view or the sampled microfacet would take one
//! below, it is mirrored to above ([`above`]), so that every ray that a shader would make is traced.

mod cosine;
mod ggx;
mod sobol;
mod sphere;

pub(crate) use cosine::cosine_weighted;
pub(crate) use ggx::glossy_reflection;
pub(crate) use sobol::Points;
pub(crate) use sphere::point_of_sphere;

use glam::Vec3;

/// Least cosine of a direction with its normal: sixteen times what rounding can take from it.
const LEAST_COSINE: f32 = 1.0 / (1 << 20) as f32;

/// A point of the unit circle, from a part of its turn: the same bits on every machine.
fn on_circle(turns: f32) -> [f32; 2] {
    let (sine, cosine) = scenes::sin_cos(f64::from(turns));
    [cosine as f32, sine as f32]
}

/// `direction`, mirrored at the surface with unit `normal` where it points below, and lifted off the surface where it grazes it.
pub(crate) fn above(direction: Vec3, normal: Vec3) -> Vec3 {
    let cosine = direction.dot(normal);
    let wanted = cosine.abs().max(LEAST_COSINE);
    if cosine == wanted { direction } else { direction + normal * (wanted - cosine) }
}

/// `incoming` (unit length) reflected at a surface with unit `normal` that faces it.
pub(crate) fn mirror_reflection(incoming: Vec3, normal: Vec3) -> Vec3 {
    above(incoming.reflect(normal), normal)
}

/// Of a direction given by its part along `normal` and along two directions that are perpendicular to it.
fn to_world([x, y, z]: [f32; 3], normal: Vec3) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    tangent * x + bitangent * y + normal * z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_below_are_mirrored_and_grazing_ones_lifted() {
        let up = Vec3::Y;
        assert_eq!(above(Vec3::new(0.6, 0.8, 0.0), up), Vec3::new(0.6, 0.8, 0.0));
        assert_eq!(above(Vec3::new(0.6, -0.8, 0.0), up), Vec3::new(0.6, 0.8, 0.0));
        assert_eq!(above(Vec3::X, up), Vec3::new(1.0, LEAST_COSINE, 0.0));
        assert_eq!(above(Vec3::NEG_Y, up), up);
    }

    #[test]
    fn mirrored_rays_keep_their_angle_down_to_grazing_ones() {
        let normal = Vec3::new(2.0, -1.0, 0.5).normalize();
        let (tangent, _) = normal.any_orthonormal_pair();
        for cosine in [1.0, 0.5, 1e-3, 1e-6, 1e-9, 0.0] {
            let incoming = (tangent - normal * cosine).normalize();
            let reflected = mirror_reflection(incoming, normal);
            let (before, after) = (-incoming.dot(normal), reflected.dot(normal));
            assert!(after > 0.0 && reflected.is_normalized(), "{cosine}");
            assert!((after - before).abs() <= 2.0 * LEAST_COSINE, "{before} became {after}");
            assert!((reflected.dot(tangent) - incoming.dot(tangent)).abs() < 1e-6, "{cosine}");
        }
    }
}
