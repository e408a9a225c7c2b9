//! Coverage and depth of one triangle in one tile.
//!
//! The rounded edge functions grow or fall along a row as the exact ones do, so the samples inside an edge are found at its
//! crossing, and an edge that all four corner samples are inside of needs no test. A row whose farthest fragment is nearer than
//! the triangle can be is counted without testing its depths. Both give what testing every sample would.

use super::TileDraw;
use super::setup::{Edge, ScreenTriangle};
use crate::ray::NO_HIT;
use crate::trace::{TILE_EDGE, TileRect};
use std::ops::Range;

/// How far outside a triangle's bounds a sample may lie, in pixels, and still be tested: more than any rounding of the bounds.
const BOUNDS_SLACK: f64 = 1.0 / 256.0;

const EDGE: usize = TILE_EDGE as usize;

/// The depth attachment and the visible triangles of a tile.
#[derive(Clone, Debug, Default)]
pub(super) struct TilePixels {
    /// The upper left sample, in pixels of the image.
    sample: [f64; 2],
    /// Pixels per row and column.
    size: [usize; 2],
    /// 1/w of the nearest fragment so far, 0 at the far end; in rows.
    inverse_w: Vec<f32>,
    visible: Vec<u32>,
    /// Per row, the smallest of `inverse_w`, or less.
    farthest: [f32; EDGE],
}

impl TilePixels {
    /// Begins a tile: nothing drawn.
    pub(super) fn clear(&mut self, rect: TileRect) {
        self.sample = [f64::from(rect.x) + 0.5, f64::from(rect.y) + 0.5];
        self.size = [rect.width as usize, rect.height as usize];
        let pixels = self.size[0] * self.size[1];
        self.inverse_w.clear();
        self.inverse_w.resize(pixels, 0.0);
        self.visible.clear();
        self.visible.resize(pixels, NO_HIT);
        self.farthest = [0.0; EDGE];
    }

    pub(super) fn visible(&self) -> &[u32] {
        &self.visible
    }

    /// Draws a triangle over what was drawn before.
    pub(super) fn draw(&mut self, triangle: u32, screen: &ScreenTriangle) -> TileDraw {
        let mut draw = TileDraw { triangle, covered: 0, passed: 0, quads: 0 };
        let columns = self.within(0, screen.bounds.min.x, screen.bounds.max.x);
        let rows = self.within(1, screen.bounds.min.y, screen.bounds.max.y);
        if columns.is_empty() || rows.is_empty() {
            return draw;
        }
        let x = [columns.start, columns.end - 1].map(|column| self.sample[0] + column as f64);
        let y = [rows.start, rows.end - 1].map(|row| self.sample[1] + row as f64);
        let corners = [[x[0], y[0]], [x[1], y[0]], [x[0], y[1]], [x[1], y[1]]];
        let mut crossings = [const { None }; 3];
        let mut crossed = 0;
        for edge in &screen.edges {
            if corners.iter().any(|&[x, y]| !edge.is_inside(x, edge.row(y))) {
                crossings[crossed] = Some(Crossing::new(edge, self.sample[0]));
                crossed += 1;
            }
        }
        let nearest = corners.map(|[x, y]| screen.inverse_w(x, y)).into_iter().fold(0.0, f32::max);
        // Bit `i` for a pixel `i` that passed in the upper row of the quads at work.
        let mut upper = 0_u32;
        for row in rows.clone() {
            let y = self.sample[1] + row as f64;
            let mut span = columns.clone();
            for crossing in crossings[..crossed].iter().flatten() {
                span = crossing.inside(y, span);
                if span.is_empty() {
                    break;
                }
            }
            draw.covered += span.len() as u32;
            let passed = if span.is_empty() || nearest <= self.farthest[row] {
                0
            } else {
                self.depth_test(span, row, y, triangle, screen)
            };
            draw.passed += passed.count_ones();
            upper |= passed;
            if row % 2 == 1 || row + 1 == rows.end {
                draw.quads += ((upper | upper >> 1) & 0x5555_5555).count_ones();
                upper = 0;
            }
        }
        draw
    }

    /// The pixels along an axis, from the tile's edge, whose samples lie between two bounds.
    fn within(&self, axis: usize, min: f64, max: f64) -> Range<usize> {
        let size = self.size[axis] as f64;
        // Truncated, as neither is below zero: the next whole number, and the one after the last.
        let first = (min - BOUNDS_SLACK - self.sample[axis] + 1.0).clamp(0.0, size);
        let end = (max + BOUNDS_SLACK - self.sample[axis] + 1.0).clamp(0.0, size);
        first as usize..end as usize
    }

    /// Tests and writes the depths of a row's covered pixels; bit `i` for a pixel `i` that passed.
    fn depth_test(
        &mut self,
        span: Range<usize>,
        row: usize,
        y: f64,
        triangle: u32,
        screen: &ScreenTriangle,
    ) -> u32 {
        let start = row * self.size[0];
        let depths = &mut self.inverse_w[start..start + self.size[0]];
        let visible = &mut self.visible[start..start + self.size[0]];
        let mut passed = 0;
        for column in span {
            let inverse_w = screen.inverse_w(self.sample[0] + column as f64, y);
            if inverse_w > depths[column] {
                depths[column] = inverse_w;
                visible[column] = triangle;
                passed |= 1 << column;
            }
        }
        if passed != 0 {
            self.farthest[row] = smallest(depths);
        }
        passed
    }
}

