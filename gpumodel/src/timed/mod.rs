//! The timed rung: warps, caches and memory, event by event.
//!
//! A warp's turn goes through these, in order: it waits until the core's scheduler lets it compute; computes, without
//! interruption, its instructions on the ALU; uses the elementary function unit; waits for the load/store unit, which sends its
//! lines out one after the other while fewer than `lines_in_flight` are on their way; and waits for the last of its lines if its
//! next turn needs them. As many warps compute at once as the ALU's lanes hold.
//!
//! What is not modelled: the pipeline within an instruction (instructions of a warp follow each other without a gap), the
//! instruction cache, and conflicts of registers. Cycles are those of the shader clock; events at the same time happen in the
//! order in which they were announced, so that the same input gives the same bytes.

mod core;
mod events;
mod memory;

pub(crate) use self::core::servers;
use self::core::{Core, Issue, Rates, Warp};
use self::events::{Event, Events};
pub use self::memory::MissRequest;
use self::memory::{Arrival, Memory, Reply};
use crate::config::Gpu;
use crate::counters::{BufferTraffic, Pass, ScheduleCounters, TrafficCounters};
use crate::engine::Finished;
use crate::error::Error;
use crate::interleave::KindPaths;
use crate::layout::Places;
use crate::replay::Maps;
use crate::warp::{Run, TileStream};
use cachesim::{Hierarchy, Served};
use std::collections::VecDeque;
use std::sync::Arc;

/// What happened between two times at which the GPU was empty, in cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimedPhase {
    /// From its first warp to its last byte.
    pub cycles: f64,
    /// Cycles that warps spent in each state, summed over warps.
    pub warps: WarpCycles,
    /// Cycles during which every core had a warp.
    pub all_cores_busy: f64,
    /// Cycles during which no warp computed and some read from memory was awaited.
    pub stalled_on_memory: f64,
    /// Warps, summed over cycles.
    pub resident_warps: f64,
}

/// Cycles of warps by what they did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WarpCycles {
    /// Could have computed, and another did.
    pub waiting_to_compute: f64,
    /// Computed on the ALU.
    pub computing: f64,
    /// Waited for or used the elementary function unit.
    pub functions: f64,
    /// Waited for the load/store unit.
    pub waiting_for_port: f64,
    /// Sent out loads and stores, lines in flight permitting.
    pub issuing: f64,
    /// Waited for data.
    pub waiting_for_data: f64,
}

/// The cores, their warps, the caches and memory.
pub(crate) struct Machine {
    rates: Rates,
    slots: u32,
    cores: Vec<Core>,
    /// By place: `core * slots + slot`.
    resident: Vec<Option<Warp>>,
    waiting: VecDeque<Warp>,
    memory: Memory,
    events: Events,
    now: f64,
    phase_began: f64,
    phase: TimedPhase,
    phases: Vec<(Pass, TimedPhase)>,
    computing: u32,
    occupied: u32,
    cores_occupied: u32,
    warps: u64,
    /// Where the next bytes of tile memory go.
    output_address: u64,
    /// Lines that each warp read from memory, by its number; empty where no maps are kept.
    misses: Vec<u32>,
    maps: Maps,
}

/// The time of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedFrame {
    /// By the first pass of each phase.
    pub phases: Vec<(Pass, TimedPhase)>,
    /// What the memory controller saw.
    pub dram: cachesim::DramStats,
    /// Every request, in order of time; empty unless [`ReplayConfig::keeps_misses`](crate::ReplayConfig::keeps_misses).
    pub misses: Vec<MissRequest>,
}

impl Machine {
    /// # Errors
    /// When the memory cannot be as described.
    pub(crate) fn new(
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        places: Places,
        resident_warps: u32,
        maps: Maps,
    ) -> Result<Self, Error> {
        let slots = gpu.cores.count * resident_warps;
        Ok(Self {
            rates: Rates::new(gpu),
            slots: resident_warps,
            cores: (0..gpu.cores.count).map(|_| Core::new(gpu.cores.scheduler)).collect(),
            resident: (0..slots).map(|_| None).collect(),
            waiting: VecDeque::new(),
            memory: Memory::new(gpu, hierarchy, paths, places)?,
            events: Events::default(),
            now: 0.0,
            phase_began: 0.0,
            phase: TimedPhase::default(),
            phases: Vec::new(),
            computing: 0,
            occupied: 0,
            cores_occupied: 0,
            warps: 0,
            output_address: places.end,
            misses: Vec::new(),
            maps,
        })
    }

