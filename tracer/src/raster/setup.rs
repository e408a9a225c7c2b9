//! Triangle set-up in homogeneous pixel coordinates, without clipping: Olano & Greer, "Triangle Scan Conversion using 2D Homogeneous
//! Coordinates", 1997.
//!
//! A point before or behind the eye is `(x w, y w, w)`: `x` and `y` in pixels from the upper left, pixel centres at halves, `w` the depth
//! along the view in scene units, negative behind the eye. The edge functions of a triangle are the planes through the eye and its
//! edges, so a triangle that reaches behind the eye needs no new vertices, and nothing overflows: products of three f32 values stay
//! far inside f64.

use crate::trace::TileRect;
use crate::view::View;
use glam::{DMat3, DVec2, DVec3};
use scenes::Triangle;

/// From the scene to homogeneous pixel coordinates.
pub(super) struct Projection {
    eye: DVec3,
    pixels: DMat3,
    /// Width and height in pixels.
    image: DVec2,
}

impl Projection {
    pub(super) fn new(view: &View, width: u32, height: u32) -> Self {
        let (eye, pixel_plane) = view.pixel_plane();
        Self { eye, pixels: pixel_plane.inverse(), image: DVec2::new(f64::from(width), f64::from(height)) }
    }

    /// The vertices of a triangle. A vertex depends on its own position alone, so neighbours agree about it.
    #[inline(always)]
    pub(super) fn corners(&self, triangle: &Triangle) -> [DVec3; 3] {
        triangle.v.map(|vertex| self.pixels * (vertex.as_dvec3() - self.eye))
    }
}

/// The part of the image that a triangle may cover, in pixels, edges included.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) min: DVec2,
    pub(super) max: DVec2,
}

/// Six times the volume between the eye and the triangle, signed by its winding; `None` for a triangle that covers nothing: without
/// area, seen edge-on, or with a value that is not finite.
#[inline(always)]
fn volume(corners: [DVec3; 3], normal: DVec3) -> Option<f64> {
    let volume = corners[0].dot(normal);
    (volume != 0.0 && volume.is_finite()).then_some(volume)
}

#[inline(always)]
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

impl Bounds {
    /// The bounds of a triangle within the image, or `None` where it covers nothing. The whole image where it reaches behind the eye.
    #[inline(always)]
    pub(super) fn new(corners: [DVec3; 3], projection: &Projection) -> Option<Self> {
        volume(corners, normal(corners))?;
        let before = corners.map(|corner| corner.z > 0.0);
        if before == [false; 3] {
            return None;
        }
        if before != [true; 3] {
            return Some(Self { min: DVec2::ZERO, max: projection.image });
        }
        let [a, b, c] = corners.map(|corner| corner.truncate() / corner.z);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        let inside = max.cmpge(DVec2::ZERO).all() && min.cmple(projection.image).all();
        inside.then(|| Self { min: min.max(DVec2::ZERO), max: max.min(projection.image) })
    }
}

/// `x * gradient.x + y * gradient.y + constant`: positive on the triangle's side of an edge.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    pub(super) gradient: DVec2,
    pub(super) constant: f64,
    /// Smallest value inside: zero for a top or left edge, else the smallest above zero, so that of two triangles at an edge
    /// exactly one owns the samples on it.
    pub(super) least: f64,
}

impl Edge {
    /// The edge from `a` to `b`. With `a` and `b` exchanged every coefficient is exactly negated, and so is, at any sample, the
    /// rounded sum: a sample is inside at most one of two triangles on either side of an edge, and outside at most one.
    #[inline(always)]
    fn new(a: DVec3, b: DVec3, sign: f64) -> Self {
        let plane = a.cross(b) * sign;
        let top_left = plane.x > 0.0 || (plane.x == 0.0 && plane.y > 0.0);
        let least = if top_left { 0.0 } else { f64::from_bits(1) };
        Self { gradient: plane.truncate(), constant: plane.z, least }
    }

    /// The part of the sum that the samples of a row share.
    #[inline]
    pub(super) fn row(&self, y: f64) -> f64 {
        self.gradient.y * y + self.constant
    }

    /// Whether a sample of that row is inside.
    #[inline]
    pub(super) fn is_inside(&self, x: f64, row: f64) -> bool {
        self.gradient.x * x + row >= self.least
    }

    /// Whether some point of the rectangle is inside.
    #[inline]
    fn reaches(&self, min: DVec2, max: DVec2) -> bool {
        let corner = DVec2::select(self.gradient.cmpge(DVec2::ZERO), max, min);
        self.gradient.dot(corner) + self.constant > 0.0
    }
}

/// A triangle ready to be drawn.
pub(super) struct ScreenTriangle {
    pub(super) edges: [Edge; 3],
    /// 1/w as a plane over the image.
    inverse_w: DVec3,
    /// Smallest and largest 1/w of what is visible, to which fragments are held: the plane of a triangle seen nearly edge-on is
    /// steep.
    inverse_w_range: [f64; 2],
    pub(super) bounds: Bounds,
}

impl ScreenTriangle {
    /// Sets a triangle up, or `None` where it covers nothing.
    #[inline(always)]
    pub(super) fn new(corners: [DVec3; 3], projection: &Projection) -> Option<Self> {
        let bounds = Bounds::new(corners, projection)?;
        let normal = normal(corners);
        let volume = volume(corners, normal)?;
        let sign = volume.signum();
        let [a, b, c] = corners;
        let inverse = corners.map(|corner| 1.0 / corner.z);
        let nearest = if corners.iter().all(|corner| corner.z > 0.0) {
            inverse.into_iter().fold(0.0, f64::max)
        } else {
            f64::INFINITY
        };
        let farthest = inverse.into_iter().filter(|&inverse| inverse > 0.0).fold(f64::INFINITY, f64::min);
        Some(Self {
            edges: [Edge::new(a, b, sign), Edge::new(b, c, sign), Edge::new(c, a, sign)],
            inverse_w: normal / volume,
            inverse_w_range: [farthest, nearest],
            bounds,
        })
    }

    /// 1/w at a sample, as the depth attachment holds it.
    #[inline]
    pub(super) fn inverse_w(&self, x: f64, y: f64) -> f32 {
        let plane = self.inverse_w;
        let [farthest, nearest] = self.inverse_w_range;
        (plane.x * x + (plane.y * y + plane.z)).max(farthest).min(nearest) as f32
    }

    /// Whether the projection overlaps the rectangle: its bounds and each edge against it, as binning hardware tests. Beyond an
    /// acute corner it may say yes to a rectangle that is only near.
    #[inline]
    pub(super) fn overlaps(&self, rect: TileRect) -> bool {
        let min = DVec2::new(f64::from(rect.x), f64::from(rect.y));
        let max = min + DVec2::new(f64::from(rect.width), f64::from(rect.height));
        self.bounds.min.cmplt(max).all()
            && self.bounds.max.cmpgt(min).all()
            && self.edges.iter().all(|edge| edge.reaches(min, max))
    }
}
