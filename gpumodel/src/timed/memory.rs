//! Caches, the way to memory, and memory, with time.
//!
//! What a cache holds is decided when a request is issued, by the exact simulation of [`cachesim`]. When its data arrive
//! depends on the banks it passes, on lines that are already on their way, which it joins, on free MSHRs, on the bandwidth
//! of the way to memory, and on the memory controller.

use super::events::{Event, Events, Promises};
use crate::config::Gpu;
use crate::error::Error;
use crate::interleave::KindPaths;
use crate::layout::{BufferKind, Places};
use crate::warp::Run;
use cachesim::{Access, Done, Dram, Hierarchy, LineId, MemoryRequest};
use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasherDefault, Hasher};

/// No warp waits for it.
const NOBODY: u32 = u32::MAX;
/// The tag of a request whose end nobody awaits.
const POSTED: u32 = u32::MAX;

/// What a load of a warp hears of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reply {
    /// The core's own cache has the data, which arrive then.
    Near(f64),
    /// The data arrive then.
    At(f64),
    /// That is not known yet; [`Memory::arrivals`] will tell. `near` where the core's own cache has the line or waits for it.
    Later { near: bool },
}

/// Data of a load whose arrival has become known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// The warp that waits for them.
    pub(super) place: u32,
    /// When they arrive.
    pub(super) at: f64,
    /// The core's own cache had the line, or waited for it already.
    pub(super) near: bool,
}

/// Requests to the caches and to memory.
pub(super) struct Memory {
    hierarchy: Hierarchy,
    routes: Vec<Option<Route>>,
    levels: Vec<Level>,
    requests: Vec<Request>,
    free_requests: Vec<u32>,
    /// The way between the last cache and memory. Addresses are translated on it, in order: a page walk holds up what comes behind it.
    fabric_free: f64,
    walk_cycles: f64,
    fabric_cycles_per_byte: f64,
    /// Cycles of the way there and back, without what the memory itself takes for a line of a shut row.
    fabric_latency: f64,
    dram: Dram,
    cycles_per_ps: f64,
    done: Vec<Done>,
    /// All requests, where they are kept.
    pub(super) log: Option<Vec<MissRequest>>,
    /// What the latest access asks of memory.
    in_memory: Vec<MemoryRequest>,
    /// Loads whose end has become known; to be emptied after every call.
    pub(super) arrivals: Vec<Arrival>,
    /// Reads on their way to or from memory.
    pub(super) reads_outstanding: u32,
    /// Lines read from memory since this was last taken.
    pub(super) missed: u32,
    /// By run key, as the interleaver counts them.
    pub(super) traffic: Vec<crate::counters::BufferTraffic>,
}

/// A request as it arrives at the memory controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissRequest {
    /// When, in picoseconds since the start of the frame.
    pub at_ps: u64,
    /// Of its first byte.
    pub address: u64,
    /// It writes.
    pub write: bool,
}

/// How the lines of a run reach the caches.
struct Route {
    path: cachesim::PathId,
    /// Indices of levels.
    levels: Vec<usize>,
    /// Lines of a core on their way, at most.
    lines_in_flight: usize,
    /// Cycles that each level of the path adds to the way through the nearer ones.
    latencies: Vec<f64>,
    line_shift: u32,
    write: bool,
    /// First line, and lines per place, of a private buffer; 0 for others.
    private: (u64, u64),
}

struct Level {
    line_shift: u32,
    /// Cycles that a bank is busy with a line.
    line_cycles: f64,
    mshrs: usize,
    cores_per_copy: u32,
    copies: Vec<CacheCopy>,
}

#[derive(Default)]
struct CacheCopy {
    /// When each bank is free.
    banks: Vec<f64>,
    /// Lines on their way here.
    fills: HashMap<u64, Fill, BuildHasherDefault<LineHasher>>,
    /// When those of them arrive that are known.
    known: Promises<u64>,
    /// Requests that wait for an MSHR, and how far along their path they are.
    blocked: VecDeque<(u32, usize)>,
}

enum Fill {
    At(f64),
    /// These requests wait for it too.
    Pending(Vec<u32>),
}

/// A line of a run on its way.
#[derive(Clone, Copy)]
struct Request {
    place: u32,
    core: u32,
    key: u32,
    address: u64,
    /// Levels of its path that do not hold it.
    missed: usize,
    /// Levels of its path whose MSHR it has.
    held: usize,
    /// The core's own cache has the line, or waits for it already.
    near: bool,
    /// Bytes that it reads from memory.
    bytes: u32,
    write: bool,
    /// It has to walk for the address of its page.
    walks: bool,
    /// When it would be through the levels that it has passed.
    at: f64,
}

