//! The caches, and accesses gathered for them.

use super::KindPaths;
use crate::config::Gpu;
use crate::counters::{BufferTraffic, Pass, TrafficCounters, WaitCounters};
use crate::layout::{BufferKind, Places};
use crate::warp::Run;
use crate::windows::Seen;
use cachesim::{Access, Hierarchy, LevelServed, LineId, MAX_LEVELS, Missed, PathId, Policy, Served};

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
    /// Cycles from a request to its data in the first cache.
    latency: f64,
    /// Cycles that the first cache takes for a line, if it is that of buffers and cores share it; otherwise 0, as a core's port is no
    /// faster than its own cache.
    shared_cycles: f64,
}

/// A turn whose accesses have been gathered.
struct GatheredTurn {
    /// Where they end.
    end: u32,
    warp: Resident,
}

/// A warp on a core.
#[derive(Clone, Copy, Default)]
pub(super) struct Resident {
    /// Its slot, counted over all cores.
    pub(super) place: u32,
    /// Its number in the order of issue.
    pub(super) number: u32,
}

/// What a turn waits for if its data are in the first cache, in cycles.
#[derive(Default)]
pub(super) struct Waits {
    /// The cache, where cores share it.
    pub(super) queue: f64,
    /// From a line's request to its data.
    pub(super) latency: f64,
}

/// Data that a resident warp waits for were not in a cache.
pub(super) struct Delay {
    pub(super) place: u32,
    pub(super) cycles: f64,
    /// They come from memory.
    pub(super) memory: bool,
}

/// The caches, and accesses gathered for them.
pub(super) struct Caches {
    pub(super) hierarchy: Hierarchy,
    routes: [Option<Route>; Run::KEYS],
    /// By key and position on its path, cycles by which a miss there delays the data.
    beyond: [[f64; MAX_LEVELS]; Run::KEYS],
    /// The first `gathered` of [`PENDING`] take one path of one core.
    pending: Vec<Access>,
    /// Of each of these, the key.
    pending_keys: Vec<u8>,
    gathered: usize,
    pending_path: PathId,
    pending_core: u32,
    /// A key whose runs take this path.
    pending_key: usize,
    /// The turns of these; the latest may go on.
    pending_turns: Vec<GatheredTurn>,
    /// Lines that the latest turn has asked for.
    turn_lines: usize,
    /// Whose turn is the latest.
    issuing: Resident,
    /// Which of them missed where.
    missed: Missed,
    /// Lines that each warp read from memory, by its number; empty where no maps are kept.
    pub(super) lines_from_memory: Vec<u32>,
    /// What has become known since they were last taken.
    pub(super) delays: Vec<Delay>,
    /// By key, accesses that hit without being simulated.
    spared: Vec<u64>,
    /// By key.
    served: Vec<Served>,
    /// Of the turns that were looked at.
    waits: WaitCounters,
}

/// When so many accesses are gathered, the caches see them. So late does a warp learn that its data are far away.
const PENDING: usize = 1024;
/// No run has more lines.
const MOST_LINES: usize = 256;

