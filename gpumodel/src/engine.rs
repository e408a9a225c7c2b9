//! What runs the warps of a frame: in turns, or event by event.

use crate::config::Gpu;
use crate::counters::{BufferTraffic, Pass, ScheduleCounters, TrafficCounters};
use crate::error::Error;
use crate::interleave::{Interleaver, KindPaths};
use crate::layout::Places;
use crate::replay::{Fidelity, Maps};
use crate::timed::{Machine, TimedFrame};
use crate::warp::TileStreams;
use crate::windows::PhaseWindows;
use cachesim::Hierarchy;

/// Runs the warps of a frame. Matched once per tile.
#[expect(clippy::large_enum_variant, reason = "there is one per variant of a frame")]
pub(crate) enum Engine {
    Interleaved(Interleaver),
    Timed(Machine),
}

/// What an engine did in a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Finished {
    /// By [`Pass`].
    pub(crate) traffic: [TrafficCounters; Pass::COUNT],
    /// Dirty lines written back after the last access.
    pub(crate) flush: BufferTraffic,
    pub(crate) schedule: ScheduleCounters,
    /// What happened when; empty where time was simulated.
    pub(crate) phases: Vec<PhaseWindows>,
    pub(crate) timed: Option<TimedFrame>,
}

impl Engine {
    /// # Errors
    /// When the GPU's memory cannot be as described.
    pub(crate) fn new(
        fidelity: Fidelity,
        gpu: &Gpu,
        hierarchy: Hierarchy,
        paths: KindPaths,
        places: Places,
        resident_warps: u32,
        maps: Maps,
    ) -> Result<Self, Error> {
        Ok(match fidelity {
            Fidelity::Replay => {
                Self::Interleaved(Interleaver::new(gpu, hierarchy, paths, places, resident_warps, maps))
            }
            Fidelity::Timed => {
                Self::Timed(Machine::new(gpu, hierarchy, paths, places, resident_warps, maps)?)
            }
        })
    }

    /// Keeps every request to memory, where there are times.
    pub(crate) fn keep_misses(&mut self) {
        if let Self::Timed(machine) = self {
            machine.keep_misses();
        }
    }

    /// Queues the warps of a tile.
    pub(crate) fn push(&mut self, streams: &TileStreams) {
        match self {
            Self::Interleaved(interleaver) => interleaver.push(streams),
            // Turns with costs are all in one stream.
            Self::Timed(machine) => machine.push(&streams.own),
        }
    }

    /// Goes on as far as it can without knowing what is queued next.
    pub(crate) fn run_ahead(&mut self) {
        match self {
            Self::Interleaved(interleaver) => interleaver.run_ahead(),
            Self::Timed(machine) => machine.run_ahead(),
        }
    }

    /// Goes on to the end of the last warp: what is queued afterwards begins on empty cores. `pass` is the first of what ends.
    pub(crate) fn drain(&mut self, pass: Pass) {
        match self {
            Self::Interleaved(interleaver) => interleaver.drain(pass),
            Self::Timed(machine) => machine.drain(pass),
        }
    }

    /// From now on a core holds so many warps; it is empty.
    pub(crate) fn set_resident_warps(&mut self, warps: u32) {
        match self {
            Self::Interleaved(interleaver) => interleaver.set_resident_warps(warps),
            Self::Timed(_) => unreachable!("frames of several shaders are not simulated event by event"),
        }
    }

    /// Lines that each warp read from memory, by its number.
    pub(crate) fn misses_by_warp(&self) -> &[u32] {
        match self {
            Self::Interleaved(interleaver) => interleaver.misses_by_warp(),
            Self::Timed(machine) => machine.misses_by_warp(),
        }
    }

    /// Writes dirty lines back; everything has been drained.
    pub(crate) fn finish(self) -> Finished {
        match self {
            Self::Interleaved(interleaver) => interleaver.finish(),
            Self::Timed(machine) => machine.finish(),
        }
    }
}
