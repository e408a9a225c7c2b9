//! Warps share the cores and the caches.
//!
//! Warps are issued in tile order; each goes to the first free slot, slots being counted across the cores before the next
//! slot of the first. A turn is the loads and stores of a warp up to its next wait. The order of turns is the order in which the caches
//! see the accesses, and it decides what they have to hold: a warp whose data are far away is held up, so it stays for longer beside
//! others like it. So turns have times, from which nothing but their order is taken; how long a frame takes is found afterwards from what it asked for.
//!
//! On each core the warp that has been ready for longest is next, and the core whose next turn starts first issues it. A turn keeps
//! its core busy for the cycles of the load/store port, or for the mean share of a turn of its tile in the time of the ALU, the elementary
//! functions or the ray unit, if that is longer. The warp is ready again when its data are there: after the latency of the farthest place that they come from.
//! Memory's is drawn evenly from what a DRAM bank may make of it, from an open row to one that was opened just before: with equal latencies
//! warps could keep in step for a whole frame.
//! The only queue is that for a cache which cores share and which is the first on a path: with many lines per turn it would
//! otherwise be asked for more than it can serve.
//!
//! In a tick as many turns are issued as there are cores with warps.

mod caches;
mod ready;
#[cfg(test)]
mod tests;

use self::caches::{Caches, Delay, Resident, Waits};
use self::ready::ReadyTimes;
use crate::config::{Gpu, RayUnit};
use crate::counters::{BufferTraffic, Pass, ScheduleCounters, TrafficCounters};
use crate::engine::Finished;
use crate::layout::{BufferKind, Places};
use crate::random::fraction;
use crate::replay::Maps;
use crate::warp::{PADDING, Run, TileStreams};
use crate::windows::WindowLog;
use cachesim::{Hierarchy, PathId, Served};
use std::collections::VecDeque;
use std::ops::Range;

/// Paths through the caches, as the hierarchy numbers them.
#[derive(Clone, Copy)]
pub(crate) struct KindPaths {
    pub(crate) ssbo: PathId,
    pub(crate) texture: PathId,
    pub(crate) private: PathId,
    pub(crate) vertex: PathId,
    /// Of what a traversal reads.
    pub(crate) traversal: PathId,
    /// Of what atomics change.
    pub(crate) atomic: PathId,
}

impl KindPaths {
    /// `ids` are those of [`Gpu::hierarchy`]; traversals are those of the ray unit, or of shaders.
    pub(crate) fn new(ids: &[PathId], by_ray_unit: bool) -> Self {
        let traversal = if by_ray_unit { ids[4] } else { ids[0] };
        Self { ssbo: ids[0], texture: ids[1], private: ids[2], vertex: ids[3], traversal, atomic: ids[5] }
    }

    /// A compute stage stores into an image as into a storage buffer; it is read as a texture. Triangles that are shaded in a pass that traces are
    /// read by the way of its traversals.
    pub(crate) fn of(&self, pass: Pass, kind: BufferKind, write: bool) -> PathId {
        match kind {
            BufferKind::Node | BufferKind::Primitive | BufferKind::Index if pass.traces() => self.traversal,
            BufferKind::Node | BufferKind::Primitive | BufferKind::Index | BufferKind::Normal => self.ssbo,
            BufferKind::Image | BufferKind::Attachment if write => self.ssbo,
            BufferKind::Image | BufferKind::Attachment => self.texture,
            BufferKind::Stack => self.private,
            BufferKind::Vertex => self.vertex,
            BufferKind::Record => self.ssbo,
            BufferKind::Counter => self.atomic,
        }
    }
}

/// A warp that waits for a slot: its words in the streams of its tile.
struct Waiting {
    streams: TileStreams,
    tree: Range<usize>,
    own: Range<usize>,
    number: u32,
    least_cycles: f64,
}

/// What a slot of a core holds: a copy of the words of its warp, so that those of all resident warps lie close together. All else of it
/// lies in one line of the processor's cache.
#[derive(Default)]
#[repr(align(64))]
struct Slot {
    /// With the padding of a stream.
    words: Vec<u32>,
    /// Words that are yet to issue: of the stream that the next turn is in, and of the other.
    next: Range<u32>,
    other: Range<u32>,
    number: u32,
    /// The first of `next`, read while the words before it are at hand.
    first: u32,
    /// Of the core's time that a turn takes at least.
    least_cycles: f64,
}

impl Slot {
    fn is_free(&self) -> bool {
        self.next.is_empty()
    }

    fn look_ahead(&mut self) {
        self.first = self.words.get(self.next.start as usize).copied().unwrap_or_default();
    }

