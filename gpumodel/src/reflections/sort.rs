//! The three passes that bring hits into the order of their materials.

use super::lists::{ID_BYTES, Lists};
use super::prices::Prices;
use crate::counters::Pass;
use crate::layout::BufferKind;
use crate::warp::{Emitter, Program, TileStreams};

const WORD: u32 = ID_BYTES as u32;
/// Before the counters of buckets.
const FIRST_BUCKET: u32 = 2;
/// Warps of a piece.
pub(super) const PIECE_WARPS: usize = 64;

/// What the warps of these passes execute, each lane for one element, or for one bucket.
pub(super) struct SortPass<'a> {
    pub(super) program: &'a Program,
    pub(super) prices: Prices<'a>,
    pub(super) lists: &'a Lists,
    pub(super) warp: usize,
    /// By element, its bucket.
    pub(super) elements: &'a [u32],
    pub(super) buckets: u32,
    /// By element, its place in the sorted list.
    pub(super) places: &'a [u32],
}

impl SortPass<'_> {
    /// Pieces of the passes over elements.
    pub(super) fn pieces(&self) -> u32 {
        self.elements.len().div_ceil(self.warp * PIECE_WARPS) as u32
    }

    /// Of the pass that counts, or of the one that copies.
    pub(super) fn piece(&self, emitter: &mut Emitter, pass: Pass, index: u32) -> TileStreams {
        let Self { program, prices, lists, .. } = self;
        let copies = pass == Pass::BucketCopy;
        let start = index as usize * self.warp * PIECE_WARPS;
        let end = self.elements.len().min(start + self.warp * PIECE_WARPS);
        for first in (start..end).step_by(self.warp) {
            let elements = first..end.min(first + self.warp);
            let numbers = elements.clone().map(|element| element as u32);
            emitter.access(
                program,
                pass,
                (BufferKind::Record, false, WORD),
                numbers.map(|element| lists.id(element)),
            );
            emitter.end_turn(program, pass, true);
            let mut buckets = self.elements[elements.clone()].to_vec();
            let lanes = buckets.len() as u64;
            buckets.sort_unstable();
            buckets.dedup();
            let base = if copies { FIRST_BUCKET + self.buckets } else { FIRST_BUCKET };
            let counters = buckets.iter().map(|&bucket| lists.counter(base + bucket));
            emitter.access(program, pass, (BufferKind::Counter, false, WORD), counters);
            emitter.end_turn(program, pass, copies);
            let cost = if copies { prices.bucket_copy() } else { prices.bucket_count() };
            program.spend(cost, 1, lanes, emitter.issue(pass));
            if copies {
                let places = self.places[elements].iter().map(|&place| lists.sorted(place));
                emitter.access(program, pass, (BufferKind::Record, true, WORD), places);
                emitter.end_turn(program, pass, false);
            }
            emitter.end_warp(program);
        }
        emitter.take(program, &Default::default(), None)
    }

    /// The pass between: a lane for each bucket takes a stretch of the list for it.
    pub(super) fn offsets(&self, emitter: &mut Emitter) -> TileStreams {
        let Self { program, prices, lists, .. } = self;
        const PASS: Pass = Pass::BucketOffset;
        let buckets: Vec<u32> = (0..self.buckets).collect();
        for warp in buckets.chunks(self.warp) {
            let sizes = warp.iter().map(|&bucket| lists.counter(FIRST_BUCKET + bucket));
            emitter.access(program, PASS, (BufferKind::Record, false, WORD), sizes);
            emitter.end_turn(program, PASS, true);
            emitter.access(
                program,
                PASS,
                (BufferKind::Counter, false, WORD),
                std::iter::once(lists.counter(0)),
            );
            emitter.end_turn(program, PASS, true);
            let offsets = warp.iter().map(|&bucket| lists.counter(FIRST_BUCKET + self.buckets + bucket));
            emitter.access(program, PASS, (BufferKind::Record, true, WORD), offsets);
            emitter.end_turn(program, PASS, false);
            program.spend(prices.bucket_offset(), 1, warp.len() as u64, emitter.issue(PASS));
            emitter.end_warp(program);
        }
        emitter.take(program, &Default::default(), None)
    }
}
