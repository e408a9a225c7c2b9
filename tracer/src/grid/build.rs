//! Building a grid: boxes are sorted into cells by counting (Lagae & Dutré 2008). No triangle is clipped.

use super::cells::Grid;
use super::resolution::resolution;
use crate::aabb::{Aabb, PlaneSlack};
use crate::bvh::MAX_TRIANGLES;
use crate::error::Error;
use crate::triangle::RayTriangle;
use glam::DVec3;
use scenes::Triangle;

impl Grid {
    /// All cells together hold at most this many references per triangle, plus [`Grid::FREE_REFERENCES`]; a grid that would hold
    /// more is made with half the cells along each axis. Scenes that we measured need 4 to 17.
    pub const REFERENCES_PER_TRIANGLE: u64 = 32;

    /// See [`Grid::REFERENCES_PER_TRIANGLE`].
    pub const FREE_REFERENCES: u64 = 1024;

    /// Most references of a grid, however many triangles it has.
    pub const MAX_REFERENCES: u64 = 1 << 28;

    /// [`Grid::build_for`] the test of Moller & Trumbore.
    ///
    /// # Errors
    /// As [`Grid::build_for`].
    pub fn build(triangles: &[Triangle]) -> Result<Self, Error> {
        Self::build_for(triangles)
    }
}

impl<P: RayTriangle> Grid<P> {
    /// Builds a grid over `triangles` (finite corners; degenerate ones are welcome). Time and memory are linear in cells and
    /// references, both of which are bounded.
    ///
    /// # Errors
    /// Too many triangles, a corner that is not finite.
    pub fn build_for(triangles: &[Triangle]) -> Result<Self, Error> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(Error::Options(format!(
                "{} triangles: a grid holds at most {MAX_TRIANGLES}; split the scene",
                triangles.len()
            )));
        }
        if let Some(index) = triangles.iter().position(|t| !t.v.iter().all(|corner| corner.is_finite())) {
            return Err(Error::Options(format!(
                "triangle {index} has a corner that is not finite; remove it before building a grid"
            )));
        }
        let boxes: Vec<Aabb> = triangles.iter().map(Aabb::of_triangle).collect();
        let slack = PlaneSlack::new(&boxes);
        let limit = Grid::REFERENCES_PER_TRIANGLE * triangles.len() as u64 + Grid::FREE_REFERENCES;
        let limit = limit.min(Grid::MAX_REFERENCES);
        let mut lattice = Lattice::new(&slack, resolution(extent(slack.scene()), triangles.len()));
        while boxes.iter().map(|bounds| lattice.cells_met(bounds)).sum::<u64>() > limit {
            lattice = Lattice::new(&slack, lattice.resolution.map(|cells| cells.div_ceil(2)));
        }
        let (starts, references) = lattice.sort(&boxes);
        let cells_per_length = [0, 1, 2].map(|axis| {
            let length = extent(slack.scene())[axis];
            if length > 0.0 { (f64::from(lattice.resolution[axis]) / length) as f32 } else { 0.0 }
        });
        Ok(Self {
            resolution: lattice.resolution,
            planes: lattice.planes,
            margin: lattice.margin,
            cells_per_length,
            starts,
            references,
            slack,
            triangles: triangles.iter().map(P::from).collect(),
        })
    }
}

/// In f64, where extents up to `f32::MAX` do not overflow.
fn extent(bounds: &Aabb) -> DVec3 {
    bounds.max.as_dvec3() - bounds.min.as_dvec3()
}

/// The planes between the cells.
struct Lattice {
    resolution: [u32; 3],
    planes: [Vec<f32>; 3],
    margin: f32,
}

impl Lattice {
    fn new(slack: &PlaneSlack, resolution: [u32; 3]) -> Self {
        let (low, extent) = (slack.scene().min.as_dvec3(), extent(slack.scene()));
        let planes = [0, 1, 2].map(|axis| {
            let cells = resolution[axis];
            let inner = |plane| (low[axis] + extent[axis] * (f64::from(plane) / f64::from(cells))) as f32;
            let planes = std::iter::once(f32::NEG_INFINITY).chain((1..cells).map(inner));
            planes.chain([f32::INFINITY]).collect()
        });
        Self { resolution, planes, margin: slack.largest().min(f32::MAX) }
    }

    /// First and last cell, by axis, that the widened box meets. A face in a plane meets the cells on both sides.
    /// The lowest plane is below any box, the highest above: the planes found are those below a cell.
    fn range(&self, bounds: &Aabb) -> [(u32, u32); 3] {
        [0, 1, 2].map(|axis| {
            let low = f64::from(bounds.min[axis]) - f64::from(self.margin);
            let high = f64::from(bounds.max[axis]) + f64::from(self.margin);
            let planes = &self.planes[axis];
            let first = planes.partition_point(|&plane| f64::from(plane) < low) - 1;
            let last = planes.partition_point(|&plane| f64::from(plane) <= high) - 1;
            (first as u32, last as u32)
        })
    }

    fn cells_met(&self, bounds: &Aabb) -> u64 {
        self.range(bounds).iter().map(|&(first, last)| u64::from(last - first) + 1).product()
    }

    fn for_each_cell(&self, bounds: &Aabb, mut visit: impl FnMut(usize)) {
        let [(x_first, x_last), (y_first, y_last), (z_first, z_last)] = self.range(bounds);
        let [nx, ny, _] = self.resolution;
        for z in z_first..=z_last {
            for y in y_first..=y_last {
                let row = nx * (y + ny * z);
                (row + x_first..=row + x_last).for_each(|cell| visit(cell as usize));
            }
        }
    }

    /// First reference of each cell with the end of the last, and the references: rising triangle indices in each cell.
    fn sort(&self, boxes: &[Aabb]) -> (Vec<u32>, Vec<u32>) {
        let cells: u32 = self.resolution.iter().product();
        let mut starts = vec![0_u32; cells as usize + 1];
        for bounds in boxes {
            self.for_each_cell(bounds, |cell| starts[cell] += 1);
        }
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        let mut references = vec![0; end as usize];
        for (triangle, bounds) in (0..boxes.len() as u32).zip(boxes).rev() {
            self.for_each_cell(bounds, |cell| {
                starts[cell] -= 1;
                references[starts[cell] as usize] = triangle;
            });
        }
        (starts, references)
    }
}
