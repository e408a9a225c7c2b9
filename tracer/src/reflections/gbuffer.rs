//! What each pixel shows: a triangle and its depth.

use super::pyramid::DepthPyramid;
use super::screen_ray::Projection;
use crate::accel::AccelerationStructure;
use crate::observe::Silent;
use crate::ray::{NO_HIT, Query, Ray};
use crate::trace::TILE_EDGE;
use crate::view::{Departure, RayOffset, View};
use glam::Vec3;
use rayon::prelude::*;
use scenes::Triangle;

/// The primary hits of a view, one per pixel, and their depths. Pixels are numbered in rows from the top left.
///
/// Memory: 12 bytes of each pixel for what it shows and 16/3 for the pyramid of depths.
pub struct GBuffer<'a> {
    triangles: &'a [Triangle],
    offset: RayOffset,
    view: View,
    projection: Projection,
    surfaces: Vec<Surface>,
    depth: DepthPyramid,
}

/// A triangle, or [`NO_HIT`], and where on it.
#[derive(Clone, Copy)]
struct Surface {
    triangle: u32,
    u: f32,
    v: f32,
}

const SKY: Surface = Surface { triangle: NO_HIT, u: 0.0, v: 0.0 };

impl<'a> GBuffer<'a> {
    /// Traces the primary rays of `view`, which is over `width` x `height` pixels, in parallel; hits are those of the same ray in any frame.
    pub fn trace(
        structure: &AccelerationStructure,
        triangles: &'a [Triangle],
        view: View,
        width: u32,
        height: u32,
    ) -> Self {
        let projection = Projection::new(&view);
        let pixels = width as usize * height as usize;
        let (mut surfaces, mut depths) = (vec![SKY; pixels], vec![f32::INFINITY; pixels]);
        let rows = TILE_EDGE as usize * width.max(1) as usize;
        let bands = surfaces.par_chunks_mut(rows).zip(depths.par_chunks_mut(rows)).enumerate();
        bands.for_each(|(band, (surfaces, depths))| {
            let top = band as u32 * TILE_EDGE;
            for left in (0..width).step_by(TILE_EDGE as usize) {
                for y in top..height.min(top + TILE_EDGE) {
                    for x in left..width.min(left + TILE_EDGE) {
                        let ray = view.primary_ray(x, y);
                        let hit = structure.trace(&ray, Query::Closest, &mut Silent);
                        if hit.is_hit() {
                            let place = ((y - top) * width + x) as usize;
                            surfaces[place] = Surface { triangle: hit.primitive, u: hit.u, v: hit.v };
                            depths[place] = projection.depth(ray.direction * hit.t);
                        }
                    }
                }
            }
        });
        let depth = DepthPyramid::new(width, height, depths);
        Self { triangles, offset: RayOffset::new(triangles), view, projection, surfaces, depth }
    }

    /// Pixels per row, and rows.
    pub fn size(&self) -> [u32; 2] {
        self.depth.size(0)
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u32 {
        self.surfaces.len() as u32
    }

    /// The depths.
    pub fn depth(&self) -> &DepthPyramid {
        &self.depth
    }

    /// The triangle that a pixel shows, in file order; none in the sky.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn triangle(&self, pixel: u32) -> Option<u32> {
        let triangle = self.surfaces[pixel as usize].triangle;
        (triangle != NO_HIT).then_some(triangle)
    }

    /// The point that a pixel shows; none in the sky.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn position(&self, pixel: u32) -> Option<Vec3> {
        let Surface { triangle, u, v } = self.surfaces[pixel as usize];
        let triangle = (triangle != NO_HIT).then(|| &self.triangles[triangle as usize])?;
        let [a, b, c] = triangle.v;
        Some(a + (b - a) * u + (c - a) * v)
    }

    /// Direction of the ray through a pixel, of unit length.
    pub fn incoming(&self, pixel: u32) -> Vec3 {
        let [width, _] = self.size();
        self.view.primary_ray(pixel % width, pixel / width).direction
    }

    /// Where rays leave what a pixel shows; none in the sky.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn departure(&self, pixel: u32) -> Option<Departure> {
        let Surface { triangle, u, v } = self.surfaces[pixel as usize];
        let triangle = (triangle != NO_HIT).then(|| &self.triangles[triangle as usize])?;
        Some(self.offset.departure(triangle, u, v, self.incoming(pixel)))
    }

    /// Whether what a pixel shows turns to `ray` the side that the camera sees.
    pub(super) fn faces(&self, [x, y]: [u32; 2], ray: &Ray) -> bool {
        let [width, _] = self.size();
        self.departure(y * width + x).is_some_and(|surface| surface.normal.dot(ray.direction) < 0.0)
    }

    pub(super) fn projection(&self) -> &Projection {
        &self.projection
    }
}
