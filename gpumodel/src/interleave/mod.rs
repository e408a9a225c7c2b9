//! Warps share the cores and the caches.
//!
//! Warps are issued in tile order; each goes to the first free slot, slots being counted across the cores before the next
//! slot of the first. A turn is the loads and stores of a warp up to its next wait. The order of turns is the order in which the caches
//! see the accesses, and it decides what they have to hold: a warp whose data are far away is held up, so it stays for longer beside
//! others like it. So turns have times, from which nothing but their order is taken; how long a frame takes is found afterwards from what it asked for.
//!
//! On each core the warp that has been ready for longest is next, and the core whose next turn starts first issues it. A turn keeps
//! its core busy for the cycles of the load/store port, or for the mean share of a turn of its tile in the ALU's or the elementary functions'
//! time, if that is longer. The warp is ready again when its data are there: after the latency of the farthest place that they come from.
//! Memory's is drawn evenly from what a DRAM bank may make of it, from an open row to one that was opened just before: with equal latencies
//! warps could keep in step for a whole frame.
//! The only queue is that for a cache which cores share and which is the first on a path: with many lines per turn it would
//! otherwise be asked for more than it can serve.
//!
//! In a tick as many turns are issued as there are cores with warps.

mod caches;

use self::caches::{Caches, Delay, Resident, Waits};
use crate::config::Gpu;
use crate::counters::{BufferTraffic, Pass, ScheduleCounters, TrafficCounters};
use crate::engine::Finished;
use crate::layout::{BufferKind, Places};
use crate::random::fraction;
use crate::replay::Maps;
use crate::warp::{Run, TileStreams};
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
}

impl KindPaths {
    /// `ids` are those of [`Paths::as_slices`](crate::Paths::as_slices).
    pub(crate) fn new(ids: &[PathId]) -> Self {
        Self { ssbo: ids[0], texture: ids[1], private: ids[2], vertex: ids[3] }
    }

