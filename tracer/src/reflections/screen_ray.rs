//! A ray as the screen shows it.
//!
//! In f64: what a march reads then differs from what a shader in f32 reads only where a ray passes a texel's corner within rounding.

use crate::ray::Ray;
use crate::view::View;
use glam::{DMat3, DVec2, DVec3, Vec3};

/// From the scene to homogeneous pixel coordinates: `(x w, y w, w)` with `x` and `y` in pixels from the upper left, and `w` the depth along
/// the view in units of the scene.
pub(crate) struct Projection {
    eye: DVec3,
    pixels: DMat3,
}

impl Projection {
    pub(crate) fn new(view: &View) -> Self {
        let (eye, pixel_plane) = view.pixel_plane();
        Self { eye, pixels: pixel_plane.inverse() }
    }

    /// The depth of a point, relative to the eye.
    pub(super) fn depth(&self, from_eye: Vec3) -> f32 {
        (self.pixels * from_eye.as_dvec3()).z as f32
    }

    pub(crate) fn point(&self, point: Vec3) -> DVec3 {
        self.pixels * (point.as_dvec3() - self.eye)
    }

    /// Of a point that is infinitely far.
    pub(crate) fn direction(&self, direction: Vec3) -> DVec3 {
        self.pixels * direction.as_dvec3()
    }

    /// Pixels from the upper left; not finite in the plane of the eye.
    pub(crate) fn pixel(&self, homogeneous: DVec3) -> DVec2 {
        homogeneous.truncate() / homogeneous.z
    }
}

/// The part of a ray that is on the screen, as a straight line of pixels, `s` from 0 to 1 along it.
///
/// Perspective-correct (McGuire & Mara, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4), 2014): the inverse of the depth and the ray's
/// parameter over the depth are linear in `s`.
pub(super) struct ScreenRay {
    /// Where it starts, in pixels.
    pub(super) start: DVec2,
    /// From there to its end.
    pub(super) delta: DVec2,
    /// The inverse of the depth at both ends; 0 at the end of a ray that never leaves the screen.
    inverse_depth: [f64; 2],
    /// The ray's parameter over the depth, at the end.
    end: f64,
}

impl ScreenRay {
    /// Parts shorter than this, in pixels, are not looked at: far more than rounding, and less than matters. (FidelityFX SSSR: 0.005.)
    pub(super) const SHORTEST: f64 = 1.0 / 1024.0;

    /// The part of `ray`, from its origin, on a screen of this size and beyond the depth `near`; `None` where there is none, or nothing that
    /// would move on the screen.
    pub(super) fn new(projection: &Projection, ray: &Ray, size: [u32; 2], near: f32) -> Option<Self> {
        let (origin, direction) = (projection.point(ray.origin), projection.direction(ray.direction));
        let [width, height] = size.map(f64::from);
        // Distances from each border of what is kept, in the ray's parameter: value and slope.
        let borders = |point: DVec3, near: f64| {
            [point.x, width * point.z - point.x, point.y, height * point.z - point.y, point.z - near]
        };
        let inside = borders(origin, 0.0).iter().all(|&distance| distance >= 0.0) && origin.z > 0.0;
        if !inside || !origin.is_finite() || !direction.is_finite() {
            return None;
        }
        let until = borders(origin, f64::from(near)).into_iter().zip(borders(direction, 0.0));
        let until = until.filter(|&(_, slope)| slope < 0.0).map(|(distance, slope)| distance / -slope);
        let until = until.fold(f64::INFINITY, f64::min);
        let end = if until.is_finite() { origin + direction * until } else { direction };
        let (start, inverse_end) =
            (origin.truncate() / origin.z, if until.is_finite() { 1.0 / end.z } else { 0.0 });
        let delta = end.truncate() / end.z - start;
        let moves = until > 0.0 && delta != DVec2::ZERO && delta.is_finite();
        moves.then(|| Self {
            start,
            delta,
            inverse_depth: [1.0 / origin.z, inverse_end],
            end: if until.is_finite() { until / end.z } else { 1.0 / end.z },
        })
    }

    fn inverse_depth(&self, s: f64) -> f64 {
        let [first, last] = self.inverse_depth;
        first * (1.0 - s) + last * s
    }

    /// Length in pixels along the axis that it moves most on.
    pub(super) fn length(&self) -> f64 {
        self.delta.abs().max_element()
    }

    /// Where it is, in pixels.
    pub(super) fn position(&self, s: f64) -> DVec2 {
        self.start + self.delta * s
    }

    /// The pixel of a screen of this size that it is in.
    pub(super) fn pixel(&self, s: f64, [width, height]: [u32; 2]) -> [u32; 2] {
        let DVec2 { x, y } = self.position(s);
        [(x as u32).min(width - 1), (y as u32).min(height - 1)]
    }

    /// The least and the largest depth between two places.
    pub(super) fn depths(&self, from: f64, to: f64) -> [f64; 2] {
        let [a, b] = [from, to].map(|s| 1.0 / self.inverse_depth(s));
        if a <= b { [a, b] } else { [b, a] }
    }

    /// Where it has this depth; not finite where it never has.
    pub(super) fn at_depth(&self, depth: f64) -> f64 {
        let [first, last] = self.inverse_depth;
        (1.0 / depth - first) / (last - first)
    }

    /// The ray's parameter.
    pub(super) fn parameter(&self, s: f64) -> f64 {
        self.end * s / self.inverse_depth(s)
    }
}
