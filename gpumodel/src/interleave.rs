//! Warps share the cores and the caches.
//!
//! Warps are issued in tile order; each goes to the first free slot, slots being counted across the cores before the next
//! slot of the first. In every tick each core that has a warp lets the next one of its slots, round-robin, issue one turn: the loads and
//! stores up to its next wait. The order of turns is the order in which the caches see the accesses.

use crate::config::Gpu;
use crate::counters::{BufferTraffic, Pass, ScheduleCounters, TrafficCounters, WaitCounters};
use crate::engine::Finished;
use crate::layout::{BufferKind, Places};
use crate::replay::Maps;
use crate::warp::{Run, TileStreams};
use crate::windows::{Seen, WindowLog};
use cachesim::{Access, Hierarchy, LevelServed, LineId, MAX_LEVELS, PathId, Policy, Served};
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

/// How runs of one key reach the caches.
#[derive(Clone, Copy)]
struct Route {
    path: PathId,
    write: bool,
    /// The path has caches private to a core.
    by_core: bool,
    /// The first of them is private to a core.
    own_cache: bool,
    /// Runs of at most this many lines, repeated at once, hit every time after the first and change nothing.
    repeatable_lines: usize,
    /// First line, and lines per resident warp, of a private buffer; 0 for others.
    private: (u32, u32),
}

/// A warp that waits for a slot: its words in the streams of its tile.
struct Waiting {
    streams: TileStreams,
    tree: Range<usize>,
    own: Range<usize>,
    number: u32,
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
}

impl Slot {
    fn is_free(&self) -> bool {
        self.next.is_empty()
    }

    /// Takes the warp that has waited longest; false if there is none.
    fn refill(&mut self, waiting: &mut VecDeque<Waiting>) -> bool {
        let Some(Waiting { streams, tree, own, number }) = waiting.pop_front() else {
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
        *self = Self { words, next, other, number };
        true
    }
}

/// The cores, their warps, and the caches that they share.
pub(crate) struct Interleaver {
    caches: Caches,
    /// Slots of core `c` are at `c * slots ..`.
    resident: Vec<Slot>,
    cores: usize,
    slots: usize,
    /// Per core, the slot whose turn is next.
    turn: Vec<usize>,
    /// Per core, warps in its slots.
    occupied: Vec<usize>,
    waiting: VecDeque<Waiting>,
    schedule: ScheduleCounters,
    windows: WindowLog,
    /// Lines that each warp read from memory, by its number; empty where no maps are kept.
    misses: Vec<u32>,
    maps: Maps,
    next_number: u32,
    /// Turns up to the one that is looked at next, and from now until then.
    sampled: u64,
    until_sample: u64,
}

/// Of so many turns, it is seen how far away the data of one are: of the first turns, which may be all, of each; of later ones, of
/// few. Primes, so that they keep step with no loop of a shader.
const SAMPLED_TURNS: [u64; 3] = [1, 17, 127];
/// Up to which turn each of these but the last holds.
const SAMPLED_UP_TO: [u64; 2] = [1 << 12, 1 << 18];

/// The caches, and accesses gathered for them.
struct Caches {
    hierarchy: Hierarchy,
    routes: [Option<Route>; Run::KEYS],
    /// The first `gathered` of [`PENDING`] take one path of one core.
    pending: Vec<Access>,
    /// Of each of these, the key.
    pending_keys: Vec<u8>,
    gathered: usize,
    pending_path: PathId,
    pending_core: u32,
    /// By key, accesses that hit without being simulated.
    spared: Vec<u64>,
    /// By key.
    served: Vec<Served>,
    /// Of the turns that were looked at.
    waits: WaitCounters,
}

/// When so many accesses are gathered, the caches see them.
const PENDING: usize = 4096;
/// No run has more lines.
const MOST_LINES: usize = 256;

impl Interleaver {
    pub(crate) fn new(
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        places: Places,
        resident_warps: u32,
        maps: Maps,
    ) -> Self {
        let stacks = (places.stack_base_line, places.stack_stride_lines);
        let (cores, slots) = (gpu.cores.count as usize, resident_warps as usize);
        let route = |key: usize| {
            let (_, kind, write) = Run::of_key(key)?;
            let path = first_alike(&hierarchy, paths.of(kind, write), paths);
            let levels = hierarchy.path(path);
            let first = &gpu.levels().as_slice()[levels[0]];
            // Other policies may evict one line of the run for another, or rank a line anew when it hits.
            let repeatable = first.policy == Policy::Lru && !write;
            Some(Route {
                path,
                write,
                by_core: levels.iter().any(|&level| gpu.caches[level].copies > 1),
                own_cache: gpu.caches[levels[0]].copies == gpu.cores.count,
                repeatable_lines: if repeatable { first.way_count() as usize } else { 0 },
                private: if kind == BufferKind::Stack { stacks } else { (0, 0) },
            })
        };
        Self {
            caches: Caches {
                routes: std::array::from_fn(route),
                hierarchy,
                pending: vec![Access::read(LineId::new(0)); PENDING + MOST_LINES],
                pending_keys: vec![0; PENDING + MOST_LINES],
                gathered: 0,
                pending_path: paths.ssbo,
                pending_core: 0,
                spared: vec![0; Run::KEYS],
                served: vec![Served::default(); Run::KEYS],
                waits: WaitCounters::default(),
            },
            resident: (0..cores * slots).map(|_| Slot::default()).collect(),
            cores,
            slots,
            turn: vec![0; cores],
            occupied: vec![0; cores],
            waiting: VecDeque::new(),
            schedule: ScheduleCounters::default(),
            windows: WindowLog::default(),
            misses: Vec::new(),
            maps,
            next_number: 0,
            sampled: SAMPLED_TURNS[0],
            until_sample: SAMPLED_TURNS[0],
        }
    }