    /// A compute stage stores into an image as into a storage buffer; it is read as a texture.
    pub(crate) fn of(&self, kind: BufferKind, write: bool) -> PathId {
        match kind {
            BufferKind::Node | BufferKind::Primitive | BufferKind::Index | BufferKind::Normal => self.ssbo,
            BufferKind::Image | BufferKind::Attachment if write => self.ssbo,
            BufferKind::Image | BufferKind::Attachment => self.texture,
            BufferKind::Stack => self.private,
            BufferKind::Vertex => self.vertex,
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

/// What a slot of a core holds: a copy of the words of its warp, so that those of all resident warps lie close together.
#[derive(Default)]
struct Slot {
    /// With the padding of a stream.
    words: Vec<u32>,
    /// Words that are yet to issue: of the stream that the next turn is in, and of the other.
    next: Range<usize>,
    other: Range<usize>,
    number: u32,
    /// Of the core's time that a turn takes at least.
    least_cycles: f64,
}

impl Slot {
    fn is_free(&self) -> bool {
        self.next.is_empty()
    }

    /// Takes the warp that has waited longest; false if there is none.
    fn refill(&mut self, waiting: &mut VecDeque<Waiting>) -> bool {
        let Some(Waiting { streams, tree, own, number, least_cycles }) = waiting.pop_front() else {
            return false;
        };
        let mut words = std::mem::take(&mut self.words);
        words.clear();
        words.extend_from_slice(&streams.tree.words[tree]);
        let tree = 0..words.len();
        words.extend_from_slice(streams.own.padded(own.clone()));
        let own = tree.end..tree.end + own.len();
        let own_leads = tree.is_empty() || (!own.is_empty() && Run::from_word(words[own.start]).begins());
        let (next, other) = if own_leads { (own, tree) } else { (tree, own) };
        *self = Self { words, next, other, number, least_cycles };
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
    /// Of each slot, when its warp can issue the next turn, in cycles; infinite without one.
    ready: Vec<f64>,
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
    /// ALU and elementary function lanes of a core.
    lanes: [f64; 2],
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
            ready: vec![f64::INFINITY; cores * slots],
            cores,
            slots,
            busy_until: vec![0.0; cores],
            copies: (0..cores).map(|core| core * copies / cores).collect(),
            shared_until: vec![0.0; copies],
            next: vec![0; cores],
            starts: vec![f64::INFINITY; cores],
            lanes: [gpu.cores.alu_lanes, gpu.cores.efu_lanes],
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

    /// Cycles of a core that the ALU, or the elementary function unit, takes for a turn of the tile on average.
    fn least_cycles(&self, TileStreams { tree, own }: &TileStreams) -> f64 {
        let (mut turns, mut issued) = (0, [0; 2]);
        for issue in [tree, own].into_iter().flat_map(|stream| &stream.issue) {
            turns += issue.turns;
            issued[0] += issue.alu_issued;
            issued[1] += issue.efu_issued;
        }
        let cycles = |unit: usize| issued[unit] as f64 / self.lanes[unit];
        cycles(0).max(cycles(1)) / turns.max(1) as f64
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
                    self.ready[place] = self.busy_until[core];
                }
            }
        }
        (0..self.cores).for_each(|core| self.plan(core));
    }

    /// Finds the next turn of a core.
    fn plan(&mut self, core: usize) {
        let slots = core * self.slots..(core + 1) * self.slots;
        let place = slots.start + first_of(&self.ready[slots]);
        self.next[core] = place;
        self.starts[core] = self.busy_until[core].max(self.ready[place]);
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
        let Slot { words, next, other, number, least_cycles } = slot;
        let warp = Resident { place: place as u32, number: *number };
        let (mut lines, mut port_cycles) = (0, 0);
        let last = loop {
            let run = Run::from_word(words[next.start]);
            self.caches.access(core as u32, warp, run, &words[next.start + 1..]);
            lines += run.lines();
            port_cycles += run.port_cycles();
            next.start += 1 + run.lines();
            if run.is_last() || Range::is_empty(next) {
                break run;
            }
        };
        if last.crosses() || Range::is_empty(next) {
            std::mem::swap(next, other);
        }
        if let Some(before) = before {
            self.caches.sample(last, lines, before);
        }
        self.busy_until[core] = start + least_cycles.max(f64::from(port_cycles));
        let Waits { queue, latency } = self.caches.end_turn(last);
        let served = &mut self.shared_until[self.copies[core]];
        *served = served.max(start) + queue;
        self.ready[place] = self.busy_until[core].max(*served) + latency;
        if slot.is_free() && !slot.refill(&mut self.waiting) {
            self.ready[place] = f64::INFINITY;
            self.occupied[core] -= 1;
        }
        self.plan(core);
        self.hold_up();
    }

    /// Lets the warps wait whose data have turned out to be far away.
    fn hold_up(&mut self) {
        if self.caches.delays.is_empty() {
            return;
        }
        for Delay { place, cycles, memory } in self.caches.delays.drain(..) {
            let mut bank = 0.0;
            if memory {
                self.from_memory += 1;
                let Range { start, end } = self.bank_delay;
                bank = start + (end - start) * fraction(self.from_memory);
            }
            self.ready[place as usize] += (cycles + bank).max(0.0);
        }
        (0..self.cores).for_each(|core| self.plan(core));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::gpu;
    use crate::warp::TileStream;
    use cachesim::LineId;
    use proptest::prelude::*;

    proptest! {
        /// Why repeats of short runs need not be simulated.
        #[test]
        fn a_repeated_run_of_no_more_lines_than_ways_hits_and_leaves_an_lru_cache_as_it_was(
            runs in prop::collection::vec(prop::collection::btree_set(0_u64..6000, 1..=8), 1..400)
        ) {
            let machine = gpu(&[("value = 131072", "value = 8192")]);
            let fresh = || machine.hierarchy().unwrap();
            let ((mut once, paths), (mut twice, _)) = (fresh(), fresh());
            for run in runs {
                let lines: Vec<LineId> = run.into_iter().map(LineId::new).collect();
                let first = once.read(paths[0], 0, &lines);
                prop_assert_eq!(first, twice.read(paths[0], 0, &lines));
                let again = twice.read(paths[0], 0, &lines);
                prop_assert_eq!(again.levels[0].misses, 0);
                prop_assert_eq!(again.memory.reads, 0);
            }
        }
    }

    fn stream(warps: &[&[(BufferKind, u32)]]) -> TileStreams {
        let mut writer = crate::warp::StreamWriter::default();
        let mut ends = Vec::new();
        for warp in warps {
            for &(kind, line) in *warp {
                writer.lines()[0] = line;
                writer.push(Run::new(Pass::Primary, kind, false, 1, 1));
                writer.end_turn();
            }
            ends.push(writer.len());
        }
        TileStreams::joined(TileStream { words: writer.take(), warp_ends: ends, ..TileStream::default() })
    }

    fn interleaver(resident: u32) -> Interleaver {
        let machine = gpu(&[]);
        let (hierarchy, paths) = machine.hierarchy().unwrap();
        Interleaver::new(
            &machine,
            hierarchy,
            KindPaths::new(&paths),
            Places { stack_base_line: 1000, stack_stride_lines: 10, end: 0 },
            resident,
            Maps::Dropped,
        )
    }

    #[test]
    fn a_warp_is_not_ready_before_its_data_and_its_core_lets_others_go_on() {
        let machine = gpu(&[]);
        let path = &machine.paths.ssbo;
        let [near, far] = [0, path.len()].map(|place| machine.latency_cycles(path, place));
        let mut interleaver = interleaver(2);
        // One warp on each core, and a second one on the first.
        let twice: &[(BufferKind, u32)] = &[(BufferKind::Node, 1), (BufferKind::Node, 1)];
        let others: &[(BufferKind, u32)] = &[(BufferKind::Node, 2)];
        interleaver.push(&stream(&[twice, others, others, others, twice]));
        interleaver.fill();
        let issue = |interleaver: &mut Interleaver| {
            interleaver.issue(0);
            interleaver.caches.flush_pending();
            interleaver.hold_up();
        };
        // The first warp's line comes from memory. The second one's is in the cache then.
        issue(&mut interleaver);
        issue(&mut interleaver);
        let (busy_until, shared_until) = (interleaver.busy_until[0], interleaver.shared_until[0]);
        let (late, soon) = (interleaver.ready[0], interleaver.ready[1]);
        assert_eq!((soon, interleaver.next[0]), (shared_until + near, 1));
        assert!(shared_until > busy_until, "a line takes the cache's time, and none of the port's here");
        let Range { start, end } = interleaver.bank_delay;
        assert!(start < 0.0 && end > 0.0);
        assert!((far + start..shared_until + far + end).contains(&late), "{late}");
    }

    #[test]
    fn the_core_whose_turn_starts_first_goes_first() {
        let mut writer = crate::warp::StreamWriter::default();
        let mut turn = |port_cycles: u32| {
            writer.lines()[0] = 1;
            let run = Run::new(Pass::Primary, BufferKind::Node, false, 1, 1);
            writer.push(run.with_port_cycles(port_cycles));
            writer.end_turn();
            writer.len()
        };
        // On one core a long turn and a short one, on another short ones.
        let (_, first) = (turn(500), turn(1));
        let second = (0..6).map(|_| turn(1)).last().unwrap();
        let stream =
            TileStream { words: writer.take(), warp_ends: vec![first, second], ..TileStream::default() };
        let mut interleaver = interleaver(1);
        interleaver.push(&TileStreams::joined(stream));
        interleaver.fill();
        for _ in 0..3 {
            interleaver.tick();
        }
        // Six turns: the long one, and five of the other core.
        let turns_left = [0, 1].map(|core| interleaver.resident[core].next.len() / 2);
        assert_eq!(turns_left, [1, 1]);
    }

    #[test]
    fn cores_and_slots_take_turns_and_ticks_are_counted() {
        let mut interleaver = interleaver(2);
        let turns: &[(BufferKind, u32)] = &[(BufferKind::Node, 1), (BufferKind::Node, 2)];
        // Nine warps of two turns on four cores of two slots: eight are resident at once, the ninth follows the first.
        interleaver.push(&stream(&[turns; 9]));
        interleaver.drain(Pass::Primary);
        let Finished { schedule, phases, .. } = interleaver.finish();
        assert_eq!(schedule.warps, 9);
        // 18 turns, 16 of which have one of every core beside them, if no core is quicker than the others.
        assert_eq!(phases[0].windows.iter().map(|window| window.turns).sum::<u64>(), 18);
        assert!((5..=18).contains(&schedule.ticks) && (1..=4).contains(&schedule.full_ticks));
    }

    #[test]
    fn time_begins_anew_with_each_phase() {
        let mut interleaver = interleaver(1);
        let turns: &[(BufferKind, u32)] = &[(BufferKind::Node, 1); 50];
        let ready = |interleaver: &mut Interleaver| {
            interleaver.push(&stream(&[turns; 4]));
            interleaver.fill();
            interleaver.issue(0);
            interleaver.ready[0]
        };
        let first = ready(&mut interleaver);
        interleaver.drain(Pass::Primary);
        let second = ready(&mut interleaver);
        assert!(second <= first, "{second} after {first}, though the line is in a cache by now");
    }

    #[test]
    fn of_equal_times_the_first_is_taken() {
        assert_eq!(first_of(&[3.0, 1.0, f64::INFINITY, 1.0]), 1);
        assert_eq!(first_of(&[f64::INFINITY, 7.0]), 1);
    }

    #[test]
    fn every_resident_warp_has_a_stack_of_its_own() {
        let mut interleaver = interleaver(2);
        let stack: &[(BufferKind, u32)] = &[(BufferKind::Stack, 0)];
        interleaver.push(&stream(&[stack; 8]));
        interleaver.drain(Pass::Primary);
        let passes = interleaver.finish().traffic;
        assert_eq!(passes[Pass::Primary as usize].stack.levels[1].misses, 8);
    }

    #[test]
    fn the_next_warp_of_a_slot_inherits_its_stack() {
        let mut interleaver = interleaver(1);
        let stack: &[(BufferKind, u32)] = &[(BufferKind::Stack, 0)];
        interleaver.push(&stream(&[stack; 8]));
        interleaver.drain(Pass::Primary);
        let passes = interleaver.finish().traffic;
        assert_eq!(
            (
                passes[Pass::Primary as usize].stack.levels[1].accesses,
                passes[Pass::Primary as usize].stack.levels[1].misses
            ),
            (8, 4)
        );
    }

    #[test]
    fn the_order_of_accesses_does_not_depend_on_how_many_tiles_are_known() {
        let turns: Vec<(BufferKind, u32)> =
            (0..40).map(|turn| (BufferKind::Node, turn * 37 % 5000)).collect();
        let tiles: Vec<_> = (1..12).map(|tile| stream(&vec![&turns[..tile * 3]; tile])).collect();
        let mut eager = interleaver(3);
        for tile in &tiles {
            eager.push(tile);
            eager.run_ahead();
        }
        let mut lazy = interleaver(3);
        tiles.iter().for_each(|tile| lazy.push(tile));
        eager.drain(Pass::Primary);
        lazy.drain(Pass::Primary);
        assert_eq!(eager.finish(), lazy.finish());
    }

    #[test]
    fn turns_that_are_looked_at_tell_how_many_lines_they_have_on_their_way_and_how_unequally() {
        // By turn, new lines: 1, 2, 3; a turn without any has one that is there already.
        let turns = [[1, 1, 1], [2, 3, 2], [4, 5, 6], [1, 1, 1]];
        let mut writer = crate::warp::StreamWriter::default();
        for lines in turns {
            for line in lines {
                writer.lines()[0] = line;
                writer.push(Run::new(Pass::Primary, BufferKind::Image, false, 1, 1));
            }
            writer.end_turn();
        }
        let ends = vec![writer.len()];
        let stream = TileStream { words: writer.take(), warp_ends: ends, ..TileStream::default() };
        let mut interleaver = interleaver(1);
        interleaver.push(&TileStreams::joined(stream));
        interleaver.drain(Pass::Primary);
        let waits = interleaver.finish().phases[0].windows[0].waits;
        // The texture L1 belongs to a core, so what it has is not on its way.
        assert_eq!((waits.turns, waits.lines, waits.squares), (4, 1 + 2 + 3, 1 + 4 + 9));
    }
}
