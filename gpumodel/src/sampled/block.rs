//! Replays one block of tiles as a part of its frame.

use crate::counters::{BufferTraffic, IssueCounters, Numbers, Pass, ScheduleCounters, TrafficCounters};
use crate::engine::Finished;
use crate::error::Error;
use crate::interleave::{Interleaver, Sums};
use crate::prepared::Prepared;
use crate::sampled::warm_up::WarmUp;
use crate::warp::TileStreams;
use crate::windows::Window;
use crate::workshop::Workshop;
use std::ops::Range;
use tracer::TileSource;

/// What a block adds to its frame.
///
/// Issue belongs to its tiles. Traffic and time belong to its stretch of time: from when its first warp comes until the next
/// block's would. The stretches of all blocks make up the frame.
#[derive(Clone, Default)]
pub(super) struct Counted {
    pub(super) issue: [IssueCounters; Pass::COUNT],
    pub(super) stretch: Stretch,
    /// All of the stretch.
    pub(super) window: Window,
    /// Of the lines that were read from memory during the stretch, those that a cache might have had if it had seen the whole frame.
    pub(super) uncertain_reads: u64,
    /// Bytes that lines which were driven out during the stretch might have written to memory besides: what fills the caches before the
    /// tiles that are run says little of which lines are dirty. As many for each line as there are dirty bytes in the caches at the end.
    pub(super) uncertain_writes: u64,
    /// Lines that were read from memory during the stretch.
    pub(super) memory_reads: u64,
}

/// What happened in a stretch of time.
#[derive(Clone, Default)]
pub(super) struct Stretch {
    /// By [`Pass`].
    pub(super) traffic: [TrafficCounters; Pass::COUNT],
    pub(super) flush: BufferTraffic,
    pub(super) schedule: ScheduleCounters,
}

impl Stretch {
    /// Bytes that lines which were driven out wrote to memory.
    pub(super) fn written(&self) -> u64 {
        self.traffic.iter().map(|pass| pass.total().dram_write_bytes).sum()
    }
}

impl Numbers for Stretch {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        let Self { traffic, flush, schedule } = self;
        traffic.each(visit);
        flush.each(visit);
        schedule.each(visit);
    }
}

/// Takes what happened before off what happened since the start.
fn minus<T: Numbers>(mut all: T, mut before: T) -> T {
    let mut numbers = Vec::new();
    before.each(&mut |&mut number| numbers.push(number));
    let mut numbers = numbers.into_iter();
    all.each(&mut |number| *number -= numbers.next().unwrap_or(0));
    all
}

/// Replays the tiles of a block, for each of the variants that `workshop` makes tiles for, on warps that the `block_tiles` tiles before
/// it have filled, and on caches that have seen these and what `warm_up` knows of before. At the frame's start there is nothing before; at
/// its end the cores run dry and dirty lines are written back.
pub(super) fn count<S: TileSource>(
    source: &S,
    variants: &[&Prepared<'_>],
    workshop: &Workshop<'_>,
    warm_up: &WarmUp<'_, S>,
    (tiles, block_tiles): (Range<u32>, u32),
) -> Result<Vec<Counted>, Error> {
    let first = tiles.start.saturating_sub(block_tiles);
    let mut engines = variants.iter().map(|variant| variant.interleaver()).collect::<Result<Vec<_>, _>>()?;
    let from_start = warm_up.fill((first, block_tiles), variants, &mut engines)?;
    let mut blocks: Vec<Block> = engines.into_iter().map(Block::new).collect();
    for index in first..tiles.start {
        let made = workshop.tile(source, index)?;
        blocks.iter_mut().zip(&made.variants).for_each(|(block, tile)| block.run(&tile.streams));
    }
    blocks.iter_mut().for_each(|block| block.begin(tiles.start > 0));
    for index in tiles.clone() {
        let made = workshop.tile(source, index)?;
        blocks.iter_mut().zip(&made.variants).for_each(|(block, tile)| {
            block.issued(&tile.streams);
            block.run(&tile.streams);
        });
    }
    let last = tiles.end == source.header().frame.tiles();
    let seen = Seen { reads: from_start, writes: first == 0 };
    let ended = blocks.into_iter().zip(variants).map(|(block, variant)| block.end(variant, last, seen));
    Ok(ended.collect())
}

/// Whether the caches have seen the frame from its start.
#[derive(Clone, Copy)]
struct Seen {
    reads: bool,
    writes: bool,
}

/// A block at work on one variant.
struct Block {
    engine: Interleaver,
    counted: Counted,
    /// Lines that came from memory before any tile was run.
    filled: u64,
    /// At its begin.
    before: Sums,
}

impl Block {
    fn new(mut engine: Interleaver) -> Self {
        let before = engine.end_stretch(Pass::Primary);
        Self { engine, counted: Counted::default(), filled: before.memory_reads, before }
    }

    fn run(&mut self, streams: &TileStreams) {
        self.engine.push(streams);
        self.engine.run_ahead();
    }

    /// What came up to here was warm-up, if there was any.
    fn begin(&mut self, warm: bool) {
        if warm {
            self.engine.run_until_short();
        }
        self.before = self.engine.end_stretch(Pass::Primary);
    }

    fn issued(&mut self, streams: &TileStreams) {
        for stream in [&streams.tree, &streams.own] {
            self.counted.issue.iter_mut().zip(&stream.issue).for_each(|(sum, &issue)| *sum += issue);
        }
    }

    /// It is the `last` of the frame, or another follows.
    fn end(self, variant: &Prepared<'_>, last: bool, seen: Seen) -> Counted {
        let Self { mut engine, mut counted, filled, before } = self;
        if last {
            engine.drain(Pass::Primary);
        } else {
            engine.run_until_short();
        }
        let Sums { traffic, schedule, memory_reads } = engine.end_stretch(Pass::Primary);
        let Finished { flush, phases, .. } = engine.finish();
        let dirty = flush.dram_write_bytes;
        // What is left at the end of another block is not written back there.
        counted.stretch.flush = if last { flush } else { BufferTraffic::default() };
        let of_before = usize::from(before.schedule.ticks > 0);
        phases
            .iter()
            .skip(of_before)
            .flat_map(|phase| &phase.windows)
            .for_each(|window| counted.window.add(window));
        counted.stretch.traffic = minus(traffic, before.traffic);
        counted.stretch.schedule = minus(schedule, before.schedule);
        counted.memory_reads = memory_reads - before.memory_reads;
        // Until a cache has been filled once, any line that is new to it might have been there.
        let lines = variant.last_cache_lines();
        let until_full =
            |from: u64| (memory_reads - from).min(lines) - (before.memory_reads - from).min(lines);
        if !seen.reads {
            counted.uncertain_reads = until_full(0);
        }
        if !seen.writes {
            counted.uncertain_writes =
                (u128::from(until_full(filled)) * u128::from(dirty) / u128::from(lines.max(1))) as u64;
        }
        counted
    }
}