    /// Lines that each warp read from memory, by its number.
    pub(crate) fn misses_by_warp(&self) -> &[u32] {
        &self.misses
    }

    /// Queues the warps of a tile.
    pub(crate) fn push(&mut self, streams: &TileStreams) {
        for warp in 0..streams.warps() {
            let (tree, own) = (streams.tree.warp(warp), streams.own.warp(warp));
            self.schedule.warps += 1;
            let number = self.next_number;
            self.next_number += 1;
            if self.maps == Maps::Kept {
                self.misses.push(0);
            }
            // A warp that touches no memory takes no turn.
            if !(tree.is_empty() && own.is_empty()) {
                self.waiting.push_back(Waiting { streams: streams.clone(), tree, own, number });
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

    /// Runs to the end of the last warp: what is queued afterwards begins on empty cores. `pass` is the first of what ends.
    pub(crate) fn drain(&mut self, pass: Pass) {
        self.fill();
        while self.occupied.iter().any(|&warps| warps > 0) {
            self.tick();
        }
        let seen = self.caches.seen();
        self.windows.end_phase(pass, &seen);
    }

    /// Writes dirty lines back; everything has been drained.
    pub(crate) fn finish(mut self) -> Finished {
        let mut passes = [TrafficCounters::default(); Pass::COUNT];
        for key in 0..Run::KEYS {
            if let Some((pass, kind, _)) = Run::of_key(key) {
                *passes[pass as usize].of_mut(kind) += self.caches.traffic(key);
            }
        }
        // The positions of a flush are level indices.
        let Served { levels, memory } = self.caches.hierarchy.flush();
        let flush = BufferTraffic {
            levels,
            dram_read_bytes: memory.read_bytes,
            dram_write_bytes: memory.write_bytes,
        };
        let Self { schedule, windows, .. } = self;
        Finished { traffic: passes, flush, schedule, phases: windows.phases(), timed: None }
    }

    /// Puts waiting warps into free slots: the first slots of all cores, then the second ones, and so on.
    fn fill(&mut self) {
        for slot in 0..self.slots {
            for core in 0..self.cores {
                let slot = &mut self.resident[core * self.slots + slot];
                if slot.is_free() {
                    self.occupied[core] += usize::from(slot.refill(&mut self.waiting));
                }
            }
        }
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
        for core in 0..self.cores {
            if self.occupied[core] > 0 {
                self.issue(core);
            }
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
        let first = core * self.slots;
        let mut slot = self.turn[core];
        while self.resident[first + slot].is_free() {
            slot = if slot + 1 == self.slots { 0 } else { slot + 1 };
        }
        self.turn[core] = if slot + 1 == self.slots { 0 } else { slot + 1 };
        self.until_sample -= 1;
        let sampled = self.until_sample == 0;
        if sampled {
            self.until_next_sample();
        }
        let before = sampled.then(|| self.caches.misses());
        // Where maps are kept, nothing is pending between turns.
        let reads_before = (self.maps == Maps::Kept).then(|| self.caches.hierarchy.memory().reads);
        let (resident, slot) = ((first + slot) as u32, &mut self.resident[first + slot]);
        let Slot { words, next, other, number } = slot;
        let mut lines = 0;
        let last = loop {
            let run = Run::from_word(words[next.start]);
            self.caches.access(core as u32, resident, run, &words[next.start + 1..]);
            lines += run.lines();
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
        if let Some(before) = reads_before {
            self.caches.flush_pending();
            let missed = self.caches.hierarchy.memory().reads - before;
            self.misses[*number as usize] += missed as u32;
        }
        if slot.is_free() {
            self.occupied[core] -= usize::from(!slot.refill(&mut self.waiting));
        }
    }
}

impl Caches {
    /// `lines` begins with those of the run.
    #[inline(always)]
    fn access(&mut self, core: u32, resident: u32, run: Run, lines: &[u32]) {
        let key = run.key();
        let Some(Route { path, write, by_core, repeatable_lines, private: (base, stride), .. }) =
            self.routes[key]
        else {
            return;
        };
        let core = if by_core { core } else { 0 };
        if path != self.pending_path || core != self.pending_core {
            self.flush_pending();
            (self.pending_path, self.pending_core) = (path, core);
        }
        let count = run.lines();
        let repeats = if count <= repeatable_lines { 1 } else { run.repeats() as usize };
        self.spared[key] += (run.repeats() as usize - repeats) as u64 * count as u64;
        let base = base + resident * stride;
        for _ in 0..repeats {
            if self.gathered >= PENDING {
                self.flush_pending();
            }
            // By fours, as most runs have no more: a loop of just as many steps would end where nobody expects it.
            let (accesses, keys) =
                (&mut self.pending[self.gathered..], &mut self.pending_keys[self.gathered..]);
            let places = accesses.as_chunks_mut::<4>().0.iter_mut().zip(keys.as_chunks_mut::<4>().0);
            for ((places, keys), four) in places.zip(lines.as_chunks::<4>().0).take(count.div_ceil(4)) {
                *places = four.map(|line| Access::new(LineId::new(u64::from(base + line)), write));
                *keys = [key as u8; 4];
            }
            self.gathered += count;
        }
    }

    /// Lets the caches see what has been gathered.
    fn flush_pending(&mut self) {
        let (accesses, keys) = (&self.pending[..self.gathered], &self.pending_keys[..self.gathered]);
        self.hierarchy.access_by_class(
            self.pending_path,
            self.pending_core,
            accesses,
            keys,
            &mut self.served,
        );
        self.gathered = 0;
    }

    /// All that the caches have seen.
    fn seen(&mut self) -> Seen {
        self.flush_pending();
        let mut levels = [LevelServed::default(); MAX_LEVELS];
        for (level, served) in levels.iter_mut().take(self.hierarchy.levels().as_slice().len()).enumerate() {
            let counts = self.hierarchy.counts(level);
            *served = LevelServed { accesses: counts.accesses, misses: counts.misses };
        }
        for (route, spared) in self.routes.iter().zip(&self.spared) {
            if let Some(route) = route {
                levels[self.hierarchy.path(route.path)[0]].accesses += spared;
            }
        }
        let memory = self.hierarchy.memory();
        Seen {
            levels,
            memory_bytes: memory.read_bytes + memory.write_bytes,
            page_walks: self.hierarchy.page_walks(),
            waits: self.waits,
        }
    }

    /// Misses of each level, and last of memory, once all that has been gathered is in the caches.
    fn misses(&mut self) -> [u64; MAX_LEVELS + 1] {
        self.flush_pending();
        let mut misses = [0; MAX_LEVELS + 1];
        for (level, misses) in misses.iter_mut().take(self.hierarchy.levels().as_slice().len()).enumerate() {
            *misses = self.hierarchy.counts(level).misses;
        }
        misses[MAX_LEVELS] = self.hierarchy.memory().reads;
        misses
    }

    /// Notes from where the lines of a turn came, whose last run is `last`; `before` are the misses before it.
    fn sample(&mut self, last: Run, lines: usize, before: [u64; MAX_LEVELS + 1]) {
        let after = self.misses();
        let Some(route) = self.routes[last.key()].as_ref() else { return };
        let first = self.hierarchy.path(route.path)[0];
        let lines = if route.own_cache { after[first] - before[first] } else { lines as u64 };
        self.waits.turns += 1;
        self.waits.lines += lines;
        self.waits.squares += lines * lines;
        if route.write {
            return;
        }
        let path = self.hierarchy.path(route.path);
        let missed = |&level: &usize| after[level] > before[level];
        let from = if after[MAX_LEVELS] > before[MAX_LEVELS] {
            MAX_LEVELS
        } else {
            let passed = path.iter().take_while(|level| missed(level)).count();
            path[passed.min(path.len() - 1)]
        };
        self.waits.from[from] += 1;
    }

    /// What the accesses of a key caused.
    fn traffic(&self, key: usize) -> BufferTraffic {
        let mut traffic = BufferTraffic::default();
        let Some(route) = &self.routes[key] else {
            return traffic;
        };
        let served = &self.served[key];
        let path = self.hierarchy.path(route.path);
        for (&level, served) in path.iter().zip(&served.levels) {
            traffic.levels[level] = *served;
        }
        traffic.levels[path[0]].accesses += self.spared[key];
        traffic.dram_read_bytes = served.memory.read_bytes;
        traffic.dram_write_bytes = served.memory.write_bytes;
        traffic
    }
}

/// The first path that leads through the same levels, so that accesses that take either need not be told apart.
fn first_alike(hierarchy: &Hierarchy, path: PathId, paths: KindPaths) -> PathId {
    let KindPaths { ssbo, texture, private, vertex } = paths;
    let alike = |other: &PathId| hierarchy.path(*other) == hierarchy.path(path);
    [ssbo, texture, private, vertex].into_iter().find(alike).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::gpu;
    use crate::warp::TileStream;
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
    fn cores_and_slots_take_turns_and_ticks_are_counted() {
        let mut interleaver = interleaver(2);
        let turns: &[(BufferKind, u32)] = &[(BufferKind::Node, 1), (BufferKind::Node, 2)];
        // Nine warps of two turns on four cores of two slots: eight are resident at once, the ninth follows the first.
        interleaver.push(&stream(&[turns; 9]));
        interleaver.drain(Pass::Primary);
        let schedule = interleaver.finish().schedule;
        assert_eq!(schedule.warps, 9);
        // Each core has 4 turns, the first one 6.
        assert_eq!(schedule.ticks, 6);
        assert_eq!(schedule.full_ticks, 4);
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