    /// Takes the warp that has waited longest; false if there is none.
    fn refill(&mut self, waiting: &mut VecDeque<Waiting>) -> bool {
        let Some(Waiting { streams, tree, own, number, least_cycles }) = waiting.pop_front() else {
            return false;
        };
        let mut words = std::mem::take(&mut self.words);
        words.clear();
        words.extend_from_slice(&streams.tree.words[tree]);
        let end = |words: &[u32]| u32::try_from(words.len()).expect("a warp's words take less than 16 GiB");
        let tree = 0..end(&words);
        words.extend_from_slice(streams.own.padded(own.clone()));
        let own = tree.end..end(&words) - PADDING as u32;
        let own_leads =
            tree.is_empty() || (!own.is_empty() && Run::from_word(words[own.start as usize]).begins());
        let (next, other) = if own_leads { (own, tree) } else { (tree, own) };
        *self = Self { words, next, other, number, first: 0, least_cycles };
        self.look_ahead();
        true
    }
}

/// What has happened since the start, after a stretch of time.
pub(crate) struct Sums {
    /// By [`Pass`].
    pub(crate) traffic: [TrafficCounters; Pass::COUNT],
    pub(crate) schedule: ScheduleCounters,
    /// Lines read from memory.
    pub(crate) memory_reads: u64,
}

/// The cores, their warps, and the caches that they share.
pub(crate) struct Interleaver {
    caches: Caches,
    /// Slots of core `c` are at `c * slots ..`.
    resident: Vec<Slot>,
    /// Of each slot, when its warp can issue the next turn, in cycles.
    ready: ReadyTimes,
    cores: usize,
    slots: usize,
    /// Per core, the time up to which its load/store port or its ALU is busy, in cycles.
    busy_until: Vec<f64>,
    /// Per core, the copy of the first cache of buffers that it uses.
    copies: Vec<usize>,
    /// Of each copy, the time up to which it is busy, where cores share it.
    shared_until: Vec<f64>,
    /// Per core, the place whose turn is next.
    next: Vec<usize>,
    /// Per core, when that turn starts; infinite if it has no warp.
    starts: Vec<f64>,
    /// What a core does in a cycle: operations of its ALU, elementary functions, ray-box and ray-triangle tests.
    rates: [f64; 4],
    /// Per core, warps in its slots.
    occupied: Vec<usize>,
    waiting: VecDeque<Waiting>,
    schedule: ScheduleCounters,
    windows: WindowLog,
    maps: Maps,
    next_number: u32,
    /// Turns up to the one that is looked at next, and from now until then.
    sampled: u64,
    until_sample: u64,
    /// Turns whose data came from memory.
    from_memory: u64,
    /// What the state of a DRAM bank adds to the latency of memory, from the least to the most, in cycles.
    bank_delay: Range<f64>,
}

/// Of so many turns, it is seen how far away the data of one are: of the first turns, which may be all, of each; of later ones, of
/// few. Primes, so that they keep step with no loop of a shader.
const SAMPLED_TURNS: [u64; 3] = [1, 17, 127];
/// Up to which turn each of these but the last holds.
const SAMPLED_UP_TO: [u64; 2] = [1 << 12, 1 << 18];

impl Interleaver {
    pub(crate) fn new(
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        places: Places,
        resident_warps: u32,
        maps: Maps,
    ) -> Self {
        let (cores, slots) = (gpu.cores.count as usize, resident_warps as usize);
        let copies = gpu.caches[gpu.paths.ssbo[0]].copies as usize;
        Self {
            caches: Caches::new(gpu, hierarchy, paths, places),
            resident: (0..cores * slots).map(|_| Slot::default()).collect(),
            ready: ReadyTimes::new(cores, slots),
            cores,
            slots,
            busy_until: vec![0.0; cores],
            copies: (0..cores).map(|core| core * copies / cores).collect(),
            shared_until: vec![0.0; copies],
            next: vec![0; cores],
            starts: vec![f64::INFINITY; cores],
            rates: {
                let of_unit = |rate: fn(&RayUnit) -> f64| gpu.ray_unit.as_ref().map_or(f64::INFINITY, rate);
                let tests = [of_unit(|unit| unit.boxes_per_clock), of_unit(|unit| unit.triangles_per_clock)];
                [gpu.cores.alu_lanes, gpu.cores.efu_lanes, tests[0], tests[1]]
            },
            occupied: vec![0; cores],
            waiting: VecDeque::new(),
            schedule: ScheduleCounters::default(),
            windows: WindowLog::default(),
            maps,
            next_number: 0,
            sampled: SAMPLED_TURNS[0],
            until_sample: SAMPLED_TURNS[0],
            from_memory: 0,
            bank_delay: -gpu.dram.row_open_seconds * gpu.clock.hz..gpu.dram.row_cycle_seconds * gpu.clock.hz,
        }
    }

