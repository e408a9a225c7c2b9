//! What a kd-tree is built for.

use crate::error::Error;

/// How large a triangle is taken to be inside a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Splits {
    /// Its bounding box, clamped to the cell: no triangle is clipped (Sousa et al. 2019). A cell may then hold a triangle
    /// whose box it meets but which lies outside.
    BoundingBox,
    /// The part of the triangle inside the cell (Wald & Havran 2006, "perfect splits").
    Perfect,
}

/// Whether a plane may lie in a face of the cell that it splits, so that one child has no thickness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FlatCells {
    /// It may, where the flat child holds triangles.
    Allowed,
    /// It may not (Sousa et al. 2019, for backtracking).
    Forbidden,
}

/// Options of [`KdTree::build`](super::KdTree::build).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdOptions {
    /// Cost of visiting an inner node, Ct; finite, at least 0.
    pub traversal_cost: f64,
    /// Cost of testing a triangle, Ci; finite, above 0.
    pub intersection_cost: f64,
    /// Lambda: the cost of a split with an empty side is multiplied by it; above 0, at most 1 (no bonus).
    pub empty_bonus: f64,
    /// Extent of a triangle inside a cell.
    pub splits: Splits,
    /// Whether cells without thickness are made.
    pub flat_cells: FlatCells,
    /// Longest path from the root, in edges, at most [`KdOptions::MAX_DEPTH`]. `None`: `round(8 + 1.3 log2 N)`, the rule of
    /// Pharr et al., "Physically Based Rendering". Deeper trees gain almost nothing: on real scenes a cap of 64 doubles the nodes
    /// and lowers the expected cost by about 0.01 %.
    pub max_depth: Option<u32>,
}

impl KdOptions {
    /// Largest depth that the traversals can hold: one bit of a 64-bit word for each level.
    pub const MAX_DEPTH: u32 = 64;

    /// Most triangles that a tree can hold.
    pub const MAX_TRIANGLES: usize = 1 << 27;

    /// Leaves never hold more than this many references per triangle, plus [`KdOptions::FREE_REFERENCES`]; a split that would
    /// pass this bound, or a cell's share of it, is not made. Real scenes need 3 to 8.
    pub const REFERENCES_PER_TRIANGLE: u64 = 32;

    /// See [`KdOptions::REFERENCES_PER_TRIANGLE`].
    pub const FREE_REFERENCES: u64 = 1024;

    /// Sousa et al. 2019: Ct = 3, Ci = 1.5, no bonus, no clipping.
    pub const MOBILE: Self = Self {
        traversal_cost: 3.0,
        intersection_cost: 1.5,
        empty_bonus: 1.0,
        splits: Splits::BoundingBox,
        flat_cells: FlatCells::Allowed,
        max_depth: None,
    };

    /// Wald & Havran 2006: Kt = 15, Ki = 20, lambda = 0.8, perfect splits.
    pub const WALD_HAVRAN: Self = Self {
        traversal_cost: 15.0,
        intersection_cost: 20.0,
        empty_bonus: 0.8,
        splits: Splits::Perfect,
        flat_cells: FlatCells::Allowed,
        max_depth: None,
    };

    /// The depth cap for `triangles` triangles.
    pub fn depth_cap(&self, triangles: usize) -> u32 {
        self.max_depth.unwrap_or_else(|| {
            let levels = 8.0 + 1.3 * (triangles.max(1) as f64).log2();
            (levels.round() as u32).min(Self::MAX_DEPTH)
        })
    }

    pub(super) fn check(&self, triangles: usize) -> Result<(), Error> {
        let Self { traversal_cost: ct, intersection_cost: ci, empty_bonus: lambda, max_depth, .. } = *self;
        if !(ct.is_finite() && ct >= 0.0 && ci.is_finite() && ci > 0.0) {
            return Err(Error::Options(format!(
                "kd-tree costs Ct = {ct}, Ci = {ci}: expected finite numbers, Ct at least 0 and Ci above 0; the defaults are 3 and 1.5"
            )));
        }
        if !(lambda > 0.0 && lambda <= 1.0) {
            return Err(Error::Options(format!(
                "kd-tree empty-space bonus {lambda}: expected a factor above 0 and at most 1; 1 gives no bonus"
            )));
        }
        if let Some(depth) = max_depth.filter(|&depth| depth > Self::MAX_DEPTH) {
            return Err(Error::Options(format!(
                "kd-tree depth cap {depth}: expected at most {}; leave it out for a cap by the number of triangles",
                Self::MAX_DEPTH
            )));
        }
        if triangles > Self::MAX_TRIANGLES {
            return Err(Error::Options(format!(
                "{triangles} triangles: a kd-tree holds at most {}; divide the scene",
                Self::MAX_TRIANGLES
            )));
        }
        Ok(())
    }
}

impl Default for KdOptions {
    fn default() -> Self {
        Self::MOBILE
    }
}
