//! The pinhole camera, and the one chosen when a scene names none.

use crate::{Aabb, Error};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// A pinhole camera. Lengths are in the units of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the rays start.
    pub eye: Vec3,
    /// The point in the middle of the image.
    pub target: Vec3,
    /// Which way is up; need not be perpendicular to the view.
    #[serde(default = "y_up")]
    pub up: Vec3,
    /// The angle between the lower and the upper edge of the image, in degrees.
    pub vertical_fov_degrees: f32,
}

fn y_up() -> Vec3 {
    Vec3::Y
}

/// Vertical field of view of a framed camera, in degrees.
const FRAMED_FOV_DEGREES: f32 = 45.0;
/// sin(22.5 degrees): a sphere seen under 45 degrees is its radius divided by this away.
const SIN_HALF_FRAMED_FOV: f64 = 0.382_683_432_365_089_8;

impl Camera {
    /// Refuses a camera that has no direction: non-finite values, eye on target, up along the view, or a field of
    /// view outside 0 to 180 degrees (both excluded).
    ///
    /// `place` names the file or scene in the error.
    pub fn validate(&self, place: &str) -> Result<(), Error> {
        let refuse = |problem: &str, remedy: &str| Err(Error::new(place, problem, remedy));
        let finite = self.eye.is_finite() && self.target.is_finite() && self.up.is_finite();
        if !finite {
            return refuse("the camera has a value that is not finite", "give finite eye, target and up");
        }
        if !(self.vertical_fov_degrees > 0.0 && self.vertical_fov_degrees < 180.0) {
            let problem = format!(
                "the camera's vertical_fov_degrees is {}, expected more than 0 and less than 180",
                self.vertical_fov_degrees
            );
            return refuse(&problem, "45 to 60 is usual");
        }
        let view = self.target.as_dvec3() - self.eye.as_dvec3();
        if view == DVec3::ZERO {
            return refuse("the camera's eye and target are the same point", "move one of them");
        }
        let (view, up) = (view / view.abs().max_element(), self.up.as_dvec3());
        let up = if up == DVec3::ZERO { up } else { up / up.abs().max_element() };
        let side = view.cross(up);
        if side.dot(side) <= 1e-12 * view.dot(view) * up.dot(up) {
            return refuse(
                "the camera's up is zero or parallel to the view",
                "give an up vector across the view",
            );
        }
        Ok(())
    }

    /// A camera that sees the whole of `bounds` from the front, the side and a little above.
    ///
    /// The bounding sphere fills the vertical field of view of 45 degrees. Flat, point-like, empty and huge boxes
    /// all give a valid camera: a point counts as a sphere of radius 1 or, far from the origin, one that f32 can
    /// still tell from its centre.
    pub fn frame(bounds: Aabb, up: Vec3) -> Camera {
        let (centre, radius) = bounding_sphere(bounds);
        let up = if up.is_finite() && up != Vec3::ZERO { up } else { Vec3::Y };
        let vertical = {
            let u = up.as_dvec3() / f64::from(up.abs().max_element());
            u / u.dot(u).sqrt()
        };
        let helper = if vertical.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let front = helper.cross(vertical);
        let front = front / front.dot(front).sqrt();
        let side = vertical.cross(front);
        let direction = front + side * 0.625 + vertical * 0.5;
        let direction = direction / direction.dot(direction).sqrt();

        let limit = f64::from(f32::MAX);
        let eye = centre + direction * (radius / SIN_HALF_FRAMED_FOV);
        Camera {
            eye: eye.clamp(DVec3::splat(-limit), DVec3::splat(limit)).as_vec3(),
            target: centre.as_vec3(),
            up,
            vertical_fov_degrees: FRAMED_FOV_DEGREES,
        }
    }
}

/// Centre and radius of the sphere around `bounds`; an empty box counts as the origin.
pub(crate) fn bounding_sphere(bounds: Aabb) -> (DVec3, f64) {
    if bounds.is_empty() {
        return (DVec3::ZERO, 1.0);
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (centre, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let radius = half.dot(half).sqrt();
    let resolvable = centre.abs().max_element() * 1e-5;
    (centre, if radius > resolvable.max(1e-30) { radius } else { resolvable.max(1.0) })
}