    /// Lines that each warp read from memory, by its number.
    pub(crate) fn misses_by_warp(&self) -> &[u32] {
        &self.caches.lines_from_memory
    }

    /// Lets the caches, those of the first core among them, see accesses of one line each that no warp makes, at no time.
    pub(crate) fn touch(&mut self, accesses: impl Iterator<Item = (Run, u32)>) {
        for (run, line) in accesses {
            self.caches.access(0, Resident::default(), run, &[line, 0, 0, 0]);
        }
        self.caches.forget_warps();
    }

    /// Queues the warps of a tile.
    pub(crate) fn push(&mut self, streams: &TileStreams) {
        let least_cycles = self.least_cycles(streams);
        for warp in 0..streams.warps() {
            let (tree, own) = (streams.tree.warp(warp), streams.own.warp(warp));
            self.schedule.warps += 1;
            let number = self.next_number;
            self.next_number += 1;
            if self.maps == Maps::Kept {
                self.caches.lines_from_memory.push(0);
            }
            // A warp that touches no memory takes no turn.
            if !(tree.is_empty() && own.is_empty()) {
                let streams = streams.clone();
                self.waiting.push_back(Waiting { streams, tree, own, number, least_cycles });
            }
        }
    }

    /// Cycles of a core that the ALU, the elementary function unit or the ray unit takes for a turn of the tile on average.
    fn least_cycles(&self, TileStreams { tree, own }: &TileStreams) -> f64 {
        let (mut turns, mut issued) = (0, [0; 4]);
        for issue in [tree, own].into_iter().flat_map(|stream| &stream.issue) {
            turns += issue.turns;
            issued[0] += issue.alu_issued;
            issued[1] += issue.efu_issued;
            issued[2] += issue.unit_box_places;
            issued[3] += issue.unit_triangle_places;
        }
        let cycles = issued.into_iter().zip(self.rates).map(|(issued, rate)| issued as f64 / rate);
        cycles.fold(0.0, f64::max) / turns.max(1) as f64
    }

    /// Runs ticks as long as no core can lack a warp that a later tile would bring.
    pub(crate) fn run_ahead(&mut self) {
        self.fill();
        while self.waiting.len() >= self.cores {
            self.tick();
        }
    }

    /// Runs until a slot is free that no warp waits for: up to here, all is as if more were to come.
    pub(crate) fn run_until_short(&mut self) {
        self.fill();
        let full = self.cores * self.slots;
        while !self.waiting.is_empty() || self.occupied.iter().sum::<usize>() == full {
            self.tick();
        }
    }

    /// Ends a stretch of time: what comes after it has windows of its own.
    pub(crate) fn end_stretch(&mut self, pass: Pass) -> Sums {
        let seen = self.caches.seen();
        self.windows.end_phase(pass, &seen);
        let Self { schedule, caches, .. } = self;
        Sums { traffic: caches.traffic_by_pass(), schedule: *schedule, memory_reads: caches.memory_reads() }
    }

    /// Runs to the end of the last warp: what is queued afterwards begins on empty cores. `pass` is the first of what ends.
    pub(crate) fn drain(&mut self, pass: Pass) {
        self.fill();
        while self.occupied.iter().any(|&warps| warps > 0) {
            self.tick();
        }
        let seen = self.caches.seen();
        self.windows.end_phase(pass, &seen);
        self.caches.delays.clear();
        // Time begins anew with the next phase, as it does on empty cores.
        self.shared_until.fill(0.0);
    }

    /// From now on a core holds so many warps; it is empty.
    pub(crate) fn set_resident_warps(&mut self, warps: u32) {
        debug_assert!(self.waiting.is_empty() && self.occupied.iter().all(|&warps| warps == 0));
        self.slots = warps as usize;
        let slots = self.cores * self.slots;
        self.resident.resize_with(slots, Slot::default);
        self.ready = ReadyTimes::new(self.cores, self.slots);
    }

    /// Writes dirty lines back; everything has been drained.
    pub(crate) fn finish(mut self) -> Finished {
        let traffic = self.caches.traffic_by_pass();
        // The positions of a flush are level indices.
        let Served { levels, memory } = self.caches.hierarchy.flush();
        let flush = BufferTraffic {
            levels,
            dram_read_bytes: memory.read_bytes,
            dram_write_bytes: memory.write_bytes,
        };
        let Self { schedule, windows, .. } = self;
        Finished { traffic, flush, schedule, phases: windows.phases(), timed: None }
    }

