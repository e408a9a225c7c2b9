//! The rays of a frame: primary rays of a pinhole camera and the shadow rays of their hits.

use crate::ray::Ray;
use glam::{DMat3, DVec3, IVec3, Vec3};
use scenes::{Camera, Triangle};

/// A pinhole camera over an image, ready to give rays.
#[derive(Clone, Copy, Debug)]
pub struct View {
    eye: Vec3,
    /// Direction of the pixel plane's top left corner, and its steps per pixel.
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl View {
    /// A camera over `width` x `height` square pixels, the vertical field of view as the camera has it.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let (eye, target, up) = (camera.eye.as_dvec3(), camera.target.as_dvec3(), camera.up.as_dvec3());
        let forward = (target - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let pixel =
            2.0 * (f64::from(camera.vertical_fov_degrees).to_radians() / 2.0).tan() / f64::from(height);
        let corner =
            forward - right * (pixel * f64::from(width) / 2.0) + up * (pixel * f64::from(height) / 2.0);
        Self { eye: camera.eye, corner, right: right * pixel, down: up * -pixel }
    }

    /// The ray through the centre of pixel (`x`, `y`), (0, 0) at the top left; unit direction.
    #[inline]
    pub fn primary_ray(&self, x: u32, y: u32) -> Ray {
        let direction = self.corner + self.right * (f64::from(x) + 0.5) + self.down * (f64::from(y) + 0.5);
        Ray::new(self.eye, direction.normalize().as_vec3())
    }

    /// The eye, and the matrix that takes `(x, y, 1)`, in pixels from the upper left, to the direction through that point of the
    /// image: of depth 1 along the view.
    pub(crate) fn pixel_plane(&self) -> (DVec3, DMat3) {
        (self.eye.as_dvec3(), DMat3::from_cols(self.right, self.down, self.corner))
    }
}

/// The shadow ray from a hit of `incoming` at barycentrics (`u`, `v`) of `triangle` to a point light: `t` from 0 at the surface to
/// 1 at the light.
///
/// The origin is moved off the surface, to the side that `incoming` came from, by a distance that follows the size of the
/// coordinates (Waechter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, chapter 6), never by
/// a fixed epsilon.
#[inline]
pub fn shadow_ray(triangle: &Triangle, u: f32, v: f32, incoming: Vec3, light: Vec3) -> Ray {
    let [a, b, c] = triangle.v;
    let (e1, e2) = (b - a, c - a);
    let point = a + e1 * u + e2 * v;
    let normal = e1.cross(e2).normalize_or_zero();
    let facing = if normal.dot(incoming) > 0.0 { -normal } else { normal };
    let origin = offset_origin(point, facing);
    Ray { origin, t_min: 0.0, direction: light - origin, t_max: 1.0 }
}

/// Moves `point` along the unit vector `normal`: by up to 256 ulps per axis away from zero, by 1/65536 of the normal near zero.
fn offset_origin(point: Vec3, normal: Vec3) -> Vec3 {
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    const NEAR_ZERO_STEP: f32 = 1.0 / 65536.0;
    const ULPS: f32 = 256.0;
    let ulps: IVec3 = (normal * ULPS).as_ivec3();
    Vec3::from_array(std::array::from_fn(|axis| {
        let p = point[axis];
        if p.abs() < NEAR_ZERO {
            p + NEAR_ZERO_STEP * normal[axis]
        } else {
            let step = if p < 0.0 { -ulps[axis] } else { ulps[axis] };
            f32::from_bits(p.to_bits().wrapping_add_signed(step))
        }
    }))
}
