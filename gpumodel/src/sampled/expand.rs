//! From the blocks of a sample to the frame.

use super::block::{Counted, Stretch};
use super::calibration::{Auxiliary, Member, calibrated};
use super::design::{Blocks, Pick};
use crate::counters::{FrameCounters, IssueCounters, Numbers, Pass};
use crate::layout::BufferKind;
use crate::windows::{PhaseWindows, Window};

/// Whole numbers, times weights, added up.
struct WeightedSum(Vec<f64>);

impl WeightedSum {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn add<T: Numbers>(&mut self, numbers: &mut T, weight: f64) {
        let Self(sums) = self;
        let mut place = 0;
        numbers.each(&mut |&mut number| {
            match sums.get_mut(place) {
                Some(sum) => *sum += number as f64 * weight,
                None => sums.push(number as f64 * weight),
            }
            place += 1;
        });
    }

    fn rounded<T: Numbers + Default>(self) -> T {
        let mut rounded = T::default();
        let mut sums = self.0.into_iter();
        rounded.each(&mut |number| *number = sums.next().unwrap_or(0.0).round() as u64);
        rounded
    }
}

/// What a sample says of its frame.
pub(super) struct Expanded {
    pub(super) counters: FrameCounters,
    pub(super) phase: PhaseWindows,
    /// Turns of the stretches of time, as a part of those of the tiles.
    pub(super) seen: f64,
}

/// What becomes of reads that a warmer cache might have spared.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Uncertain {
    /// They are counted.
    Counted,
    /// They are not.
    Spared,
    /// They are counted, and drive out dirty lines.
    Evicting,
}

/// The frame that picks of these design weights stand for.
///
/// Weights of tiles and of stretches of time are calibrated each to what is known of all of them. Windows are such that as many
/// turns are issued in them as in all tiles.
pub(super) fn expand(
    blocks: &Blocks,
    picks: &[Pick],
    weights: &[f64],
    counted: &[Counted],
    uncertain: Uncertain,
) -> Expanded {
    let of_tiles = calibrate(blocks, blocks.of_tiles(), picks, weights);
    let of_stretches = calibrate(blocks, blocks.of_stretches(), picks, weights);
    let (mut issue, mut stretch) = (WeightedSum::new(), WeightedSum::new());
    let (mut turns, mut turns_in_windows) = (0.0, 0.0);
    let mut parts: Vec<(Window, f64)> = Vec::new();
    for ((counted, &of_tiles), &of_stretch) in counted.iter().zip(&of_tiles).zip(&of_stretches) {
        let mut counted = counted.clone();
        match uncertain {
            Uncertain::Counted => {}
            Uncertain::Spared => spare(&mut counted),
            Uncertain::Evicting => evict(&mut counted),
        }
        issue.add(&mut counted.issue, of_tiles);
        stretch.add(&mut counted.stretch, of_stretch);
        turns += counted.issue.iter().map(|issue| issue.turns).sum::<u64>() as f64 * of_tiles;
        turns_in_windows += counted.window.turns as f64 * of_stretch;
        parts.push((counted.window, of_stretch));
    }
    let stretched = if turns_in_windows > 0.0 { turns / turns_in_windows } else { 1.0 };
    let windows = parts.into_iter().map(|(mut window, weight)| {
        let mut sum = WeightedSum::new();
        sum.add(&mut window, weight * stretched);
        sum.rounded()
    });
    let windows = windows.filter(|window: &Window| window.ticks > 0 && window.turns > 0).collect();
    let Stretch { traffic, flush, schedule } = stretch.rounded();
    let mut counters = FrameCounters { flush, schedule, ..FrameCounters::default() };
    let issue: [IssueCounters; Pass::COUNT] = issue.rounded();
    for ((pass, issue), traffic) in counters.passes.iter_mut().zip(issue).zip(traffic) {
        pass.issue = issue;
        pass.traffic = traffic;
    }
    let seen = if turns > 0.0 { turns_in_windows / turns } else { 1.0 };
    Expanded { counters, phase: PhaseWindows { first: Pass::Primary, windows }, seen }
}

/// Weights with which picks have what is known of all blocks.
fn calibrate(blocks: &Blocks, known: &[Auxiliary], picks: &[Pick], weights: &[f64]) -> Vec<f64> {
    let mut all = Auxiliary::default();
    known.iter().for_each(|block| all.add(block.0, 1.0));
    let member = |(pick, &weight): (&Pick, &f64)| Member {
        known: known[pick.block as usize],
        weight,
        size: blocks.size(pick.block),
        certain: pick.probability >= 1.0,
    };
    calibrated(all, &picks.iter().zip(weights).map(member).collect::<Vec<_>>())
}

/// In caches as the frame leaves them, lines that are read drive out others that may be dirty: adds what that might write.
fn evict(Counted { stretch, window, uncertain_writes, .. }: &mut Counted) {
    window.memory_bytes += *uncertain_writes;
    let all = stretch.written() as f64;
    if all == 0.0 {
        // Stacks are what is written most.
        let traversal = &mut stretch.traffic[Pass::Primary as usize];
        traversal.of_mut(BufferKind::Stack).dram_write_bytes += *uncertain_writes;
        return;
    }
    for pass in &mut stretch.traffic {
        pass.each_buffer(|buffer| {
            let share = buffer.dram_write_bytes as f64 / all;
            buffer.dram_write_bytes += (*uncertain_writes as f64 * share) as u64;
        });
    }
}

/// Takes the uncertain reads off what a block caused.
fn spare(Counted { stretch, window, uncertain_reads, memory_reads, .. }: &mut Counted) {
    let certain = if *memory_reads > 0 { 1.0 - *uncertain_reads as f64 / *memory_reads as f64 } else { 1.0 };
    let spared = |number: &mut u64| *number = (*number as f64 * certain).round() as u64;
    for pass in &mut stretch.traffic {
        pass.each_buffer(|buffer| {
            spared(&mut buffer.dram_read_bytes);
            if let Some(last) = buffer.levels.iter_mut().rev().find(|level| level.misses > 0) {
                spared(&mut last.misses);
            }
        });
    }
    spared(&mut window.memory_bytes);
    spared(&mut window.page_walks);
    if let Some(last) = window.levels.iter_mut().rev().find(|level| level.misses > 0) {
        spared(&mut last.misses);
    }
    if let Some(memory) = window.waits.from.last_mut() {
        spared(memory);
    }
}