    /// Puts waiting warps into free slots: the first slots of all cores, then the second ones, and so on.
    fn fill(&mut self) {
        let now = self.starts.iter().copied().fold(f64::INFINITY, f64::min);
        let now = if now.is_finite() { now } else { 0.0 };
        for slot in 0..self.slots {
            for core in 0..self.cores {
                let place = core * self.slots + slot;
                if self.resident[place].is_free() && self.resident[place].refill(&mut self.waiting) {
                    if self.occupied[core] == 0 {
                        self.busy_until[core] = now;
                    }
                    self.occupied[core] += 1;
                    self.ready.set(place, self.busy_until[core]);
                }
            }
        }
        (0..self.cores).for_each(|core| self.plan(core));
    }

    /// Finds the next turn of a core.
    fn plan(&mut self, core: usize) {
        let place = self.ready.first(core);
        self.next[core] = place;
        self.starts[core] = self.busy_until[core].max(self.ready.at(place));
    }

    fn tick(&mut self) {
        let resident: usize = self.occupied.iter().sum();
        self.schedule.ticks += 1;
        self.schedule.warp_ticks += resident as u64;
        let occupied = self.occupied.iter().filter(|&&warps| warps > 0).count();
        self.schedule.full_ticks += u64::from(occupied == self.cores);
        if self.windows.tick(occupied as u64, resident as u64) {
            let seen = self.caches.seen();
            self.windows.end_window(&seen);
        }
        for _ in 0..occupied {
            self.issue(first_of(&self.starts));
        }
    }

    #[cold]
    fn until_next_sample(&mut self) {
        let passed = SAMPLED_UP_TO.iter().filter(|&&up_to| self.sampled >= up_to).count();
        self.until_sample = SAMPLED_TURNS[passed];
        self.sampled += self.until_sample;
    }

    /// Lets the next warp of a core issue one turn.
    fn issue(&mut self, core: usize) {
        let (place, start) = (self.next[core], self.starts[core]);
        self.until_sample -= 1;
        let sampled = self.until_sample == 0;
        if sampled {
            self.until_next_sample();
        }
        let before = sampled.then(|| self.caches.misses());
        let slot = &mut self.resident[place];
        let Slot { words, next, other, number, first, least_cycles } = slot;
        let warp = Resident { place: place as u32, number: *number };
        let (mut lines, mut port_cycles) = (0, 0);
        let mut word = *first;
        let last = loop {
            let run = Run::from_word(word);
            self.caches.access(core as u32, warp, run, &words[next.start as usize + 1..]);
            lines += run.lines();
            port_cycles += run.port_cycles();
            next.start += 1 + run.lines() as u32;
            if run.is_last() || Range::is_empty(next) {
                break run;
            }
            word = words[next.start as usize];
        };
        let least_cycles = *least_cycles;
        if last.crosses() || Range::is_empty(next) {
            std::mem::swap(next, other);
        }
        slot.look_ahead();
        if let Some(before) = before {
            self.caches.sample(last, lines, before);
        }
        self.busy_until[core] = start + least_cycles.max(f64::from(port_cycles));
        let Waits { queue, latency } = self.caches.end_turn(last);
        let served = &mut self.shared_until[self.copies[core]];
        *served = served.max(start) + queue;
        let mut ready = self.busy_until[core].max(*served) + latency;
        if slot.is_free() && !slot.refill(&mut self.waiting) {
            ready = f64::INFINITY;
            self.occupied[core] -= 1;
        }
        self.ready.set(place, ready);
        self.plan(core);
        self.hold_up();
    }

    /// Lets the warps wait whose data have turned out to be far away.
    fn hold_up(&mut self) {
        if self.caches.delays.is_empty() {
            return;
        }
        let mut delays = std::mem::take(&mut self.caches.delays);
        let mut held_up = None;
        for Delay { place, cycles, memory } in delays.drain(..) {
            let mut bank = 0.0;
            if memory {
                self.from_memory += 1;
                let Range { start, end } = self.bank_delay;
                bank = start + (end - start) * fraction(self.from_memory);
            }
            let place = place as usize;
            self.ready.set(place, self.ready.at(place) + (cycles + bank).max(0.0));
            // Those of a core come one after the other.
            let core = place / self.slots;
            if let Some(before) = held_up.replace(core).filter(|&before| before != core) {
                self.plan(before);
            }
        }
        held_up.into_iter().for_each(|core| self.plan(core));
        self.caches.delays = delays;
    }
}

/// The place of the least of some numbers, the first of them if there are several.
fn first_of(times: &[f64]) -> usize {
    let (mut first, mut least) = (0, times[0]);
    for (place, &time) in times.iter().enumerate().skip(1) {
        if time < least {
            (first, least) = (place, time);
        }
    }
    first
}
