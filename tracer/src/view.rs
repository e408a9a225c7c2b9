//! The rays of a frame: primary rays of a pinhole camera, and where rays begin that leave a hit.

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

    /// Where the rays start.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The same camera moved to its right by `offset`, in units of the scene, its image plane sheared so that what lies at the depth `convergence`
    /// along the view keeps its place in the image; at an infinite one what is infinitely far does.
    pub(crate) fn moved_right(&self, offset: f64, convergence: f64) -> Self {
        let to_the_right = self.right.normalize_or_zero();
        let eye = (self.eye.as_dvec3() + to_the_right * offset).as_vec3();
        // Where coordinates are large, f32 does not hold the eye where it should be.
        let moved = (eye.as_dvec3() - self.eye.as_dvec3()).dot(to_the_right);
        Self { eye, corner: self.corner - to_the_right * (moved / convergence), ..*self }
    }

    /// The eye, and the matrix that takes `(x, y, 1)`, in pixels from the upper left, to the direction through that point of the
    /// image: of depth 1 along the view.
    pub(crate) fn pixel_plane(&self) -> (DVec3, DMat3) {
        (self.eye.as_dvec3(), DMat3::from_cols(self.right, self.down, self.corner))
    }
}

/// By how much the origins of rays that leave a surface are moved off their surface, in one scene.
///
/// Waechter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, chapter 6: by up to 256 ulps of a
/// coordinate, and of coordinates near zero, which have hardly any ulps, by a fixed step. Their constants are for scenes with
/// coordinates beyond 1/32; a smaller scene would lie within one step, so there they shrink with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayOffset {
    /// Coordinates below this are near zero.
    near_zero: f32,
    /// How far these are moved along a unit normal.
    step: f32,
}

impl RayOffset {
    /// Largest distance from zero that counts as near, in scenes with coordinates beyond it.
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    /// Steps within the distance that counts as near.
    const STEPS: f32 = 2048.0;
    /// Ulps of other coordinates.
    const ULPS: f32 = 256.0;

    /// For a scene of these triangles.
    pub fn new(triangles: &[Triangle]) -> Self {
        let corners = triangles.iter().flat_map(|triangle| triangle.v);
        let largest = corners.fold(0.0, |largest: f32, corner| largest.max(corner.abs().max_element()));
        let near_zero = largest.min(Self::NEAR_ZERO);
        Self { near_zero, step: near_zero / Self::STEPS }
    }

    /// Moves `point` along the unit vector `normal`.
    fn apply(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let ulps: IVec3 = (normal * Self::ULPS).as_ivec3();
        Vec3::from_array(std::array::from_fn(|axis| {
            let p = point[axis];
            if p.abs() < self.near_zero {
                p + self.step * normal[axis]
            } else {
                let step = if p < 0.0 { -ulps[axis] } else { ulps[axis] };
                f32::from_bits(p.to_bits().wrapping_add_signed(step))
            }
        }))
    }

    /// The shadow ray from a hit of `incoming` at barycentrics (`u`, `v`) of `triangle` to a point light: `t` from 0 at the surface to
    /// 1 at the light. The origin is moved to the side that `incoming` came from.
    #[inline]
    pub fn shadow_ray(&self, triangle: &Triangle, u: f32, v: f32, incoming: Vec3, light: Vec3) -> Ray {
        self.departure(triangle, u, v, incoming).shadow_ray(light)
    }

    /// Where rays leave a hit of `incoming` at barycentrics (`u`, `v`) of `triangle`: on the side that `incoming` came from.
    #[inline]
    pub fn departure(&self, triangle: &Triangle, u: f32, v: f32, incoming: Vec3) -> Departure {
        let [a, b, c] = triangle.v;
        let (e1, e2) = (b - a, c - a);
        let point = a + e1 * u + e2 * v;
        let mut normal = e1.cross(e2).normalize_or_zero();
        if normal == Vec3::ZERO {
            // Edges below 1e-9 or above 1e9: the square of the area has left the range of f32.
            normal = e1.as_dvec3().cross(e2.as_dvec3()).normalize_or_zero().as_vec3();
        }
        let facing = if normal.dot(incoming) > 0.0 { -normal } else { normal };
        let origin = self.apply(point, facing);
        Departure {
            origin,
            normal: if facing == Vec3::ZERO { -incoming.normalize_or(Vec3::NEG_Z) } else { facing },
        }
    }
}

/// Where rays leave a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// The point, moved off the surface.
    pub origin: Vec3,
    /// Unit geometric normal on the side that the ray came from which hit it; against that ray where the triangle has no area.
    pub normal: Vec3,
}

impl Departure {
    /// The ray in a direction, without end.
    #[inline]
    pub fn ray(&self, direction: Vec3) -> Ray {
        Ray::new(self.origin, direction)
    }

    /// The ray to a point: `t` from 0 to 1 there.
    #[inline]
    pub fn shadow_ray(&self, light: Vec3) -> Ray {
        Ray { origin: self.origin, t_min: 0.0, direction: light - self.origin, t_max: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(largest: f32) -> RayOffset {
        RayOffset::new(&[Triangle {
            v: [Vec3::ZERO, Vec3::new(0.0, largest, 0.0), Vec3::new(-0.5 * largest, 0.0, 0.0)],
        }])
    }

    #[test]
    fn coordinates_near_zero_move_by_the_published_step_in_scenes_that_reach_beyond_it_and_by_less_in_smaller_ones()
     {
        let moved = |largest: f32| scene(largest).apply(Vec3::ZERO, Vec3::Z).z;
        assert_eq!([moved(1.0 / 32.0), moved(1.0), moved(1e10)], [1.0 / 65536.0; 3]);
        assert_eq!(moved(1.0 / 64.0), 1.0 / 131_072.0);
        assert!(moved(1e-20) < 1e-23 && moved(1e-20) > 0.0);
    }

    #[test]
    fn other_coordinates_move_away_along_the_normal_by_256_ulps() {
        for p in [1.0_f32, -1.0, 3e7] {
            for side in [1.0, -1.0] {
                let moved = scene(1e8).apply(Vec3::splat(p), Vec3::X * side);
                let ulps = (i64::from(moved.x.to_bits()) - i64::from(p.to_bits())).abs();
                assert_eq!((ulps, (moved.x - p).signum(), moved.y), (256, side, p));
            }
        }
    }
}
