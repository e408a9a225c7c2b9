//! Coverage and depth of one triangle in one tile, sample by sample.

use super::TileDraw;
use super::setup::{Edge, ScreenTriangle};
use crate::ray::NO_HIT;
use crate::trace::TileRect;

/// How far outside a triangle's bounds a sample may lie, in pixels, and still be tested: more than any rounding of the bounds.
const BOUNDS_SLACK: f64 = 1.0 / 256.0;

/// The depth attachment and the visible triangles of a tile.
#[derive(Clone, Debug, Default)]
pub(super) struct TilePixels {
    /// Upper left pixel, and pixels per row and column.
    corner: [u32; 2],
    size: [usize; 2],
    /// 1/w of the nearest fragment so far, 0 at the far end; in rows.
    inverse_w: Vec<f32>,
    visible: Vec<u32>,
}

impl TilePixels {
    /// Begins a tile: nothing drawn.
    pub(super) fn clear(&mut self, rect: TileRect) {
        self.corner = [rect.x, rect.y];
        self.size = [rect.width as usize, rect.height as usize];
        let pixels = self.size[0] * self.size[1];
        self.inverse_w.clear();
        self.inverse_w.resize(pixels, 0.0);
        self.visible.clear();
        self.visible.resize(pixels, NO_HIT);
    }

    pub(super) fn visible(&self) -> &[u32] {
        &self.visible
    }

    /// Draws a triangle over what was drawn before.
    pub(super) fn draw(&mut self, triangle: u32, screen: &ScreenTriangle) -> TileDraw {
        let mut draw = TileDraw { triangle, covered: 0, passed: 0, quads: 0 };
        let [left, right] = self.span(0, screen.bounds.min.x, screen.bounds.max.x);
        let [top, bottom] = self.span(1, screen.bounds.min.y, screen.bounds.max.y);
        // Pixels that passed in the upper row of the quads at work.
        let mut upper = 0;
        for row in top..bottom {
            let y = f64::from(self.corner[1]) + row as f64 + 0.5;
            let covered = self.covered(&screen.edges, left..right, y);
            let passed = if covered == 0 { 0 } else { self.depth_test(covered, row, y, triangle, screen) };
            draw.covered += covered.count_ones();
            draw.passed += passed.count_ones();
            if row % 2 == 0 {
                upper = passed;
            }
            if row % 2 == 1 || row + 1 == bottom {
                let quads = if row % 2 == 1 { upper | passed } else { upper };
                draw.quads += ((quads | quads >> 1) & 0x5555_5555).count_ones();
            }
        }
        draw
    }

    /// The pixels along an axis, from the tile's edge, whose samples lie between two bounds.
    fn span(&self, axis: usize, min: f64, max: f64) -> [usize; 2] {
        let edge = f64::from(self.corner[axis]) + 0.5;
        let size = self.size[axis] as f64;
        let first = (min - BOUNDS_SLACK - edge).ceil().clamp(0.0, size);
        let end = ((max + BOUNDS_SLACK - edge).floor() + 1.0).clamp(0.0, size);
        [first as usize, end as usize]
    }

    /// Bit `i` for pixel `i` of the row whose samples lie at `y`.
    fn covered(&self, edges: &[Edge; 3], columns: std::ops::Range<usize>, y: f64) -> u32 {
        let rows = edges.map(|edge| edge.gradient.y * y + edge.constant);
        let mut covered = 0;
        for column in columns {
            let x = f64::from(self.corner[0]) + column as f64 + 0.5;
            let inside = |i: usize| edges[i].gradient.x * x + rows[i] >= edges[i].least;
            covered |= u32::from(inside(0) & inside(1) & inside(2)) << column;
        }
        covered
    }

    /// Tests and writes the depths of covered pixels of a row; bit `i` for a pixel `i` that passed.
    fn depth_test(
        &mut self,
        covered: u32,
        row: usize,
        y: f64,
        triangle: u32,
        screen: &ScreenTriangle,
    ) -> u32 {
        let plane = screen.inverse_w;
        let [farthest, nearest] = screen.inverse_w_range;
        let start = plane.y * y + plane.z;
        let mut passed = 0;
        let mut rest = covered;
        while rest != 0 {
            let column = rest.trailing_zeros();
            rest &= rest - 1;
            let x = f64::from(self.corner[0]) + f64::from(column) + 0.5;
            let inverse_w = (plane.x * x + start).max(farthest).min(nearest) as f32;
            let pixel = row * self.size[0] + column as usize;
            if inverse_w > self.inverse_w[pixel] {
                self.inverse_w[pixel] = inverse_w;
                self.visible[pixel] = triangle;
                passed |= 1 << column;
            }
        }
        passed
    }
}
