//! The part of a triangle inside a cell, as a box: Sutherland & Hodgman 1974, in f64, rounded outward to f32.

use super::events::Cell;
use crate::aabb::Aabb;
use glam::{DVec3, Vec3};
use scenes::Triangle;

/// A triangle cut by six planes has at most 3 + 6 corners.
const MAX_CORNERS: usize = 9;

#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec3; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    fn push(&mut self, corner: DVec3) {
        self.corners[self.len] = corner;
        self.len += 1;
    }

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.len]
    }

    /// Keeps what lies on the side `sign * (x - plane) >= 0`.
    fn cut(&self, axis: usize, plane: f64, sign: f64) -> Self {
        let mut kept = Self { corners: [DVec3::ZERO; MAX_CORNERS], len: 0 };
        let Some(&last) = self.corners().last() else { return kept };
        let mut from = last;
        for &to in self.corners() {
            let (a, b) = (sign * (from[axis] - plane), sign * (to[axis] - plane));
            // A convex polygon crosses a plane at most twice; rounding could make it look otherwise only by a corner.
            if (a < 0.0) != (b < 0.0) && kept.len < MAX_CORNERS {
                let mut crossing = from + (to - from) * (a / (a - b));
                crossing[axis] = plane;
                kept.push(crossing);
            }
            if b >= 0.0 && kept.len < MAX_CORNERS {
                kept.push(to);
            }
            from = to;
        }
        kept
    }
}

/// The box of the part of `triangle` in `cell`, faces included; `None` where there is none.
pub(super) fn clip(triangle: &Triangle, cell: &Cell) -> Option<Aabb> {
    let mut polygon = Polygon { corners: [DVec3::ZERO; MAX_CORNERS], len: 0 };
    triangle.v.iter().for_each(|corner| polygon.push(corner.as_dvec3()));
    let bounds = Aabb::of_triangle(triangle);
    for axis in 0..3 {
        let range = cell.range(axis);
        if bounds.min[axis] < range.start {
            polygon = polygon.cut(axis, range.start.into(), 1.0);
        }
        if bounds.max[axis] > range.end {
            polygon = polygon.cut(axis, range.end.into(), -1.0);
        }
    }
    let (&first, rest) = polygon.corners().split_first()?;
    let (low, high) = rest.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    let min = low.to_array().map(round_down);
    let max = high.to_array().map(round_up);
    Some(Aabb { min: Vec3::from(min).max(cell.min), max: Vec3::from(max).min(cell.max) })
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(v: [[f32; 3]; 3]) -> Triangle {
        Triangle { v: v.map(Vec3::from) }
    }

    #[test]
    fn a_triangle_inside_keeps_its_box() {
        let inside = triangle([[0.1, 0.2, 0.3], [0.9, 0.2, 0.4], [0.5, 0.8, 0.3]]);
        let cell = Cell { min: Vec3::ZERO, max: Vec3::ONE };
        assert_eq!(clip(&inside, &cell), Some(Aabb::of_triangle(&inside)));
    }

    #[test]
    fn a_corner_cut_off_shrinks_the_other_axes_too() {
        let slope = triangle([[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0]]);
        let cell = Cell { min: Vec3::new(0.0, 0.0, -1.0), max: Vec3::new(1.0, 5.0, 1.0) };
        let expected = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 1.0, 0.0) };
        assert_eq!(clip(&slope, &cell), Some(expected));
    }

    #[test]
    fn a_triangle_whose_box_meets_the_cell_but_not_itself_is_dropped() {
        let slope = triangle([[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0]]);
        let cell = Cell { min: Vec3::new(0.0, 1.0, -1.0), max: Vec3::new(0.9, 2.0, 1.0) };
        assert_eq!(clip(&slope, &cell), None);
        let touched = Cell { max: Vec3::new(1.0, 2.0, 1.0), ..cell };
        let point = Vec3::new(1.0, 1.0, 0.0);
        assert_eq!(clip(&slope, &touched), Some(Aabb { min: point, max: point }));
    }
}
