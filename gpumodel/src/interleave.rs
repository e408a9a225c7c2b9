//! Warps share the cores and the caches.
//!
//! Warps are issued in tile order; each goes to the first free slot, slots being counted across the cores before the next
//! slot of the first. In every tick each core that has a warp lets the next one of its slots, round-robin, issue one turn: the loads and
//! stores up to its next wait. The order of turns is the order in which the caches see the accesses.

use crate::config::Gpu;
use crate::counters::{BufferTraffic, PassCounters, ScheduleCounters, TrafficCounters};
use crate::layout::{BufferKind, Buffers};
use crate::warp::{Pass, Run, TileStream};
use cachesim::{Hierarchy, LineId, PathId, Policy, Served};
use std::collections::VecDeque;
use std::sync::Arc;

/// Paths through the caches, as the hierarchy numbers them.
#[derive(Clone, Copy)]
pub(crate) struct KindPaths {
    pub(crate) ssbo: PathId,
    pub(crate) private: PathId,
}

impl KindPaths {
    fn of(&self, kind: BufferKind) -> PathId {
        match kind {
            BufferKind::Node | BufferKind::Primitive | BufferKind::Index | BufferKind::Normal => self.ssbo,
            BufferKind::Stack => self.private,
        }
    }
}

/// How runs of one key reach the caches.
#[derive(Clone, Copy)]
struct Route {
    path: PathId,
    write: bool,
    /// The path has caches private to a core.
    by_core: bool,
    /// Runs of at most this many lines, repeated at once, hit every time after the first and change nothing.
    repeatable_lines: usize,
    /// First line and lines per resident warp of a private buffer.
    private: Option<(u32, u32)>,
}

/// A resident warp: its words yet to issue.
struct Warp {
    stream: Arc<TileStream>,
    next: usize,
    end: usize,
}

/// The cores, their warps, and the caches that they share.
pub(crate) struct Interleaver {
    hierarchy: Hierarchy,
    routes: [Option<Route>; Run::KEYS],
    /// Slots of core `c` are at `c * slots ..`.
    resident: Vec<Option<Warp>>,
    cores: usize,
    slots: usize,
    /// Per core, the slot whose turn is next.
    turn: Vec<usize>,
    /// Per core, warps in its slots.
    occupied: Vec<usize>,
    waiting: VecDeque<Warp>,
    pending: Vec<LineId>,
    pending_key: usize,
    pending_core: u32,
    /// By key.
    traffic: Vec<BufferTraffic>,
    schedule: ScheduleCounters,
}

/// Lines that are gathered, at most, before the caches see them.
const PENDING_LINES: usize = 4096;

impl Interleaver {
    pub(crate) fn new(
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        buffers: &Buffers,
        resident_warps: u32,
    ) -> Self {
        let (cores, slots) = (gpu.cores.count as usize, resident_warps as usize);
        let route = |key: usize| {
            let (_, kind, write) = Run::of_key(key)?;
            let path = paths.of(kind);
            let levels = hierarchy.path(path);
            let first = &gpu.levels().as_slice()[levels[0]];
            // A reordering policy other than LRU may evict one line of the run for another, or rank a hit anew.
            let repeatable = first.policy == Policy::Lru && !write;
            let private =
                (kind == BufferKind::Stack).then_some((buffers.stack_base_line, buffers.stack_stride_lines));
            Some(Route {
                path,
                write,
                by_core: levels.iter().any(|&level| gpu.caches[level].copies > 1),
                repeatable_lines: if repeatable { first.way_count() as usize } else { 0 },
                private,
            })
        };
        Self {
            routes: std::array::from_fn(route),
            hierarchy,
            resident: (0..cores * slots).map(|_| None).collect(),
            cores,
            slots,
            turn: vec![0; cores],
            occupied: vec![0; cores],
            waiting: VecDeque::new(),
            pending: Vec::with_capacity(PENDING_LINES),
            pending_key: 0,
            pending_core: 0,
            traffic: vec![BufferTraffic::default(); Run::KEYS],
            schedule: ScheduleCounters::default(),
        }
    }

    /// Queues the warps of a tile.
    pub(crate) fn push(&mut self, stream: &Arc<TileStream>) {
        for warp in 0..stream.warp_ends.len() {
            let words = stream.warp(warp);
            self.schedule.warps += 1;
            // A warp that touches no memory takes no turn.
            if !words.is_empty() {
                self.waiting.push_back(Warp {
                    stream: Arc::clone(stream),
                    next: words.start,
                    end: words.end,
                });
            }
        }
    }

    /// Runs ticks as long as no core can lack a warp that a later tile would bring.
    pub(crate) fn run_ahead(&mut self) {
        self.fill();
        while self.waiting.len() >= self.cores {
            self.tick();
        }
    }

