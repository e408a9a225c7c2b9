//! Grid traversal by the 3D-DDA of Amanatides & Woo 1987: from each cell the ray goes on through the nearest of the three planes
//! ahead.
//!
//! The distance of a plane is computed from the plane each time, and never by adding up steps: sums would drift from cell to
//! cell, and the cells of a ray would no longer follow each other without gaps. So the interval of a cell begins at the
//! very number at which the one before it ends, and the margin of the references covers the rounding of that number.
//!
//! A hit is accepted when it lies before the end of the cell; one that lies behind is kept, since a later cell may hold a nearer
//! one. A triangle that is hit before the end of a cell is listed in that cell or an earlier one.

use super::cells::Grid;
use crate::alpha::RayQuery;
use crate::leaf;
use crate::observe::{Observer, Op};
use crate::plane_ray::{PlaneRay, RayAxis};
use crate::ray::{Hit, Ray};
use crate::triangle::RayTriangle;

/// The ray's place on one axis.
#[derive(Clone, Copy)]
struct Walk<'a> {
    axis: RayAxis,
    planes: &'a [f32],
    /// Coordinate of the cell.
    cell: u32,
    /// Distance of the plane ahead; infinite in the outermost cell.
    ahead: f32,
}

impl<'a> Walk<'a> {
    /// The place at distance `t`. `guess` is a cell near it. The outermost planes are infinite, which ends the loops.
    fn new(axis: RayAxis, planes: &'a [f32], guess: u32, t: f32) -> Self {
        let mut walk = Self { axis, planes, cell: guess, ahead: 0.0 };
        while walk.distance(1 - axis.near) < t {
            walk.cell = walk.cell.wrapping_add(walk.direction());
        }
        while walk.distance(axis.near) > t {
            walk.cell = walk.cell.wrapping_sub(walk.direction());
        }
        walk.look_ahead();
        walk
    }

    /// 1, or -1 modulo 2^32.
    #[inline(always)]
    fn direction(&self) -> u32 {
        1_u32.wrapping_sub(2 * self.axis.near)
    }

    /// Distance of the cell's lower (0) or upper (1) plane.
    #[inline(always)]
    fn distance(&self, side: u32) -> f32 {
        self.axis.distance(self.planes[(self.cell + side) as usize])
    }

    /// A distance that overflow has made NaN is never reached.
    #[inline(always)]
    fn look_ahead(&mut self) {
        self.ahead = self.distance(1 - self.axis.near).min(f32::INFINITY);
    }

    /// Goes on to the next cell.
    #[inline(always)]
    fn step(&mut self) {
        self.cell = self.cell.wrapping_add(self.direction());
        self.look_ahead();
    }
}

/// Traces one ray. Each step leaves a cell for good on one axis, which bounds the loop by the cells along all axes: there is
/// nothing to stall on.
#[inline]
pub fn trace<P: RayTriangle, Q: RayQuery, O: Observer>(
    grid: &Grid<P>,
    ray: &Ray,
    query: Q,
    observer: &mut O,
) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let prepared = P::prepare(ray);
    let Some((plane_ray, interval)) = PlaneRay::new(&grid.slack, ray, observer) else { return best };
    let [nx, ny, _] = grid.resolution;
    let strides = [1, nx, nx * ny];
    let low = grid.slack.scene().min;
    let mut walks = [0, 1, 2].map(|axis| {
        let place = ray.origin[axis] + interval.entry * ray.direction[axis];
        let guess = ((place - low[axis]) * grid.cells_per_length[axis]) as u32;
        Walk::new(
            plane_ray.axes[axis],
            &grid.planes[axis],
            guess.min(grid.resolution[axis] - 1),
            interval.entry,
        )
    });
    let mut cell: u32 = (0..3).map(|axis| walks[axis].cell * strides[axis]).sum();
    loop {
        observer.step(Op::Node, cell);
        let first = grid.starts[cell as usize];
        let count = grid.starts[cell as usize + 1] - first;
        let answered = leaf::intersect(grid.leaves(), (first, count), prepared, query, &mut best, observer);
        let [x, y, z] = walks.map(|walk| walk.ahead);
        let axis = if x < y {
            if x < z { 0 } else { 2 }
        } else if y < z {
            1
        } else {
            2
        };
        let end = walks[axis].ahead;
        if answered || end >= best.t || end >= interval.exit {
            return best;
        }
        walks[axis].step();
        cell = cell.wrapping_add(strides[axis].wrapping_mul(walks[axis].direction()));
    }
}