    /// Keeps every request to memory.
    pub(crate) fn keep_misses(&mut self) {
        self.memory.log = Some(Vec::new());
    }

    /// Queues the warps of a tile.
    pub(crate) fn push(&mut self, stream: &Arc<TileStream>) {
        for index in 0..stream.turn_ends.len() {
            let (words, turns) = (stream.warp(index), stream.turns(index));
            if self.maps == Maps::Kept {
                self.misses.push(0);
            }
            let number = self.warps;
            self.warps += 1;
            if turns.is_empty() {
                continue;
            }
            self.waiting.push_back(Warp {
                stream: Arc::clone(stream),
                word: words.start,
                turn: turns.start,
                turn_end: turns.end,
                number,
                pending: 0,
                data_at: 0.0,
                issued: false,
                since: 0.0,
            });
        }
        // The first slots of all cores, then the second ones, and so on.
        for slot in 0..self.slots {
            for core in 0..self.cores.len() as u32 {
                let place = core * self.slots + slot;
                if self.resident[place as usize].is_none() {
                    self.settle(place);
                }
            }
        }
    }

    /// Lines that each warp read from memory, by its number.
    pub(crate) fn misses_by_warp(&self) -> &[u32] {
        &self.misses
    }

    /// Goes on as long as no slot can lack a warp that a later tile would bring.
    pub(crate) fn run_ahead(&mut self) {
        while !self.waiting.is_empty() && self.step() {}
    }

    /// Goes on until all is done; the time since the last call is that of a phase which begins with `pass`.
    pub(crate) fn drain(&mut self, pass: Pass) {
        while self.step() {}
        if self.now > self.phase_began {
            self.phase.cycles = self.now - self.phase_began;
            self.phases.push((pass, std::mem::take(&mut self.phase)));
            self.phase_began = self.now;
        }
    }

    /// Writes dirty lines back; everything has been drained.
    pub(crate) fn finish(mut self) -> Finished {
        let mut traffic = [TrafficCounters::default(); Pass::COUNT];
        for (key, &of_key) in self.memory.traffic.iter().enumerate() {
            if let Some((pass, kind, _)) = Run::of_key(key) {
                *traffic[pass as usize].of_mut(kind) += of_key;
            }
        }
        let Served { levels, memory } = self.memory.flush();
        let flush = BufferTraffic {
            levels,
            dram_read_bytes: memory.read_bytes,
            dram_write_bytes: memory.write_bytes,
        };
        let sum =
            |value: fn(&TimedPhase) -> f64| self.phases.iter().map(|(_, phase)| value(phase)).sum::<f64>();
        let schedule = ScheduleCounters {
            ticks: sum(|phase| phase.cycles).round() as u64,
            full_ticks: sum(|phase| phase.all_cores_busy).round() as u64,
            warp_ticks: sum(|phase| phase.resident_warps).round() as u64,
            warps: self.warps,
        };
        let dram = self.memory.dram().stats();
        let misses = self.memory.log.take().unwrap_or_default();
        Finished {
            traffic,
            flush,
            schedule,
            phases: Vec::new(),
            timed: Some(TimedFrame { phases: self.phases, dram, misses }),
        }
    }

    /// One event; false if there is none.
    fn step(&mut self) -> bool {
        let (event_at, memory_at) = (self.events.next_at(), self.memory.next_at());
        let memory_first = match (event_at, memory_at) {
            (None, None) => return false,
            (Some(event), Some(memory)) => memory <= event,
            (None, Some(_)) => true,
            (Some(_), None) => false,
        };
        if memory_first {
            self.pass_time(memory_at.unwrap_or(self.now));
            self.memory.advance(&mut self.events);
        } else if let Some((at, event)) = self.events.pop() {
            self.pass_time(at);
            match event {
                Event::Ready(place) => self.ready(place),
                Event::Computed(place) => self.computed(place),
                Event::Issued(core) => self.issued(core),
                Event::Functions(place) => self.functions(place),
                Event::LoadStore(core) => self.load_store(core),
                Event::Unblock(level, copy) => self.memory.unblock(self.now, level, copy, &mut self.events),
                Event::Memory(request) => self.memory.submit(self.now, request),
            }
        }
        self.take_arrivals();
        true
    }

