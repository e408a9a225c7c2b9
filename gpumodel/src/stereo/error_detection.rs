//! Error detection: tile by tile of the right image, which pixels the left one answers, and which have to be traced.
//!
//! The lanes of a workgroup take the pixels of the left rows that can land in the tile or come to lie on both sides of it. Each puts its pixel into its
//! row, where the nearest stays; then tests the pixels between it and its right neighbour; then lanes of the tile's own pixels read what is left and
//! list it. Rows and what stands in them are in shared memory. Where there is internal memory, DMA reads the left rows ahead, one tile behind the other.

use super::Kernels;
use super::buffers::{ENTRY_BYTES, SPAN_BYTES};
use super::eye::Eye;
use crate::config::{Atomics, Stereo, StereoLaunch};
use crate::counters::Pass;
use crate::dispatch::Running;
use crate::error::Error;
use crate::layout::{BufferKind, PIXEL_BYTES};
use crate::warp::Emitter;
use std::ops::Range;
use tracer::TileSource;
use tracer::stereo::Reprojection;

const PASS: Pass = Pass::ErrorDetection;
/// Bytes of what stands in a pixel of a row in shared memory: inverse depth and column.
const WORD_BYTES: u64 = 8;
/// Rows that are read ahead while others are tested.
const BUFFERS: u64 = 2;

/// What is in internal memory while a tile is tested: the G-buffer of the left pixels that can land in it, what the row test needs of them, and what stands
/// in its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Left pixels of a row.
    pub columns: u32,
    /// Bytes of all.
    pub bytes: u64,
    /// Bytes that DMA reads for all tiles of the image.
    pub dma_bytes: u64,
    /// Transfers by which it reads them: one for each tile.
    pub dma_reads: u64,
}

impl Window {
    /// Of an image's tiles, the largest.
    pub fn of(known: &Reprojection, stereo: &Stereo) -> Self {
        let [width, height] = known.size();
        let tiles = Tiles::new(known, stereo);
        let columns = (0..tiles.columns).map(|column| tiles.span(column).len() as u64);
        let widest = columns.clone().max().unwrap_or(0);
        let rows = u64::from(stereo.tile[1].min(height));
        let pixels = widest * rows;
        let words = u64::from(stereo.tile[0].min(width)) * rows * WORD_BYTES;
        Self {
            columns: widest as u32,
            bytes: pixels * (u64::from(stereo.fields.bytes()) + BUFFERS * SPAN_BYTES) + words,
            dma_bytes: columns.sum::<u64>() * u64::from(height) * SPAN_BYTES,
            dma_reads: u64::from(tiles.columns) * u64::from(tiles.rows),
        }
    }
}

/// The tiles of an image.
struct Tiles<'a> {
    known: &'a Reprojection,
    size: [u32; 2],
    tile: [u32; 2],
    columns: u32,
    rows: u32,
}

impl<'a> Tiles<'a> {
    fn new(known: &'a Reprojection, stereo: &Stereo) -> Self {
        let size = known.size();
        let [columns, rows] = [0, 1].map(|axis| size[axis].div_ceil(stereo.tile[axis]));
        Self { known, size, tile: stereo.tile, columns, rows }
    }

    /// Columns and rows of a tile.
    fn rect(&self, index: u32) -> [Range<u32>; 2] {
        let place = [index % self.columns, index / self.columns];
        [0, 1].map(|axis| {
            let start = place[axis] * self.tile[axis];
            start..(start + self.tile[axis]).min(self.size[axis])
        })
    }

    /// Columns of the left image whose pixels can land in a column of tiles, and those beside them, between which other pixels may lie.
    fn span(&self, column: u32) -> Range<u32> {
        let width = i64::from(self.size[0]);
        let (start, end) =
            (i64::from(column * self.tile[0]), width.min(i64::from((column + 1) * self.tile[0])));
        let shifts = self.known.shifts();
        if shifts.is_empty() {
            return 0..0;
        }
        let first = start - i64::from(*shifts.end()) - 1;
        let last = end - i64::from(*shifts.start()) + 1;
        first.clamp(0, width) as u32..last.clamp(0, width) as u32
    }
}

/// The dispatch over all tiles. `places` are those of pixels in the lists, one after the other.
///
/// # Errors
/// When a stream cannot be made.
pub(super) fn run<S: TileSource>(
    eye: &Eye<'_, S>,
    kernels: &Kernels<'_>,
    places: &[u32],
    running: &mut Running,
) -> Result<(), Error> {
    let tiles = Tiles::new(kernels.known, kernels.stereo);
    let make = |index: u32| {
        eye.benches.with(|bench| {
            let pass = TilePass { eye, kernels, tiles: &tiles, places, emitter: &mut bench.emitter };
            pass.run(index);
            Ok((bench.emitter.take(&eye.program, &Default::default(), None), ()))
        })
    };
    running.dispatch(&[PASS], eye.kernel_warps, tiles.columns * tiles.rows, make, |()| {})
}

struct TilePass<'a, 's, S> {
    eye: &'a Eye<'s, S>,
    kernels: &'a Kernels<'a>,
    tiles: &'a Tiles<'a>,
    places: &'a [u32],
    emitter: &'a mut Emitter,
}

