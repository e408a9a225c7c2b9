//! Hierarchical bins: which triangles may overlap a tile.
//!
//! Bins of 1, 2, 4, ... tiles edge length, up to one over the image. A triangle goes to the finest level at which its bounds
//! touch at most 2x2 bins, so it costs at most four entries however large it is. A tile looks through one bin of each level.

use super::setup::{Bounds, Projection};
use crate::trace::{TILE_EDGE, TileRect};
use rayon::prelude::*;
use scenes::Triangle;

/// Triangles that a thread bins at a time.
const CHUNK: usize = 1 << 14;

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

        let last_tile = [columns - 1, rows - 1];
        let chunks: Vec<Vec<(usize, u32)>> = triangles
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, triangles)| {
                let mut entries = Vec::with_capacity(triangles.len() * 2);
                for (triangle, index) in triangles.iter().zip((chunk * CHUNK) as u32..) {
                    if let Some(bounds) = Bounds::new(projection.corners(triangle), projection) {
                        entries.extend(touched(&levels, &bounds, last_tile).map(|bin| (bin, index)));
                    }
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

/// The at most four bins of the finest level that holds the bounds so.
fn touched(levels: &[Level], bounds: &Bounds, last_tile: [usize; 2]) -> impl Iterator<Item = usize> {
    let tile = |pixels: f64, axis: usize| ((pixels / f64::from(TILE_EDGE)) as usize).min(last_tile[axis]);
    let min = [tile(bounds.min.x, 0), tile(bounds.min.y, 1)];
    let max = [tile(bounds.max.x, 0), tile(bounds.max.y, 1)];
    let fits = |shift: usize| (0..2).all(|axis| (max[axis] >> shift) - (min[axis] >> shift) <= 1);
    let shift = (0..levels.len() - 1).find(|&shift| fits(shift)).unwrap_or(levels.len() - 1);
    let Level { first_bin, columns } = levels[shift];
    let [left, top, right, bottom] = [min[0], min[1], max[0], max[1]].map(|tile| tile >> shift);
    (top..=bottom).flat_map(move |row| (left..=right).map(move |column| first_bin + row * columns + column))
}