    fn pass_time(&mut self, at: f64) {
        let passed = (at - self.now).max(0.0);
        if passed == 0.0 {
            return;
        }
        self.phase.resident_warps += passed * f64::from(self.occupied);
        if self.cores_occupied as usize == self.cores.len() {
            self.phase.all_cores_busy += passed;
        }
        if self.computing == 0 && self.memory.reads_outstanding > 0 {
            self.phase.stalled_on_memory += passed;
        }
        self.now = at;
    }

    /// Gives a free place to the next warp.
    fn settle(&mut self, place: u32) {
        let Some(mut warp) = self.waiting.pop_front() else { return };
        warp.since = self.now;
        self.resident[place as usize] = Some(warp);
        self.occupied += 1;
        let core = &mut self.cores[(place / self.slots) as usize];
        core.occupied += 1;
        self.cores_occupied += u32::from(core.occupied == 1);
        self.events.push(self.now, Event::Ready(place));
    }

    /// The time since the warp's state changed, which it does now.
    fn since(warp: &mut Warp, now: f64) -> f64 {
        now - std::mem::replace(&mut warp.since, now)
    }

    fn ready(&mut self, place: u32) {
        let Some(warp) = &mut self.resident[place as usize] else { return };
        self.phase.warps.waiting_for_data += Self::since(warp, self.now);
        if warp.turn == warp.turn_end {
            self.resident[place as usize] = None;
            self.occupied -= 1;
            let core = &mut self.cores[(place / self.slots) as usize];
            core.occupied -= 1;
            self.cores_occupied -= u32::from(core.occupied == 0);
            self.settle(place);
            return;
        }
        let number = warp.number;
        let core = place / self.slots;
        self.cores[core as usize].make_ready(place, number);
        self.dispatch(core);
    }

    /// Lets warps compute while there is room.
    fn dispatch(&mut self, core: u32) {
        let state = &mut self.cores[core as usize];
        while state.computing < self.rates.servers {
            let Some(place) = state.take_ready() else { return };
            let Some(warp) = &mut self.resident[place as usize] else { continue };
            self.phase.warps.waiting_to_compute += Self::since(warp, self.now);
            let instructions = f64::from(warp.stream.turns[warp.turn].alu);
            state.computing += 1;
            self.computing += 1;
            if self.rates.alu_is_free_early() {
                self.events.push(self.now + instructions * self.rates.alu_cycles, Event::Issued(core));
            }
            self.events.push(self.now + instructions * self.rates.alu_latency, Event::Computed(place));
        }
    }

    fn computed(&mut self, place: u32) {
        let core = place / self.slots;
        let state = &mut self.cores[core as usize];
        if !self.rates.alu_is_free_early() {
            state.computing -= 1;
        }
        self.computing -= 1;
        let Some(warp) = &mut self.resident[place as usize] else { return };
        self.phase.warps.computing += Self::since(warp, self.now);
        let efu = warp.stream.turns[warp.turn].efu;
        if efu > 0 {
            let ends = state.efu_free.max(self.now) + f64::from(efu) * self.rates.efu_cycles;
            state.efu_free = ends;
            self.events.push(ends, Event::Functions(place));
        } else {
            self.ask_port(place);
        }
        self.dispatch(core);
    }

    fn issued(&mut self, core: u32) {
        self.cores[core as usize].computing -= 1;
        self.dispatch(core);
    }

    fn functions(&mut self, place: u32) {
        if let Some(warp) = &mut self.resident[place as usize] {
            self.phase.warps.functions += Self::since(warp, self.now);
        }
        self.ask_port(place);
    }

    fn ask_port(&mut self, place: u32) {
        let Some(warp) = &mut self.resident[place as usize] else { return };
        let turn = warp.stream.turns[warp.turn];
        if turn.output_bytes > 0 {
            let address = self.output_address;
            self.output_address += u64::from(turn.output_bytes);
            self.memory.write_past_caches(self.now, address, turn.output_bytes, &mut self.events);
        }
        if turn.runs == 0 {
            warp.turn += 1;
            self.ready(place);
            return;
        }
        let core = place / self.slots;
        let state = &mut self.cores[core as usize];
        state.queue.push_back(place);
        if state.issue.is_none() {
            self.next_issue(core);
        }
    }

