//! The grid as data.

use crate::aabb::{Aabb, PlaneSlack};
use crate::leaf::References;
use crate::triangle::{PreparedTriangle, RayTriangle};
use std::ops::Range;

/// A uniform grid over triangles, prepared for a test as `P`. Cell `x + nx * (y + ny * z)` holds the triangles whose boxes, widened by
/// [`Grid::margin`], meet it. The outermost cells reach to infinity.
///
/// In memory a cell is one index, as in the compact grid of Lagae & Dutré 2008: its references end where those of the next begin.
#[derive(Clone, Debug)]
pub struct Grid<P: RayTriangle = PreparedTriangle> {
    pub(super) resolution: [u32; 3],
    /// By axis, the planes below each cell and above the last one: the first is minus, the last plus infinity. A shader computes
    /// them: `min + index * width`.
    pub(super) planes: [Vec<f32>; 3],
    pub(super) margin: f32,
    /// By axis, cells per unit of length.
    pub(super) cells_per_length: [f32; 3],
    /// First reference of each cell, and the end of the last.
    pub(super) starts: Vec<u32>,
    pub(super) references: Vec<u32>,
    pub(super) slack: PlaneSlack,
    /// Triangles in file order, prepared for the test.
    pub(super) triangles: Vec<P>,
}

/// Counts over a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GridStatistics {
    /// All cells.
    pub cells: u64,
    /// Cells without references.
    pub empty_cells: u64,
    /// References of all cells together.
    pub references: u64,
    /// References of the fullest cell.
    pub largest_cell: u64,
}

impl<P: RayTriangle> Grid<P> {
    /// Cells along x, y and z.
    pub fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    /// Number of cells.
    pub fn cell_count(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// The planes below the cells of an axis, in order, and the one above the last; the outermost ones are infinite.
    pub fn planes(&self, axis: usize) -> &[f32] {
        &self.planes[axis]
    }

    /// Positions of a cell's references in the reference list.
    pub fn cell(&self, cell: u32) -> Range<u32> {
        self.starts[cell as usize]..self.starts[cell as usize + 1]
    }

    /// Triangle indices (file order) of all cells, cell after cell, rising within a cell.
    pub fn references(&self) -> &[u32] {
        &self.references
    }

    /// Box of the whole scene; [`Aabb::EMPTY`] without triangles.
    pub fn bounds(&self) -> Aabb {
        *self.slack.scene()
    }

    /// By how much boxes are widened on each side before they are listed: the largest slack of any ray.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Expected cost of a random ray that meets the scene's box, if it went on to the box's end: a cell is met with the share that
    /// its area has of the box's (MacDonald & Booth 1990), and costs `traversal_cost`, and `intersection_cost` for each
    /// reference. `None` for a box without area.
    pub fn sah_cost(&self, traversal_cost: f64, intersection_cost: f64) -> Option<f64> {
        let bounds = self.bounds();
        let d = bounds.extent().as_dvec3() / glam::UVec3::from_array(self.resolution).as_dvec3();
        let cell_area = d.x * d.y + d.y * d.z + d.z * d.x;
        let cost =
            traversal_cost * f64::from(self.cell_count()) + intersection_cost * self.references.len() as f64;
        (bounds.half_area() > 0.0).then(|| cost * cell_area / bounds.half_area())
    }

    /// Counts cells and references.
    pub fn statistics(&self) -> GridStatistics {
        let counts = || self.starts.windows(2).map(|pair| u64::from(pair[1] - pair[0]));
        GridStatistics {
            cells: u64::from(self.cell_count()),
            empty_cells: counts().filter(|&count| count == 0).count() as u64,
            references: self.references.len() as u64,
            largest_cell: counts().max().unwrap_or(0),
        }
    }

    /// What its cells refer to.
    #[inline(always)]
    pub(super) fn leaves(&self) -> References<'_, P> {
        References { list: &self.references, triangles: &self.triangles }
    }
}
