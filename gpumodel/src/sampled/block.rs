//! Replays one block of tiles as a part of its frame.

use crate::counters::{BufferTraffic, IssueCounters, Numbers, Pass, ScheduleCounters, TrafficCounters};
use crate::engine::Finished;
use crate::error::Error;
use crate::interleave::Sums;
use crate::prepared::Prepared;
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

/// Replays the tiles of a block on warps and caches that the `warm_up` tiles before it have filled. At the frame's start there is
/// nothing before; at its end the cores run dry and dirty lines are written back.
pub(super) fn count<S: TileSource>(
    source: &S,
    prepared: &Prepared<'_>,
    workshop: &Workshop<'_>,
    tiles: Range<u32>,
    warm_up: u32,
) -> Result<Counted, Error> {
    let last = tiles.end == source.header().frame.tiles();
    let mut engine = prepared.interleaver()?;
    let made = |index: u32| -> Result<_, Error> {
        let mut tile = workshop.tile(source, index)?;
        Ok(tile.variants.swap_remove(0).streams)
    };
    for index in tiles.start.saturating_sub(warm_up)..tiles.start {
        engine.push(&made(index)?);
        engine.run_ahead();
    }
    if tiles.start > 0 {
        engine.run_until_short();
    }
    let before = engine.end_stretch(Pass::Primary);
    let mut counted = Counted::default();
    for index in tiles.clone() {
        let streams = made(index)?;
        for stream in [&streams.tree, &streams.own] {
            counted.issue.iter_mut().zip(&stream.issue).for_each(|(sum, &issue)| *sum += issue);
        }
        engine.push(&streams);
        engine.run_ahead();
    }
    if last {
        engine.drain(Pass::Primary);
    } else {
        engine.run_until_short();
    }
    let after = engine.end_stretch(Pass::Primary);
    let Finished { flush, phases, .. } = engine.finish();
    // What is left at the end of another block is not written back there.
    counted.stretch.flush = if last { flush } else { BufferTraffic::default() };
    let of_before = usize::from(before.schedule.ticks > 0);
    phases
        .iter()
        .skip(of_before)
        .flat_map(|phase| &phase.windows)
        .for_each(|window| counted.window.add(window));
    let Sums { traffic, schedule, memory_reads } = after;
    counted.stretch.traffic = minus(traffic, before.traffic);
    counted.stretch.schedule = minus(schedule, before.schedule);
    counted.memory_reads = memory_reads - before.memory_reads;
    // Until a cache has been filled once, any line that is new to it might have been there.
    if tiles.start > warm_up {
        let lines = prepared.last_cache_lines();
        counted.uncertain_reads = memory_reads.min(lines) - before.memory_reads.min(lines);
    }
    Ok(counted)
}
