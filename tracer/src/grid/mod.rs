//! The uniform grid: the scene's box cut into equal cells, each with the triangles that may lie in it.
//!
//! The grid of Fujimoto et al. 1986, as the literature builds it: as many cells as `resolution.rs` says (Cleary et al. 1983),
//! their references in one list by a counting sort (Lagae & Dutré 2008), rays walk from cell to cell by the 3D-DDA of Amanatides &
//! Woo 1987 ([`dda`]). There is no mailbox: a triangle in several cells of a ray is tested in each of them. A mailbox is a
//! table per ray that every test reads and writes, which a GPU would have to keep in memory.
//!
//! All structures must find the same hit, bit for bit. Trees make their planes as thick as rounding asks for a ray's reach
//! ([`PlaneSlack`](crate::PlaneSlack)). A ray of a grid walks one chain of cells between planes without thickness, so the
//! triangles are made thicker: each is listed in every cell that its box meets, widened by the largest slack that any ray can ask
//! for. A ray that hits a triangle within rounding of a cell's face then finds it on either side of the face.
//! That adds 9 % to the triangle tests of primary rays on Crytek Sponza, and no cell.

mod build;
mod cells;
pub mod dda;
mod resolution;

pub use cells::{Grid, GridStatistics};
pub use resolution::{DENSITY, MAX_CELLS, MAX_CELLS_PER_AXIS};
