//! The plane of least cost by the surface area heuristic: one sweep over each axis (Wald & Havran 2006, section 4).

use super::events::{Cell, Event, EventLists};
use super::options::{FlatCells, KdOptions};

/// Which child the triangles in the plane belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlanarSide {
    Left,
    Right,
}

/// A plane and what it costs: the heuristic's cost times half the area of the cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) position: f32,
    pub(super) planar: PlanarSide,
    cost: f64,
}

/// The best split of a cell, or `None` where no split is cheaper than a leaf. Ties go to the lower axis, then to the lower
/// position.
pub(super) fn best_split(lists: &EventLists, cell: &Cell, options: &KdOptions) -> Option<Split> {
    let extent = [0, 1, 2].map(|axis| cell.extent(axis));
    let area = extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0];
    let mut best: Option<Split> = None;
    let mut bound = options.intersection_cost * f64::from(lists.count) * area;
    for axis in 0..3 {
        // A cell without thickness cannot be cut across; one without area is met by no ray.
        if extent[axis] > 0.0 && area > 0.0 {
            let sweep = AxisSweep::new(axis, &extent, cell, options, area);
            if let Some(split) = sweep.run(&lists.axes[axis], lists.count, bound) {
                bound = split.cost;
                best = Some(split);
            }
        }
    }
    best
}

struct AxisSweep {
    axis: usize,
    low: f32,
    high: f32,
    /// Half the area of a cell of zero thickness on the axis.
    face: f64,
    /// Growth of half the area per unit of thickness.
    slope: f64,
    /// Cost of the traversal step, times half the area of the cell.
    base: f64,
    ci: f64,
    lambda: f64,
    flat: bool,
}

impl AxisSweep {
    fn new(axis: usize, extent: &[f64; 3], cell: &Cell, options: &KdOptions, area: f64) -> Self {
        let (a, b) = (extent[(axis + 1) % 3], extent[(axis + 2) % 3]);
        let range = cell.range(axis);
        Self {
            axis,
            low: range.start,
            high: range.end,
            face: a * b,
            slope: a + b,
            base: options.traversal_cost * area,
            ci: options.intersection_cost,
            lambda: options.empty_bonus,
            flat: options.flat_cells == FlatCells::Allowed,
        }
    }

    #[inline(always)]
    fn cost(&self, position: f32, left: u32, right: u32) -> f64 {
        let x = f64::from(position);
        let left_area = self.face + self.slope * (x - f64::from(self.low));
        let right_area = self.face + self.slope * (f64::from(self.high) - x);
        let cost = self.base + self.ci * (left_area * f64::from(left) + right_area * f64::from(right));
        if (left == 0) | (right == 0) { self.lambda * cost } else { cost }
    }

    /// Wald & Havran count all events of a plane before they price it. Here each end is counted and then priced, and each
    /// start priced and then counted: within a plane the last end and the first start then have the full count, the others
    /// only look dearer than the plane is, and the loop needs no inner one.
    fn run(&self, events: &[Event], count: u32, bound: f64) -> Option<Split> {
        let (mut left, mut right) = (0_u32, count);
        let mut best = bound;
        let mut found = None;
        let mut at = 0;
        while at < events.len() {
            let event = events[at];
            let position = event.position();
            let inside = (position > self.low) & (position < self.high);
            if event.is_planar() {
                let planar = events[at..].iter().take_while(|other| other.same_place(event)).count();
                at += planar;
                let planar = planar as u32;
                let cost = self.cost(position, left, right);
                if (inside || self.flat && position >= self.high) && cost < best {
                    best = cost;
                    found = Some((position, PlanarSide::Right));
                }
                left += planar;
                right -= planar;
                let cost = self.cost(position, left, right);
                if (inside || self.flat && position <= self.low) && cost < best {
                    best = cost;
                    found = Some((position, PlanarSide::Left));
                }
                continue;
            }
            right -= u32::from(event.is_end());
            let cost = self.cost(position, left, right);
            if inside & (cost < best) {
                best = cost;
                // At an end the triangles in the plane are still among `right`, at a start already among `left`.
                found = Some((position, if event.is_end() { PlanarSide::Right } else { PlanarSide::Left }));
            }
            left += u32::from(event.is_start());
            at += 1;
        }
        debug_assert_eq!((left, right), (count, 0), "each triangle begins and ends once");
        found.map(|(position, planar)| Split { axis: self.axis, position, planar, cost: best })
    }
}