/// The smallest of values that are not NaN, eight side by side so that vector operations serve.
#[inline]
fn smallest(values: &[f32]) -> f32 {
    let lesser = |a: f32, b: f32| if b < a { b } else { a };
    let (eights, rest) = values.as_chunks::<8>();
    let lanes = eights
        .iter()
        .fold([f32::INFINITY; 8], |lanes, eight| std::array::from_fn(|i| lesser(lanes[i], eight[i])));
    lanes.iter().chain(rest).copied().fold(f32::INFINITY, lesser)
}

/// Where an edge crosses the rows of a tile.
struct Crossing<'a> {
    edge: &'a Edge,
    /// The sample of pixel 0.
    first_x: f64,
    /// The pixel after the crossing is about `slope * y + start`.
    slope: f64,
    start: f64,
}

impl<'a> Crossing<'a> {
    #[inline]
    fn new(edge: &'a Edge, first_x: f64) -> Self {
        let inverse = -1.0 / edge.gradient.x;
        let start = edge.constant * inverse - first_x + 1.0;
        Self { edge, first_x, slope: edge.gradient.y * inverse, start }
    }

    /// The part of a row's span, which is not empty, whose samples are inside.
    #[inline]
    fn inside(&self, y: f64, span: Range<usize>) -> Range<usize> {
        let Range { start, end } = span;
        let row = self.edge.row(y);
        let is_inside = |column: usize| self.edge.is_inside(self.first_x + column as f64, row);
        // Right but for rounding; the samples beside it decide. Without a crossing it is any pixel.
        let guess = (self.slope * y + self.start).max(start as f64).min(end as f64) as usize;
        let mut pixel = guess;
        if self.edge.gradient.x > 0.0 {
            while pixel > start && is_inside(pixel - 1) {
                pixel -= 1;
            }
            while pixel < end && !is_inside(pixel) {
                pixel += 1;
            }
            pixel..end
        } else {
            while pixel > start && !is_inside(pixel - 1) {
                pixel -= 1;
            }
            while pixel < end && is_inside(pixel) {
                pixel += 1;
            }
            start..pixel
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::setup::Projection;
    use super::*;
    use glam::DVec3;

    /// Draws triangles given in pixels at depth 1 over an 8x8 image; per pixel, how often it was covered.
    fn covered(triangles: &[[[f64; 2]; 3]]) -> [[u32; 8]; 8] {
        let camera = scenes::Camera {
            eye: glam::Vec3::ZERO,
            target: glam::Vec3::NEG_Z,
            up: glam::Vec3::Y,
            vertical_fov_degrees: 90.0,
        };
        let projection = Projection::new(&crate::View::new(&camera, 8, 8), 8, 8);
        let mut covered = [[0; 8]; 8];
        for triangle in triangles {
            let corners = triangle.map(|[x, y]| DVec3::new(x, y, 1.0));
            let screen = ScreenTriangle::new(corners, &projection).expect("it has area");
            let mut tile = TilePixels::default();
            tile.clear(TileRect { x: 0, y: 0, width: 8, height: 8 });
            let draw = tile.draw(0, &screen);
            assert_eq!(draw.covered as usize, tile.visible().iter().filter(|&&seen| seen == 0).count());
            for (pixel, &seen) in tile.visible().iter().enumerate() {
                covered[pixel / 8][pixel % 8] += u32::from(seen == 0);
            }
        }
        covered
    }

    #[test]
    fn samples_on_a_top_or_left_edge_are_inside_and_on_others_outside() {
        let [a, b, c, d] = [[1.5, 1.5], [4.5, 1.5], [4.5, 3.5], [1.5, 3.5]];
        for triangles in [[[a, b, c], [a, c, d]], [[b, a, d], [d, c, b]]] {
            let covered = covered(&triangles);
            for (y, row) in covered.iter().enumerate() {
                for (x, &times) in row.iter().enumerate() {
                    let inside = (1..4).contains(&x) && (1..3).contains(&y);
                    assert_eq!(times, u32::from(inside), "pixel {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn a_mesh_whose_vertices_and_edges_meet_samples_covers_each_once() {
        // Squares of two pixels with corners on samples, cut along diagonals through samples, wound either way.
        let mut triangles = Vec::new();
        for (i, j) in (0..3).flat_map(|j| (0..3).map(move |i| (i, j))) {
            let corner = |di: i32, dj: i32| [f64::from(2 * (i + di)) + 0.5, f64::from(2 * (j + dj)) + 0.5];
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            match (i + j) % 3 {
                0 => triangles.extend([[a, b, c], [a, c, d]]),
                1 => triangles.extend([[b, a, d], [d, b, c]]),
                _ => {
                    let middle = corner(0, 0).map(|edge| edge + 1.0);
                    triangles.extend([[a, b, middle], [b, c, middle], [middle, c, d], [d, middle, a]]);
                }
            }
        }
        let covered = covered(&triangles);
        for (y, row) in covered.iter().enumerate() {
            for (x, &times) in row.iter().enumerate() {
                assert_eq!(times, u32::from(x < 6 && y < 6), "pixel {x}, {y}");
            }
        }
    }

    #[test]
    fn the_smallest_of_a_row_of_any_length_is_found() {
        for length in 1..=EDGE {
            for place in 0..length {
                let mut values = vec![2.0; length];
                values[place] = 1.0;
                assert!(smallest(&values) <= 1.0 && smallest(&values) >= 1.0, "{place} of {length}");
            }
        }
    }
}