impl Memory {
    pub(super) fn new(
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        places: Places,
    ) -> Result<Self, Error> {
        let config = gpu.dram.simulated();
        let dram = Dram::new(&config).map_err(|error| Error::dram(gpu, &error))?;
        let cycles_per_ps = gpu.clock.hz * 1e-12;
        let line_bytes = gpu.caches.iter().map(|cache| cache.line_bytes).max().unwrap_or(0);
        let bursts = line_bytes.div_ceil(config.standard.burst_bytes());
        let idle = dram.timings().row_miss_of(bursts) as f64 * cycles_per_ps;
        let route = |key: usize| {
            let (pass, kind, write) = Run::of_key(key)?;
            let path = paths.of(pass, kind, write);
            let levels = hierarchy.path(path).to_vec();
            let of = |position: usize| gpu.latency_cycles(&levels, position);
            let latencies = (0..levels.len())
                .map(|position| of(position) - if position == 0 { 0.0 } else { of(position - 1) })
                .map(|latency| latency.max(0.0))
                .collect();
            let private = match kind {
                BufferKind::Stack => {
                    (u64::from(places.stack_base_line), u64::from(places.stack_stride_lines))
                }
                _ => (0, 0),
            };
            Some(Route {
                path,
                lines_in_flight: gpu.lines_in_flight(&levels) as usize,
                latencies,
                line_shift: hierarchy.granule(path).log2(),
                levels,
                write,
                private,
            })
        };
        let levels = gpu.caches.iter().map(|cache| Level {
            line_shift: cache.line_bytes.ilog2(),
            line_cycles: cache.line_bytes as f64 * f64::from(cache.banks) / cache.bytes_per_clock,
            mshrs: cache.mshrs as usize,
            cores_per_copy: gpu.cores.count / cache.copies,
            copies: (0..cache.copies)
                .map(|_| CacheCopy { banks: vec![0.0; cache.banks as usize], ..CacheCopy::default() })
                .collect(),
        });
        let bandwidth = gpu.dram.peak_bytes_per_second * gpu.dram.efficiency;
        Ok(Self {
            routes: (0..Run::KEYS).map(route).collect(),
            levels: levels.collect(),
            hierarchy,
            requests: Vec::new(),
            free_requests: Vec::new(),
            fabric_free: 0.0,
            walk_cycles: gpu.translation.map_or(0.0, |translation| translation.walk_seconds * gpu.clock.hz),
            fabric_cycles_per_byte: gpu.clock.hz / bandwidth,
            fabric_latency: (gpu.dram.latency_seconds * gpu.clock.hz - idle).max(0.0),
            dram,
            cycles_per_ps,
            done: Vec::new(),
            log: None,
            in_memory: Vec::new(),
            arrivals: Vec::new(),
            reads_outstanding: 0,
            missed: 0,
            traffic: vec![Default::default(); Run::KEYS],
        })
    }

    /// How many lines of a core may be on their way when a line of `run` goes out.
    pub(super) fn lines_in_flight(&self, run: Run) -> usize {
        self.routes[run.key()].as_ref().map_or(usize::MAX, |route| route.lines_in_flight)
    }

    /// A line of a load or store that is issued `repeats` times at `at`, on behalf of the warp at `place`. `now` is the start
    /// of the warp's turn at the port.
    pub(super) fn access(
        &mut self,
        (now, at): (f64, f64),
        (place, core): (u32, u32),
        run: Run,
        line: u32,
        events: &mut Events,
    ) -> Reply {
        let key = run.key();
        let Some(route) = &self.routes[key] else { return Reply::At(at) };
        let (base, stride) = route.private;
        let line = base + u64::from(place) * stride + u64::from(line);
        let unit = core.min(self.hierarchy.units() - 1);
        let access = Access::new(LineId::new(line), route.write);
        self.in_memory.clear();
        let (served, missed) = self.hierarchy.follow(route.path, unit, access, &mut self.in_memory);
        let again = u64::from(run.repeats()) - 1;
        let traffic = &mut self.traffic[key];
        traffic.levels[route.levels[0]].accesses += again;
        for (&level, served) in route.levels.iter().zip(&served.levels) {
            traffic.levels[level].accesses += served.accesses;
            traffic.levels[level].misses += served.misses;
        }
        self.missed += served.memory.reads as u32;
        traffic.dram_read_bytes += served.memory.read_bytes;
        traffic.dram_write_bytes += served.memory.write_bytes;

        let address = line << route.line_shift;
        let read = self.in_memory.first().filter(|request| !request.write);
        let near = missed == 0 && self.levels[route.levels[0]].cores_per_copy == 1;
        let request = Request {
            place: if route.write { NOBODY } else { place },
            core,
            key: key as u32,
            address,
            missed,
            held: 0,
            near,
            bytes: read.map_or(0, |request| request.bytes),
            write: false,
            walks: read.is_some_and(|request| request.walks),
            at,
        };
        let reply = if route.write {
            for (&level, served) in route.levels.iter().zip(&served.levels) {
                if served.accesses > 0 {
                    let level = &mut self.levels[level];
                    level.reserve(core, address, now, level.line_cycles);
                }
            }
            Reply::At(at)
        } else {
            self.descend(request, None, 0, (now, at), run.repeats(), events)
        };
        let reply = match reply {
            Reply::At(arrival) if near => Reply::Near(arrival),
            reply => reply,
        };
        // A store waits for nothing, and neither does a line on its way out.
        for index in 0..self.in_memory.len() {
            let MemoryRequest { address, bytes, write, walks } = self.in_memory[index];
            if write || request.place == NOBODY {
                self.ask_memory(Request { place: NOBODY, address, bytes, write, walks, ..request }, events);
            }
        }
        reply
    }