impl<S: TileSource> TilePass<'_, '_, S> {
    fn run(mut self, index: u32) {
        let [columns, rows] = self.tiles.rect(index);
        let span = self.tiles.span(index % self.tiles.columns);
        let [width, _] = self.tiles.size;
        if self.kernels.in_tiles() {
            let issue = self.emitter.issue(PASS);
            let bytes = span.len() as u64 * rows.len() as u64 * SPAN_BYTES;
            issue.dma_read_bytes += bytes;
            issue.dma_reads += 1;
            issue.internal_bytes += bytes;
        }
        let warp = self.kernels.config.gpu.cores.warp_width as usize;
        for row in rows.clone() {
            let first = row * width;
            let left: Vec<u32> = span.clone().map(|column| first + column).collect();
            left.chunks(warp).for_each(|pixels| self.scatter(pixels, &columns));
        }
        for row in rows {
            let first = row * width;
            let right: Vec<u32> = columns.clone().map(|column| first + column).collect();
            right.chunks(warp).for_each(|pixels| self.classify(pixels));
        }
    }

    /// A warp of left pixels that land in these columns, test pixels there, or neither.
    fn scatter(&mut self, pixels: &[u32], columns: &Range<u32>) {
        let Self { eye, kernels, tiles, emitter, .. } = self;
        let all = tiles.known.columns();
        let [width, _] = tiles.size;
        let lanes = pixels.len() as u64;
        if kernels.in_tiles() {
            eye.internal(emitter, PASS, lanes, SPAN_BYTES);
        } else {
            let at = pixels.iter().map(|&pixel| eye.buffers.span(pixel));
            eye.records(emitter, PASS, (false, SPAN_BYTES), &at);
            emitter.end_turn(&eye.program, PASS, true);
        }
        let lands = |pixel: &&u32| {
            let column = all[**pixel as usize];
            column >= 0.0 && columns.contains(&(column as u32))
        };
        let landing = pixels.iter().filter(lands).count() as u64;
        let tests = |&pixel: &u32| {
            if pixel % width == width - 1 {
                return 0;
            }
            let [a, b] = [all[pixel as usize], all[pixel as usize + 1]];
            let first = (a.min(b).max(0.0) as u32).max(columns.start);
            let last = (a.max(b).ceil().max(0.0) as u32).min(columns.end);
            u64::from(last.saturating_sub(first))
        };
        let (most, sum) =
            pixels.iter().map(tests).fold((0, 0), |(most, sum), tests| (most.max(tests), sum + tests));
        let spend = |cost, warps, lanes, emitter: &mut Emitter| {
            eye.program.spend(cost, warps, lanes, emitter.issue(PASS));
        };
        spend(kernels.costs.scatter, 1, lanes, emitter);
        spend(kernels.costs.span, 1, lanes, emitter);
        spend(kernels.costs.test, most, sum, emitter);
        eye.internal(emitter, PASS, landing, WORD_BYTES);
        self.shared_atomics(landing);
        self.eye.internal(self.emitter, PASS, sum, WORD_BYTES);
        self.emitter.end_warp(&self.eye.program);
    }

    /// A warp of right pixels, which it lists.
    fn classify(&mut self, pixels: &[u32]) {
        let Self { eye, kernels, tiles, places, emitter } = self;
        let lanes = pixels.len() as u64;
        eye.internal(emitter, PASS, lanes, WORD_BYTES);
        eye.program.spend(kernels.costs.classify, 1, lanes, emitter.issue(PASS));
        let answered = pixels.iter().filter(|&&pixel| tiles.known.left_pixel(pixel).is_some()).count();
        let are_listed = kernels.stereo.launch == StereoLaunch::Lists;
        let lists = [pixels.len() - answered, answered].map(|of_list| are_listed && of_list > 0);
        let adds = lists.iter().filter(|&&any| any).count() as u64;
        if kernels.in_tiles() {
            eye.internal(emitter, PASS, lanes, ENTRY_BYTES);
            self.shared_atomics(adds);
        } else {
            // One add for the lanes of each list.
            let Atomics { lane_clocks, warp_clocks, .. } = *kernels.atomics;
            let issue = emitter.issue(PASS);
            issue.atomics += adds;
            issue.atomic_clocks += (adds as f64 * (lane_clocks + warp_clocks)).round() as u64;
            if adds > 0 {
                let of_lists = (0..).zip(lists).filter(|&(_, any)| any);
                let counters = of_lists.map(|(list, _)| eye.buffers.counter(list));
                let counter = (BufferKind::Counter, false, PIXEL_BYTES as u32);
                emitter.access(&eye.program, PASS, counter, counters);
                emitter.end_turn(&eye.program, PASS, true);
            }
            let at = pixels.iter().map(|&pixel| eye.buffers.entry(places[pixel as usize]));
            eye.records(emitter, PASS, (true, ENTRY_BYTES), &at);
            emitter.end_turn(&eye.program, PASS, false);
        }
        self.emitter.end_warp(&self.eye.program);
    }

    /// Atomics on words of shared memory, which hold the port.
    fn shared_atomics(&mut self, atomics: u64) {
        let clocks = atomics as f64 * self.kernels.atomics.shared_lane_clocks;
        self.emitter.issue(PASS).load_store_cycles += clocks.round() as u64;
    }
}
