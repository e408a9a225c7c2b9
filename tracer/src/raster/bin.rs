//! Hierarchical bins: which triangles may overlap a tile.
//!
//! Bins of 1, 2, 4, ... tiles edge length, up to one over the image. A triangle goes to the finest level at which its bounds
//! touch at most [`MOST_BINS`], so its entries are few however large it is, and there to the bins that its edges reach. A tile
//! looks through one bin of each level.

use super::setup::{Bounds, Projection, ScreenTriangle};
use crate::trace::{TILE_EDGE, TileRect};
use rayon::prelude::*;
use scenes::Triangle;

/// Triangles that a thread bins at a time.
const CHUNK: usize = 1 << 14;

/// Entries of a triangle at most.
const MOST_BINS: usize = 16;

/// Bins of one size, in rows.
struct Level {
    first_bin: usize,
    columns: usize,
}

/// The bins of all levels.
pub(super) struct Bins {
    /// From single tiles up.
    levels: Vec<Level>,
    /// Where each bin's entries begin, and at last where the last one's end.
    starts: Vec<usize>,
    /// Triangles, rising within a bin.
    entries: Vec<u32>,
}

impl Bins {
    pub(super) fn new(triangles: &[Triangle], projection: &Projection, width: u32, height: u32) -> Self {
        let [columns, rows] = [width, height].map(|edge| edge.div_ceil(TILE_EDGE).max(1) as usize);
        let mut levels = Vec::new();
        let mut bins = 0;
        for shift in 0.. {
            let [columns, rows] = [columns, rows].map(|tiles| tiles.div_ceil(1 << shift));
            levels.push(Level { first_bin: bins, columns });
            bins += columns * rows;
            if columns.max(rows) == 1 {
                break;
            }
        }

        let grid = Grid { levels: &levels, last_tile: [columns - 1, rows - 1] };
        let chunks: Vec<Vec<(usize, u32)>> = triangles
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, triangles)| {
                let mut entries = Vec::with_capacity(triangles.len() * 2);
                for (triangle, index) in triangles.iter().zip((chunk * CHUNK) as u32..) {
                    grid.bin(triangle, projection, |bin| entries.push((bin, index)));
                }
                entries
            })
            .collect();

        let mut starts = vec![0; bins + 1];
        chunks.iter().flatten().for_each(|&(bin, _)| starts[bin + 1] += 1);
        for bin in 0..bins {
            starts[bin + 1] += starts[bin];
        }
        let mut entries = vec![0; starts[bins]];
        let mut next = starts.clone();
        for (bin, triangle) in chunks.into_iter().flatten() {
            entries[next[bin]] = triangle;
            next[bin] += 1;
        }
        Self { levels, starts, entries }
    }

    /// Puts every triangle that may overlap the tile into `candidates`, in file order.
    pub(super) fn candidates(&self, tile: TileRect, candidates: &mut Vec<u32>) {
        candidates.clear();
        let [column, row] = [tile.x, tile.y].map(|edge| (edge / TILE_EDGE) as usize);
        for (shift, level) in self.levels.iter().enumerate() {
            let bin = level.first_bin + (row >> shift) * level.columns + (column >> shift);
            candidates.extend(&self.entries[self.starts[bin]..self.starts[bin + 1]]);
        }
        // A stable sort merges the levels' rising runs.
        candidates.sort();
    }
}

/// Where a triangle's bins are.
struct Grid<'a> {
    levels: &'a [Level],
    last_tile: [usize; 2],
}

impl Grid<'_> {
    fn bin(&self, triangle: &Triangle, projection: &Projection, mut put: impl FnMut(usize)) {
        let corners = projection.corners(triangle);
        let Some(bounds) = Bounds::new(corners, projection) else { return };
        let tile =
            |pixels: f64, axis: usize| ((pixels / f64::from(TILE_EDGE)) as usize).min(self.last_tile[axis]);
        let min = [tile(bounds.min.x, 0), tile(bounds.min.y, 1)];
        let max = [tile(bounds.max.x, 0), tile(bounds.max.y, 1)];
        let fits = |shift: usize| {
            let [width, height] = [0, 1].map(|axis| (max[axis] >> shift) - (min[axis] >> shift) + 1);
            width * height <= MOST_BINS
        };
        let top = self.levels.len() - 1;
        let shift = (0..top).find(|&shift| fits(shift)).unwrap_or(top);
        let Level { first_bin, columns } = self.levels[shift];
        let [left, upper, right, lower] = [min[0], min[1], max[0], max[1]].map(|tile| tile >> shift);
        // Its own tiles test the edges of a triangle in a single one.
        let single = shift == 0 && min == max;
        let screen = if single { None } else { ScreenTriangle::new(corners, projection) };
        for (row, column) in (upper..=lower).flat_map(|row| (left..=right).map(move |column| (row, column))) {
            let edge = TILE_EDGE << shift;
            let rect = TileRect { x: column as u32 * edge, y: row as u32 * edge, width: edge, height: edge };
            if screen.as_ref().is_none_or(|screen| screen.overlaps(rect)) {
                put(first_bin + row * columns + column);
            }
        }
    }
}
