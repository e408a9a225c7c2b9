//! A shader core: who computes, and who uses the load/store unit.

use super::events::Promises;
use crate::config::{Gpu, Scheduler};
use crate::warp::TileStream;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::sync::Arc;

/// Rates of all cores.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    /// Warps that compute at once.
    pub(super) servers: u32,
    /// Cycles for which one instruction of a warp keeps others from a place on the ALU.
    pub(super) alu_cycles: f64,
    /// Cycles after which it has its result: as many, but at least one.
    pub(super) alu_latency: f64,
    /// Cycles of one instruction of a warp on the elementary function unit.
    pub(super) efu_cycles: f64,
}

impl Rates {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let cores = &gpu.cores;
        let width = f64::from(cores.warp_width);
        let servers = servers(gpu);
        let alu_cycles = f64::from(servers) * width / cores.alu_lanes;
        Self { servers, alu_cycles, alu_latency: alu_cycles.max(1.0), efu_cycles: width / cores.efu_lanes }
    }

    /// Whether a warp's place on the ALU is free again before the warp has its results: where the lanes hold a part of a warp more than
    /// whole ones.
    pub(super) fn alu_is_free_early(&self) -> bool {
        self.alu_cycles < self.alu_latency
    }
}

/// Warps that compute at once on a core: as many as its lanes hold, at least one.
pub(crate) fn servers(gpu: &Gpu) -> u32 {
    (gpu.cores.alu_lanes / f64::from(gpu.cores.warp_width)).clamp(1.0, 1024.0) as u32
}

/// A resident warp.
pub(super) struct Warp {
    pub(super) stream: Arc<TileStream>,
    /// The next run, and where the runs end.
    pub(super) word: usize,
    /// The turn at work, and where the turns end.
    pub(super) turn: usize,
    pub(super) turn_end: usize,
    /// The order in which warps came.
    pub(super) number: u64,
    /// Loads of this turn whose end is not known.
    pub(super) pending: u32,
    /// When the data arrive that are known to.
    pub(super) data_at: f64,
    /// The loads and stores of the turn have been issued.
    pub(super) issued: bool,
    /// Since when it is in the state that it is in.
    pub(super) since: f64,
}

/// A turn in the load/store unit.
#[derive(Clone, Copy)]
pub(super) struct Issue {
    pub(super) place: u32,
    /// When its next line goes out.
    pub(super) at: f64,
    pub(super) cycles_per_line: f64,
    /// When the port is done with it, unless it has to wait.
    pub(super) ends: f64,
    pub(super) runs_left: u16,
    pub(super) line_in_run: usize,
}

pub(super) struct Core {
    ready: Ready,
    /// Resident warps.
    pub(super) occupied: u32,
    /// Warps computing.
    pub(super) computing: u32,
    /// When the elementary function unit is free.
    pub(super) efu_free: f64,
    /// Warps that wait for the load/store unit.
    pub(super) queue: VecDeque<u32>,
    pub(super) issue: Option<Issue>,
    /// Lines on their way: those whose arrival is known, and the number of others.
    pub(super) arriving: Promises<()>,
    pub(super) lines_pending: usize,
    /// The load/store unit waits for a line to arrive.
    pub(super) stalled: bool,
}

/// Warps that could compute.
enum Ready {
    RoundRobin(VecDeque<u32>),
    /// By the order in which they came, and the place.
    OldestFirst(BinaryHeap<Reverse<(u64, u32)>>),
}

impl Core {
    pub(super) fn new(scheduler: Scheduler) -> Self {
        Self {
            ready: match scheduler {
                Scheduler::RoundRobin => Ready::RoundRobin(VecDeque::new()),
                Scheduler::GreedyThenOldest => Ready::OldestFirst(BinaryHeap::new()),
            },
            occupied: 0,
            computing: 0,
            efu_free: 0.0,
            queue: VecDeque::new(),
            issue: None,
            arriving: Promises::default(),
            lines_pending: 0,
            stalled: false,
        }
    }

    pub(super) fn make_ready(&mut self, place: u32, number: u64) {
        match &mut self.ready {
            Ready::RoundRobin(queue) => queue.push_back(place),
            Ready::OldestFirst(heap) => heap.push(Reverse((number, place))),
        }
    }

    pub(super) fn take_ready(&mut self) -> Option<u32> {
        match &mut self.ready {
            Ready::RoundRobin(queue) => queue.pop_front(),
            Ready::OldestFirst(heap) => heap.pop().map(|Reverse((_, place))| place),
        }
    }

    /// Lines on their way at `now`.
    pub(super) fn lines_in_flight(&mut self, now: f64) -> usize {
        while self.arriving.pop_due(now).is_some() {}
        self.arriving.len() + self.lines_pending
    }
}