impl Caches {
    pub(super) fn new(gpu: &Gpu, hierarchy: Hierarchy, paths: KindPaths, places: Places) -> Self {
        let stacks = (places.stack_base_line, places.stack_stride_lines);
        let route = |key: usize| {
            let (pass, kind, write) = Run::of_key(key)?;
            let path = first_alike(&hierarchy, paths.of(pass, kind, write), paths);
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
                latency: gpu.latency_cycles(levels, 0),
                shared_cycles: match &gpu.caches[levels[0]] {
                    cache if levels[0] == gpu.paths.ssbo[0] && cache.copies < gpu.cores.count => {
                        cache.line_bytes as f64 / cache.bytes_per_clock
                    }
                    _ => 0.0,
                },
            })
        };
        let routes: [Option<Route>; Run::KEYS] = std::array::from_fn(route);
        let beyond = routes
            .map(|route| route.map_or([0.0; MAX_LEVELS], |route| beyond(gpu, hierarchy.path(route.path))));
        Self {
            routes,
            beyond,
            hierarchy,
            pending: vec![Access::read(LineId::new(0)); PENDING + MOST_LINES],
            pending_keys: vec![0; PENDING + MOST_LINES],
            gathered: 0,
            pending_path: paths.ssbo,
            pending_core: 0,
            pending_key: 0,
            pending_turns: Vec::new(),
            turn_lines: 0,
            issuing: Resident::default(),
            missed: Missed::default(),
            lines_from_memory: Vec::new(),
            delays: Vec::new(),
            spared: vec![0; Run::KEYS],
            served: vec![Served::default(); Run::KEYS],
            waits: WaitCounters::default(),
        }
    }

    /// `lines` begins with those of the run.
    #[inline(always)]
    pub(super) fn access(&mut self, core: u32, warp: Resident, run: Run, lines: &[u32]) {
        let key = run.key();
        let Some(Route { path, write, by_core, repeatable_lines, private: (base, stride), .. }) =
            self.routes[key]
        else {
            return;
        };
        let core = if by_core { core } else { 0 };
        if path != self.pending_path || core != self.pending_core {
            self.flush_pending();
            (self.pending_path, self.pending_core, self.pending_key) = (path, core, key);
        }
        self.issuing = warp;
        let count = run.lines();
        self.turn_lines += run.repeats() as usize * count;
        let repeats = if count <= repeatable_lines { 1 } else { run.repeats() as usize };
        self.spared[key] += (run.repeats() as usize - repeats) as u64 * count as u64;
        let base = base + warp.place * stride;
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

    /// No warp waits for what has been accessed.
    pub(super) fn forget_warps(&mut self) {
        self.flush_pending();
        self.delays.clear();
        self.turn_lines = 0;
    }

    /// The turn whose accesses came last is over; `last` is its last run.
    pub(super) fn end_turn(&mut self, last: Run) -> Waits {
        self.pending_turns.push(GatheredTurn { end: self.gathered as u32, warp: self.issuing });
        let lines = std::mem::take(&mut self.turn_lines) as f64;
        self.routes[last.key()].as_ref().map_or(Waits::default(), |route| Waits {
            queue: lines * route.shared_cycles,
            latency: if route.write { 0.0 } else { route.latency },
        })
    }

    /// Lets the caches see what has been gathered.
    pub(super) fn flush_pending(&mut self) {
        let (accesses, keys) = (&self.pending[..self.gathered], &self.pending_keys[..self.gathered]);
        self.hierarchy.access_by_class(
            self.pending_path,
            self.pending_core,
            accesses,
            keys,
            &mut self.served,
            &mut self.missed,
        );
        let Self { missed, pending_turns, issuing, .. } = self;
        let levels = self.hierarchy.path(self.pending_path).len();
        let beyond = self.beyond[self.pending_key].iter().take(levels).enumerate();
        for (missed, (position, &cycles)) in missed.levels.iter_mut().zip(beyond) {
            let memory = position + 1 == levels;
            // The lines of a turn are on their way together: it waits once for all that missed at a level.
            let (mut turns, mut delayed) = (Turns::new(pending_turns, *issuing), None);
            for access in missed.drain(..).filter(|&access| !self.pending[access as usize].is_write()) {
                let (turn, warp) = turns.of(access);
                if delayed.replace(turn) != Some(turn) {
                    self.delays.push(Delay { place: warp.place, cycles, memory });
                }
            }
        }
        let mut turns = Turns::new(pending_turns, *issuing);
        for access in missed.memory.drain(..) {
            if let Some(lines) = self.lines_from_memory.get_mut(turns.of(access).1.number as usize) {
                *lines += 1;
            }
        }
        self.pending_turns.clear();
        self.gathered = 0;
    }

    /// All that the caches have seen.
    pub(super) fn seen(&mut self) -> Seen {
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
    pub(super) fn misses(&mut self) -> [u64; MAX_LEVELS + 1] {
        self.flush_pending();
        let mut misses = [0; MAX_LEVELS + 1];
        for (level, misses) in misses.iter_mut().take(self.hierarchy.levels().as_slice().len()).enumerate() {
            *misses = self.hierarchy.counts(level).misses;
        }
        misses[MAX_LEVELS] = self.hierarchy.memory().reads;
        misses
    }

    /// Notes from where the lines of a turn came, whose last run is `last`; `before` are the misses before it.
    pub(super) fn sample(&mut self, last: Run, lines: usize, before: [u64; MAX_LEVELS + 1]) {
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

    /// What all that the caches have seen caused.
    pub(super) fn traffic_by_pass(&self) -> [TrafficCounters; Pass::COUNT] {
        let mut passes = [TrafficCounters::default(); Pass::COUNT];
        for key in 0..Run::KEYS {
            if let Some((pass, kind, _)) = Run::of_key(key) {
                *passes[pass as usize].of_mut(kind) += self.traffic(key);
            }
        }
        passes
    }

    /// Lines that the caches have read from memory.
    pub(super) fn memory_reads(&self) -> u64 {
        self.hierarchy.memory().reads
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

/// Finds the turns of accesses, which are asked for in order.
struct Turns<'a> {
    turns: &'a [GatheredTurn],
    /// Accesses behind those of all turns are this warp's.
    latest: Resident,
    passed: usize,
}

impl<'a> Turns<'a> {
    fn new(turns: &'a [GatheredTurn], latest: Resident) -> Self {
        Self { turns, latest, passed: 0 }
    }

    /// The turn's place among those gathered, and its warp.
    fn of(&mut self, access: u32) -> (usize, Resident) {
        while self.turns.get(self.passed).is_some_and(|turn| turn.end <= access) {
            self.passed += 1;
        }
        (self.passed, self.turns.get(self.passed).map_or(self.latest, |turn| turn.warp))
    }
}

/// By position on a path, cycles by which a miss there delays the data.
fn beyond(gpu: &Gpu, path: &[usize]) -> [f64; MAX_LEVELS] {
    let mut beyond = [0.0; MAX_LEVELS];
    for (place, cycles) in beyond.iter_mut().take(path.len()).enumerate() {
        *cycles = (gpu.latency_cycles(path, place + 1) - gpu.latency_cycles(path, place)).max(0.0);
    }
    beyond
}

/// The first path that leads through the same levels, so that accesses that take either need not be told apart.
fn first_alike(hierarchy: &Hierarchy, path: PathId, paths: KindPaths) -> PathId {
    let KindPaths { ssbo, texture, private, vertex, traversal, atomic } = paths;
    let alike = |other: &PathId| hierarchy.path(*other) == hierarchy.path(path);
    [ssbo, texture, private, vertex, traversal, atomic].into_iter().find(alike).unwrap_or(path)
}
