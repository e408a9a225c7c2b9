//! What happens when, in ticks: a phase cut into windows of equal length.
//!
//! Warps come and go, and the caches are cold at first. Time under contention is not proportional to what is asked for, so it is
//! found window by window.

use crate::counters::{Numbers, Pass, WaitCounters};
use cachesim::{LevelServed, MAX_LEVELS};

/// When a phase has so many windows, two neighbours become one. Even.
const MOST_WINDOWS: usize = 256;
/// Ticks of a window at first.
const FIRST_TICKS: u64 = 32;

/// Sums since the start of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) levels: [LevelServed; MAX_LEVELS],
    pub(crate) memory_bytes: u64,
    pub(crate) page_walks: u64,
    pub(crate) waits: WaitCounters,
}

/// A stretch of a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// Ticks.
    pub ticks: u64,
    /// Turns issued: in a tick, as many as there are cores with warps.
    pub turns: u64,
    /// Resident warps, summed over ticks.
    pub warp_ticks: u64,
    /// By index into [`Gpu::caches`](crate::Gpu::caches).
    pub levels: [LevelServed; MAX_LEVELS],
    /// Bytes read from and written to memory through the caches.
    pub memory_bytes: u64,
    /// Pages whose addresses were walked for.
    pub page_walks: u64,
    /// Where turns found their data.
    pub waits: WaitCounters,
}

/// What happened between two times at which the GPU was empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PhaseWindows {
    /// The first pass that ran.
    pub first: Pass,
    /// In order of time.
    pub windows: Vec<Window>,
}

/// Cuts phases into windows.
#[derive(Default)]
pub(crate) struct WindowLog {
    phases: Vec<PhaseWindows>,
    windows: Vec<Window>,
    open: Window,
    /// Ticks of each window but the last.
    length: u64,
    before: Seen,
}

impl Numbers for Window {
    fn each(&mut self, visit: &mut dyn FnMut(&mut u64)) {
        let Self { ticks, turns, warp_ticks, levels, memory_bytes, page_walks, waits } = self;
        [ticks, turns, warp_ticks, memory_bytes, page_walks].into_iter().for_each(&mut *visit);
        levels.each(visit);
        waits.each(visit);
    }
}

impl Window {
    pub(crate) fn add(&mut self, other: &Self) {
        let Self { ticks, turns, warp_ticks, levels, memory_bytes, page_walks, waits } = other;
        self.ticks += ticks;
        self.turns += turns;
        self.warp_ticks += warp_ticks;
        for (sum, level) in self.levels.iter_mut().zip(levels) {
            sum.accesses += level.accesses;
            sum.misses += level.misses;
        }
        self.memory_bytes += memory_bytes;
        self.page_walks += page_walks;
        self.waits += *waits;
    }
}

impl WindowLog {
    /// A tick in which so many cores had so many warps; true if the window is full.
    pub(crate) fn tick(&mut self, cores: u64, warps: u64) -> bool {
        self.open.ticks += 1;
        self.open.turns += cores;
        self.open.warp_ticks += warps;
        self.open.ticks >= self.length.max(FIRST_TICKS)
    }

    /// The next window begins; `seen` is up to now.
    pub(crate) fn end_window(&mut self, seen: &Seen) {
        let Seen { levels, memory_bytes, page_walks, waits } = &self.before;
        self.open.memory_bytes = seen.memory_bytes - memory_bytes;
        self.open.page_walks = seen.page_walks - page_walks;
        for (level, (now, before)) in self.open.levels.iter_mut().zip(seen.levels.iter().zip(levels)) {
            *level =
                LevelServed { accesses: now.accesses - before.accesses, misses: now.misses - before.misses };
        }
        self.open.waits = seen.waits - *waits;
        self.before = *seen;
        self.windows.push(std::mem::take(&mut self.open));
        if self.windows.len() == MOST_WINDOWS {
            let pairs = self.windows.chunks(2).map(|pair| {
                let mut both = pair[0];
                pair[1..].iter().for_each(|other| both.add(other));
                both
            });
            self.windows = pairs.collect();
            self.length = 2 * self.length.max(FIRST_TICKS);
        }
    }

    /// The phase that began with `first` is over.
    pub(crate) fn end_phase(&mut self, first: Pass, seen: &Seen) {
        if self.open.ticks > 0 {
            self.end_window(seen);
        }
        let windows = std::mem::take(&mut self.windows);
        self.length = 0;
        if !windows.is_empty() {
            self.phases.push(PhaseWindows { first, windows });
        }
    }

    /// All phases, in order.
    pub(crate) fn phases(self) -> Vec<PhaseWindows> {
        self.phases
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(tick: u64) -> Seen {
        let mut seen = Seen { memory_bytes: 64 * tick, ..Seen::default() };
        seen.levels[0] = LevelServed { accesses: 3 * tick, misses: tick };
        seen.waits.from[1] = tick;
        seen
    }

    #[test]
    fn windows_are_few_equally_long_and_add_up_to_the_phase() {
        for ticks in [1, 31, 32, 33, 10_000, 1_000_003] {
            let mut log = WindowLog::default();
            for tick in 1..=ticks {
                if log.tick(4, 20) {
                    log.end_window(&seen(tick));
                }
            }
            log.end_phase(Pass::Primary, &seen(ticks));
            let phases = log.phases();
            let windows = &phases[0].windows;
            assert!(windows.len() <= MOST_WINDOWS, "{ticks} ticks: {} windows", windows.len());
            assert!(
                ticks < 10_000 || windows.len() >= MOST_WINDOWS / 2,
                "{ticks} ticks: {} windows",
                windows.len()
            );
            let (last, others) = windows.split_last().unwrap();
            assert!(
                others.iter().all(|window| window.ticks == others[0].ticks && last.ticks <= window.ticks)
            );
            let mut sum = Window::default();
            windows.iter().for_each(|window| sum.add(window));
            assert_eq!((sum.ticks, sum.turns, sum.warp_ticks), (ticks, 4 * ticks, 20 * ticks));
            assert_eq!(sum.levels[0], LevelServed { accesses: 3 * ticks, misses: ticks });
            assert_eq!((sum.memory_bytes, sum.waits.from[1]), (64 * ticks, ticks));
        }
    }

    #[test]
    fn a_phase_without_ticks_leaves_nothing() {
        let mut log = WindowLog::default();
        log.end_phase(Pass::Binning, &Seen::default());
        assert!(log.phases().is_empty());
    }
}