    /// Runs to the end of the last warp, then writes dirty lines back.
    pub(crate) fn finish(mut self) -> ([TrafficCounters; 3], BufferTraffic, ScheduleCounters) {
        self.fill();
        while self.occupied.iter().any(|&warps| warps > 0) {
            self.tick();
        }
        self.flush_pending();
        let mut passes = [TrafficCounters::default(); 3];
        for (key, traffic) in self.traffic.iter().enumerate() {
            if let Some((pass, kind, _)) = Run::of_key(key) {
                *passes[pass as usize].of_mut(kind) += *traffic;
            }
        }
        // The positions of a flush are level indices.
        let Served { levels, memory } = self.hierarchy.flush();
        let flush = BufferTraffic {
            levels,
            dram_read_bytes: memory.read_bytes,
            dram_write_bytes: memory.write_bytes,
        };
        (passes, flush, self.schedule)
    }

    /// Puts waiting warps into free slots: the first slots of all cores, then the second ones, and so on.
    fn fill(&mut self) {
        for slot in 0..self.slots {
            for core in 0..self.cores {
                let place = &mut self.resident[core * self.slots + slot];
                if place.is_none() {
                    *place = self.waiting.pop_front();
                    self.occupied[core] += usize::from(place.is_some());
                }
            }
        }
    }

    fn tick(&mut self) {
        let resident: usize = self.occupied.iter().sum();
        self.schedule.ticks += 1;
        self.schedule.warp_ticks += resident as u64;
        self.schedule.full_ticks += u64::from(self.occupied.iter().all(|&warps| warps > 0));
        for core in 0..self.cores {
            if self.occupied[core] > 0 {
                self.issue(core);
            }
        }
    }

    /// Lets the next warp of a core issue one turn.
    fn issue(&mut self, core: usize) {
        let first = core * self.slots;
        let mut slot = self.turn[core];
        while self.resident[first + slot].is_none() {
            slot = if slot + 1 == self.slots { 0 } else { slot + 1 };
        }
        self.turn[core] = if slot + 1 == self.slots { 0 } else { slot + 1 };
        let Some(mut warp) = self.resident[first + slot].take() else {
            return;
        };
        loop {
            let run = Run::from_word(warp.stream.words[warp.next]);
            let lines = warp.next + 1..warp.next + 1 + run.lines();
            warp.next = lines.end;
            self.access(core as u32, (first + slot) as u32, run, &warp.stream.words[lines]);
            if run.is_last() || warp.next >= warp.end {
                break;
            }
        }
        if warp.next < warp.end {
            self.resident[first + slot] = Some(warp);
        } else {
            let next = self.waiting.pop_front();
            self.occupied[core] -= usize::from(next.is_none());
            self.resident[first + slot] = next;
        }
    }

    #[inline]
    fn access(&mut self, core: u32, resident: u32, run: Run, lines: &[u32]) {
        let key = run.key();
        let Some(route) = self.routes[key] else {
            return;
        };
        let core = if route.by_core { core } else { 0 };
        let full = self.pending.len() + lines.len() > PENDING_LINES;
        if key != self.pending_key || core != self.pending_core || full {
            self.flush_pending();
            self.pending_key = key;
            self.pending_core = core;
        }
        let base = route.private.map_or(0, |(base, stride)| base + resident * stride);
        let repeats = run.repeats();
        let sent = if lines.len() <= route.repeatable_lines {
            let spared = u64::from(repeats - 1) * lines.len() as u64;
            let entry = self.hierarchy.path(route.path)[0];
            self.traffic[key].levels[entry].accesses += spared;
            1
        } else {
            repeats
        };
        for _ in 0..sent {
            self.pending.extend(lines.iter().map(|&line| LineId::new(u64::from(base + line))));
        }
    }

    fn flush_pending(&mut self) {
        let Some(route) = self.routes[self.pending_key].filter(|_| !self.pending.is_empty()) else {
            return;
        };
        let unit = self.pending_core;
        let Served { levels, memory } = if route.write {
            self.hierarchy.write(route.path, unit, &self.pending)
        } else {
            self.hierarchy.read(route.path, unit, &self.pending)
        };
        let traffic = &mut self.traffic[self.pending_key];
        for (&level, served) in self.hierarchy.path(route.path).iter().zip(levels) {
            traffic.levels[level].accesses += served.accesses;
            traffic.levels[level].misses += served.misses;
        }
        traffic.dram_read_bytes += memory.read_bytes;
        traffic.dram_write_bytes += memory.write_bytes;
        self.pending.clear();
    }
}

impl PassCounters {
    pub(crate) fn of(stream: &TileStream, pass: Pass) -> Self {
        Self { issue: stream.issue[pass as usize], traffic: TrafficCounters::default() }
    }
}