    /// Takes a request down its path from `position` on. It is kept, under `number` if it has one, where its end is not known.
    fn descend(
        &mut self,
        mut request: Request,
        number: Option<u32>,
        position: usize,
        (now, mut at): (f64, f64),
        repeats: u32,
        events: &mut Events,
    ) -> Reply {
        let Some(route) = &self.routes[request.key as usize] else { return Reply::At(at) };
        // A request that waited for an MSHR has been through the bank.
        let mut through = number.is_some();
        for position in position..route.levels.len() {
            let index = route.levels[position];
            let level = &mut self.levels[index];
            let first = position == 0;
            if !std::mem::take(&mut through) {
                let arrives = if first { now } else { at };
                let cycles = level.line_cycles * if first { f64::from(repeats) } else { 1.0 };
                let begins = level.reserve(request.core, request.address, arrives, cycles);
                at = at.max(begins) + route.latencies[position];
            }
            request.at = at;
            let line = request.address >> level.line_shift;
            let copy_index = request.core / level.cores_per_copy;
            let copy = &mut level.copies[copy_index as usize];
            copy.forget(now);
            match copy.fills.get_mut(&line) {
                Some(Fill::At(arrival)) => {
                    let arrival = arrival.max(at);
                    return self.end(request, number, arrival, events);
                }
                Some(Fill::Pending(waiters)) => {
                    let slot = keep(&mut self.requests, &mut self.free_requests, request, number);
                    waiters.push(slot);
                    return Reply::Later { near: request.near };
                }
                None => {}
            }
            if position >= request.missed {
                return self.end(request, number, at, events);
            }
            if copy.fills.len() >= level.mshrs {
                let slot = keep(&mut self.requests, &mut self.free_requests, request, number);
                copy.blocked.push_back((slot, position));
                if let Some(at) = copy.known.next_at() {
                    events.push(at.max(now), Event::Unblock(index as u32, copy_index));
                }
                return Reply::Later { near: request.near };
            }
            copy.fills.insert(line, Fill::Pending(Vec::new()));
            request.held = position + 1;
        }
        self.reads_outstanding += 1;
        let slot = keep(&mut self.requests, &mut self.free_requests, request, number);
        self.send(slot, events);
        Reply::Later { near: false }
    }

    /// The end of a request is known: so is that of all that wait for the same lines.
    fn end(&mut self, request: Request, number: Option<u32>, arrival: f64, events: &mut Events) -> Reply {
        if let Some(number) = number {
            self.free_requests.push(number);
        }
        let mut waiting = Vec::new();
        self.release(&request, arrival, &mut waiting, events);
        while let Some(number) = waiting.pop() {
            let request = self.requests[number as usize];
            self.free_requests.push(number);
            let arrival = arrival.max(request.at);
            self.release(&request, arrival, &mut waiting, events);
            self.arrivals.push(Arrival { place: request.place, at: arrival, near: request.near });
        }
        if number.is_some() && request.place != NOBODY {
            self.arrivals.push(Arrival { place: request.place, at: arrival, near: request.near });
        }
        Reply::At(arrival)
    }

    /// Promises the MSHRs of a request for `arrival`, and collects those who wait for its lines.
    fn release(&mut self, request: &Request, arrival: f64, waiting: &mut Vec<u32>, events: &mut Events) {
        let Some(route) = &self.routes[request.key as usize] else { return };
        for &index in &route.levels[..request.held] {
            let level = &mut self.levels[index];
            let line = request.address >> level.line_shift;
            let copy_index = request.core / level.cores_per_copy;
            let copy = &mut level.copies[copy_index as usize];
            if let Some(Fill::Pending(waiters)) = copy.fills.insert(line, Fill::At(arrival)) {
                waiting.extend(waiters);
            }
            copy.known.push(arrival, line);
            if !copy.blocked.is_empty() {
                events.push(arrival, Event::Unblock(index as u32, copy_index));
            }
        }
    }

