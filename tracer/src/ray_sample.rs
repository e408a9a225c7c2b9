//! The rays of a regular sample of pixels, kept while a source's tiles are made for something else.

use crate::error::Error;
use crate::topology::Topology;
use crate::trace::{Frame, RaySet, Step, Tile, TileOutline, TileRect, TileSource, TraceHeader};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// One ray of a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SampledRay {
    /// What it did.
    pub steps: Vec<Step>,
    /// As [`RaySet::hits`](crate::RaySet::hits).
    pub hit: u32,
}

/// The rays of pixels at even distances.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RaySample {
    /// Pixels from one to the next, across and down.
    pub every: u32,
    /// The first pixel.
    pub first: [u32; 2],
    /// Pixels of the sample across and down.
    pub size: [u32; 2],
    /// Pixel by pixel in rows; of each, a ray of every set of the header.
    pub rays: Vec<SampledRay>,
}

/// A source of tiles that keeps the rays of a sample of pixels of each tile which is asked for.
pub struct Sampling<'a, S> {
    source: &'a S,
    grid: Option<Grid>,
    kept: Mutex<BTreeMap<[u32; 2], Vec<SampledRay>>>,
}

/// Where the pixels of a sample lie.
#[derive(Clone, Copy)]
struct Grid {
    every: u32,
    first: [u32; 2],
    size: [u32; 2],
}

impl Grid {
    /// Of at most `most` pixels, at distances of a power of two.
    fn new(frame: [u32; 2], most: u32) -> Self {
        let every = (0..u32::BITS - 1).map(|power| 1 << power).find(|&every| {
            frame.map(|side| u64::from(side.div_ceil(every))).iter().product::<u64>() <= u64::from(most)
        });
        let every = every.unwrap_or(1 << (u32::BITS - 2));
        let first = frame.map(|side| (every / 2).min(side - 1));
        let size = [0, 1].map(|axis| (frame[axis] - first[axis]).div_ceil(every));
        Self { every, first, size }
    }

    /// The pixels of the sample in a tile, row by row.
    fn within(self, TileRect { x, y, width, height }: TileRect) -> impl Iterator<Item = [u32; 2]> {
        let Self { every, first, .. } = self;
        let on = move |at: u32, axis: usize| at >= first[axis] && (at - first[axis]).is_multiple_of(every);
        let rows = (y..y + height).filter(move |&y| on(y, 1));
        rows.flat_map(move |y| (x..x + width).filter(move |&x| on(x, 0)).map(move |x| [x, y]))
    }
}

impl<'a, S: TileSource> Sampling<'a, S> {
    /// Keeps the rays of at most `most` pixels; of none where that is 0, or the frame is a list of rays.
    pub fn new(source: &'a S, most: u32) -> Self {
        let grid = match source.header().frame {
            Frame::Image { width, height } if most > 0 => Some(Grid::new([width, height], most)),
            _ => None,
        };
        Self { source, grid, kept: Mutex::default() }
    }

    /// What was kept, once every tile has been asked for; none without a sample, or where a tile is missing.
    pub fn finish(self) -> Option<RaySample> {
        let Grid { every, first, size } = self.grid?;
        let mut kept = self.kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        let columns = (0..size[0]).map(|column| first[0] + every * column);
        let rows = (0..size[1]).map(|row| first[1] + every * row);
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| [x, y]));
        let rays = pixels.map(|pixel| kept.remove(&pixel)).collect::<Option<Vec<_>>>()?;
        Some(RaySample { every, first, size, rays: rays.into_iter().flatten().collect() })
    }

    fn keep(&self, grid: Grid, index: u32, tile: &Tile) {
        let rect = self.source.header().frame.tile(index);
        let of_pixel = |[x, y]: [u32; 2]| {
            let place = ((y - rect.y) * rect.width + (x - rect.x)) as usize;
            let of_set = |set: &RaySet| {
                // A source may be damaged, which whoever asked for the tile finds out.
                let steps = set.ends.get(place).and_then(|_| set.steps.get(set.range(place)))?;
                Some(SampledRay { steps: steps.to_vec(), hit: *set.hits.get(place)? })
            };
            let rays = tile.ray_sets.iter().map(of_set).collect::<Option<Vec<_>>>()?;
            Some(([x, y], rays))
        };
        let rays: Vec<_> = grid.within(rect).filter_map(of_pixel).collect();
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).extend(rays);
    }
}

impl<S: TileSource> TileSource for Sampling<'_, S> {
    fn header(&self) -> &TraceHeader {
        self.source.header()
    }

    fn topology(&self) -> &Topology {
        self.source.topology()
    }

    fn tile(&self, index: u32, tile: &mut Tile) -> Result<(), Error> {
        self.source.tile(index, tile)?;
        if let Some(grid) = self.grid {
            self.keep(grid, index, tile);
        }
        Ok(())
    }

    fn outline(&self, index: u32) -> Result<Option<TileOutline>, Error> {
        self.source.outline(index)
    }

    fn is_recorded(&self) -> bool {
        self.source.is_recorded()
    }

    fn stalls(&self) -> u64 {
        self.source.stalls()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::TILE_EDGE;

    #[test]
    fn a_grid_has_at_most_so_many_pixels_and_not_a_quarter_of_them() {
        let grid = |frame, most| {
            let Grid { every, first, size } = Grid::new(frame, most);
            (every, first, size)
        };
        assert_eq!(grid([1024, 1024], 4096), (16, [8, 8], [64, 64]));
        assert_eq!(grid([1024, 1024], 4095), (32, [16, 16], [32, 32]));
        assert_eq!(grid([75, 45], 4096), (1, [0, 0], [75, 45]));
        assert_eq!(grid([1, 100_000], 4096), (32, [0, 16], [1, 3125]));
        assert_eq!(grid([3, 2], 1), (4, [2, 1], [1, 1]));
    }

    #[test]
    fn the_pixels_of_all_tiles_are_those_of_the_grid() {
        let frame = Frame::Image { width: 3 * TILE_EDGE + 5, height: TILE_EDGE + 7 };
        for most in [1, 7, 100, 5000] {
            let grid = Grid::new([3 * TILE_EDGE + 5, TILE_EDGE + 7], most);
            let found: usize = (0..frame.tiles()).map(|index| grid.within(frame.tile(index)).count()).sum();
            assert_eq!(found as u32, grid.size[0] * grid.size[1], "{most}");
        }
    }
}