    /// Takes the next turn into the load/store unit, which is free.
    fn next_issue(&mut self, core: u32) {
        let state = &mut self.cores[core as usize];
        let Some(place) = state.queue.pop_front() else { return };
        let Some(warp) = &mut self.resident[place as usize] else { return };
        self.phase.warps.waiting_for_port += Self::since(warp, self.now);
        let turn = warp.stream.turns[warp.turn];
        let (mut word, mut lines) = (warp.word, 0);
        for _ in 0..turn.runs {
            let run = Run::from_word(warp.stream.words[word]);
            word += 1 + run.lines();
            lines += run.lines();
        }
        let port_cycles = f64::from(turn.port_cycles);
        warp.pending = 0;
        warp.data_at = self.now;
        warp.issued = false;
        state.issue = Some(Issue {
            place,
            at: self.now,
            cycles_per_line: port_cycles / lines.max(1) as f64,
            ends: self.now + port_cycles,
            runs_left: turn.runs,
            line_in_run: 0,
        });
        self.load_store(core);
    }

    /// Sends lines out until the turn is done or the unit has to wait.
    fn load_store(&mut self, core: u32) {
        let state = &mut self.cores[core as usize];
        let Some(mut issue) = state.issue else { return };
        let place = issue.place;
        let Some(warp) = &mut self.resident[place as usize] else { return };
        if std::mem::take(&mut state.stalled) {
            let late = (self.now - issue.at).max(0.0);
            issue.at += late;
            issue.ends += late;
        }
        if warp.issued {
            if self.now < issue.ends {
                return;
            }
            state.issue = None;
            self.phase.warps.issuing += Self::since(warp, self.now);
            let turn = warp.stream.turns[warp.turn];
            warp.turn += 1;
            if !turn.waits {
                self.events.push(self.now, Event::Ready(place));
            } else if warp.pending == 0 {
                self.events.push(warp.data_at.max(self.now), Event::Ready(place));
            }
            self.next_issue(core);
            return;
        }
        while issue.runs_left > 0 {
            let run = Run::from_word(warp.stream.words[warp.word]);
            if issue.line_in_run == run.lines() {
                warp.word += 1 + run.lines();
                issue.runs_left -= 1;
                issue.line_in_run = 0;
                continue;
            }
            if state.lines_in_flight(issue.at) >= self.memory.lines_in_flight(run) {
                state.stalled = true;
                if let Some(at) = state.arriving.next_at() {
                    self.events.push(at.max(issue.at), Event::LoadStore(core));
                }
                state.issue = Some(issue);
                return;
            }
            let line = warp.stream.words[warp.word + 1 + issue.line_in_run];
            let at = issue.at;
            issue.line_in_run += 1;
            issue.at += issue.cycles_per_line;
            let reply = self.memory.access((self.now, at), (place, core), run, line, &mut self.events);
            if self.maps == Maps::Kept {
                self.misses[warp.number as usize] += std::mem::take(&mut self.memory.missed);
            }
            match reply {
                Reply::Near(arrival) => warp.data_at = warp.data_at.max(arrival),
                Reply::At(arrival) => {
                    if arrival > at {
                        state.arriving.push(arrival, ());
                    }
                    warp.data_at = warp.data_at.max(arrival);
                }
                Reply::Later { near } => {
                    state.lines_pending += usize::from(!near);
                    warp.pending += 1;
                }
            }
        }
        warp.issued = true;
        state.issue = Some(issue);
        self.events.push(issue.ends, Event::LoadStore(core));
    }

    /// Data whose arrival has become known.
    fn take_arrivals(&mut self) {
        let mut arrivals = std::mem::take(&mut self.memory.arrivals);
        for Arrival { place, at, near } in arrivals.drain(..) {
            let core = place / self.slots;
            let state = &mut self.cores[core as usize];
            if !near {
                state.lines_pending -= 1;
                state.arriving.push(at, ());
                if state.stalled {
                    // It may be waiting for this line and none before it.
                    self.events.push(at.max(self.now), Event::LoadStore(core));
                }
            }
            if let Some(warp) = &mut self.resident[place as usize] {
                warp.data_at = warp.data_at.max(at);
                warp.pending -= 1;
                let in_unit = state.issue.is_some_and(|issue| issue.place == place);
                if warp.pending == 0 && warp.issued && !in_unit {
                    self.events.push(warp.data_at.max(self.now), Event::Ready(place));
                }
            }
        }
        self.memory.arrivals = arrivals;
    }
}
