//! Where the two eyes are, and what they see.

use crate::view::View;

/// A pair of eyes that look in one direction, on either side of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    /// From one eye to the other, in units of the scene: finite, from 0 on.
    pub interaxial: f64,
    /// Depth along the view at which a point has the same place in both images, in units of the scene: above 0, infinite for parallel views.
    pub convergence: f64,
}

impl Eyes {
    /// The left and the right view of `camera`, whose image planes are sheared towards each other (off-axis), so that a point has the same row in
    /// both images.
    ///
    /// A point at the depth `convergence + z` that the left image has at `x` is in the right one at `x + interaxial z / (convergence + z)`, both
    /// measured in the plane of convergence (Adelson & Hodges 1993).
    pub fn views(&self, camera: &View) -> [View; 2] {
        let half = self.interaxial / 2.0;
        [-half, half].map(|offset| camera.moved_right(offset, self.convergence))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflections::Projection;
    use glam::Vec3;
    use proptest::prelude::*;
    use scenes::Camera;

    fn camera(width: u32, height: u32) -> View {
        let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vertical_fov_degrees: 60.0 };
        View::new(&camera, width, height)
    }

    proptest! {
        #[test]
        fn a_point_moves_by_the_published_formula_and_stays_in_its_row(
            x in -2.0_f64..2.0,
            y in -1.0_f64..1.0,
            z in -0.7_f64..1e4,
            interaxial in 0.0_f64..0.5,
            convergence in 1.0_f64..100.0,
        ) {
            let [left, right] = Eyes { interaxial, convergence }.views(&camera(200, 100)).map(|view| Projection::new(&view));
            let depth = convergence + z.max(-0.7 * convergence);
            let z = depth - convergence;
            let point = Vec3::new(x as f32, y as f32, -depth as f32);
            let [left, right] = [left, right].map(|eye| eye.pixel(eye.point(point)));
            // Pixels per unit of the plane of convergence.
            let pixels = 50.0 / 30.0_f64.to_radians().tan() / convergence;
            let expected = interaxial * z / (convergence + z) * pixels;
            let scale = 1.0 + left.x.abs() + expected.abs() + interaxial * pixels;
            prop_assert!((right.x - left.x - expected).abs() < 1e-5 * scale, "{left} {right} {expected}");
            prop_assert!((right.y - left.y).abs() < 1e-5 * (1.0 + left.y.abs()));
        }
    }

    #[test]
    fn parallel_eyes_see_infinity_in_one_place() {
        let [left, right] = Eyes { interaxial: 0.1, convergence: f64::INFINITY }
            .views(&camera(64, 64))
            .map(|view| view.primary_ray(3, 7));
        assert_eq!(left.direction, right.direction);
        assert_eq!(left.origin.x, -right.origin.x);
    }
}