    /// An MSHR of a cache may be free again.
    pub(super) fn unblock(&mut self, now: f64, index: u32, copy_index: u32, events: &mut Events) {
        loop {
            let level = &mut self.levels[index as usize];
            let copy = &mut level.copies[copy_index as usize];
            copy.forget(now);
            if copy.fills.len() >= level.mshrs {
                if let (false, Some(at)) = (copy.blocked.is_empty(), copy.known.next_at()) {
                    events.push(at, Event::Unblock(index, copy_index));
                }
                return;
            }
            let Some((number, position)) = copy.blocked.pop_front() else { return };
            let mut request = self.requests[number as usize];
            request.held = position;
            let at = request.at.max(now);
            self.descend(request, Some(number), position, (now, at), 1, events);
        }
    }

    fn ask_memory(&mut self, request: Request, events: &mut Events) {
        let slot = keep(&mut self.requests, &mut self.free_requests, request, None);
        self.send(slot, events);
    }

    /// Bytes that go to memory past the caches.
    pub(super) fn write_past_caches(&mut self, at: f64, address: u64, bytes: u32, events: &mut Events) {
        let request = Request {
            place: NOBODY,
            core: 0,
            key: 0,
            address,
            missed: 0,
            held: 0,
            near: false,
            bytes,
            write: true,
            walks: false,
            at,
        };
        self.ask_memory(request, events);
    }

    fn send(&mut self, number: u32, events: &mut Events) {
        let request = &self.requests[number as usize];
        let walk = if request.walks { self.walk_cycles } else { 0.0 };
        let begins = request.at.max(self.fabric_free) + walk;
        self.fabric_free = begins + f64::from(request.bytes) * self.fabric_cycles_per_byte;
        events.push(begins + self.fabric_latency, Event::Memory(number));
    }

    /// A request arrives at the controller.
    pub(super) fn submit(&mut self, now: f64, number: u32) {
        let Request { place, address, bytes, write, .. } = self.requests[number as usize];
        let awaited = place != NOBODY;
        if !awaited {
            self.free_requests.push(number);
        }
        let now = self.to_ps(now);
        // A line of the last cache may be longer than the first one's.
        let address = if write { address } else { address - address % u64::from(bytes.max(1)) };
        if let Some(log) = &mut self.log {
            log.push(MissRequest { at_ps: now, address, write });
        }
        self.dram.submit(now, address, bytes, write, if awaited { number } else { POSTED });
    }

    /// When the memory has something to do or to tell.
    pub(super) fn next_at(&mut self) -> Option<f64> {
        self.dram.next_event().map(|ps| ps as f64 * self.cycles_per_ps)
    }

    /// Lets the memory go on up to its next event.
    pub(super) fn advance(&mut self, events: &mut Events) {
        let Some(until) = self.dram.next_event() else { return };
        let mut done = std::mem::take(&mut self.done);
        self.dram.advance(until, &mut done);
        for Done { at_ps, tag } in done.drain(..) {
            if tag == POSTED {
                continue;
            }
            self.reads_outstanding -= 1;
            let request = self.requests[tag as usize];
            self.end(request, Some(tag), at_ps as f64 * self.cycles_per_ps, events);
        }
        self.done = done;
    }

    pub(super) fn dram(&self) -> &Dram {
        &self.dram
    }

    pub(super) fn flush(&mut self) -> cachesim::Served {
        self.hierarchy.flush()
    }

    fn to_ps(&self, cycles: f64) -> u64 {
        (cycles / self.cycles_per_ps) as u64
    }
}

impl Level {
    /// When a line begins to be served that arrives at `at`.
    fn reserve(&mut self, core: u32, address: u64, at: f64, cycles: f64) -> f64 {
        let copy = &mut self.copies[(core / self.cores_per_copy) as usize];
        let bank = (address >> self.line_shift) as usize % copy.banks.len();
        let free = &mut copy.banks[bank];
        let begins = free.max(at);
        *free = begins + cycles;
        begins
    }
}

impl CacheCopy {
    /// Lines that have arrived are on their way no more.
    fn forget(&mut self, now: f64) {
        while let Some(line) = self.known.pop_due(now) {
            if matches!(self.fills.get(&line), Some(&Fill::At(at)) if at <= now) {
                self.fills.remove(&line);
            }
        }
    }
}

fn keep(requests: &mut Vec<Request>, free: &mut Vec<u32>, request: Request, number: Option<u32>) -> u32 {
    let number = number.or_else(|| free.pop()).unwrap_or(requests.len() as u32);
    match requests.get_mut(number as usize) {
        Some(place) => *place = request,
        None => requests.push(request),
    }
    number
}

/// Line numbers are spread by one multiplication (Fibonacci hashing).
#[derive(Default)]
struct LineHasher(u64);

impl Hasher for LineHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, value: u64) {
        self.0 = (self.0 ^ value).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 ^= self.0 >> 32;
    }
}
