//! From a kernel to its time.

use super::{Kernel, KernelTurn, LaneAccess, Route};
use crate::config::Gpu;
use crate::counters::{BufferTraffic, IssueCounters, Pass, PassCounters};
use crate::engine::Engine;
use crate::error::Error;
use crate::estimate::phase_seconds;
use crate::interleave::KindPaths;
use crate::layout::{BufferKind, Places};
use crate::replay::{Fidelity, Maps};
use crate::schedule::warps_that_fit;
use crate::timed::{TimedFrame, TimedPhase};
use crate::warp::{Distinct, Run, StreamWriter, TileStream, Turn};
use cachesim::Hierarchy;
use std::sync::Arc;

/// Warps of a stream: enough that pushing them costs nothing, and few enough to stay in memory.
const STREAM_WARPS: u32 = 64;
/// What an unfiltered sample delivers at most: a texel of four words, as many bytes as a bilinear sample reads of 32-bit texels.
const SAMPLE_BYTES: u32 = 16;
const MOST_LANES: usize = 64;

/// What a kernel cost.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelResult {
    /// From its first warp to its last byte.
    pub seconds: f64,
    /// Warps that a core held at once.
    pub resident_warps: u32,
    /// What its warps issued.
    pub issue: IssueCounters,
    /// What its loads and stores caused in caches and memory; dirty lines that remain at the end are in no count.
    pub traffic: BufferTraffic,
    /// Where the time went, if it was simulated.
    pub timed: Option<TimedPhase>,
}

/// Runs a kernel that has the GPU for itself, from cold caches.
///
/// # Errors
/// When a lane needs more registers than there are, an access has more lanes than a warp or no bytes, or the kernel takes more
/// memory than 2^32 lines. As [`estimate`](crate::estimate).
pub fn run_kernel(kernel: &dyn Kernel, gpu: &Gpu, fidelity: Fidelity) -> Result<KernelResult, Error> {
    let refuse = |problem: String, remedy: &str| Error::Kernel { problem, remedy: remedy.to_owned() };
    let resident_warps = warps_that_fit(gpu, kernel.registers());
    if resident_warps == 0 {
        let problem = format!(
            "it needs {} vec4 registers per lane, {} has {}",
            kernel.registers(),
            gpu.name(),
            gpu.registers.vec4
        );
        return Err(refuse(problem, "use fewer"));
    }
    let (hierarchy, ids) = Hierarchy::with_paths(gpu.levels(), &gpu.paths.as_slices())
        .map_err(|error| refuse(error.to_string(), "correct [paths] of the GPU"))?;
    let paths = KindPaths::new(&ids);
    let line_shifts =
        [Route::Buffer, Route::Texture].map(|route| hierarchy.granule(paths.of(route.kind(), false)).log2());
    let mut emitter = KernelEmitter::new(gpu, line_shifts);
    let mut engine =
        Engine::new(fidelity, gpu, hierarchy, paths, Places::default(), resident_warps, Maps::Dropped)?;

    let mut issue = [IssueCounters::default(); Pass::COUNT];
    let mut turn = KernelTurn::default();
    for warp in 0..kernel.warps() {
        let mut number = 0;
        turn.clear();
        while kernel.turn(warp, number, &mut turn) {
            emitter.turn(&turn).map_err(|problem| refuse(problem, "correct the kernel"))?;
            number += 1;
            turn.clear();
        }
        emitter.end_warp();
        if (warp + 1) % STREAM_WARPS == 0 || warp + 1 == kernel.warps() {
            let stream = emitter.take();
            issue.iter_mut().zip(stream.issue).for_each(|(sum, of)| *sum += of);
            engine.push(&Arc::new(stream));
            engine.run_ahead();
        }
    }
    // The estimate finds the way of the loads by the pass.
    let pass = if issue[Route::Texture.pass() as usize].turns > 0 {
        Route::Texture.pass()
    } else {
        Route::Buffer.pass()
    };
    engine.drain(pass);
    let finished = engine.finish();
    let mut counters = PassCounters::default();
    for (issue, traffic) in issue.into_iter().zip(finished.traffic) {
        counters += PassCounters { issue, traffic };
    }
    let timed = finished.timed.as_ref().and_then(|TimedFrame { phases, .. }| phases.first());
    let timed = timed.map(|&(_, phase)| phase);
    let seconds = match timed {
        Some(phase) => phase.cycles / gpu.clock.hz,
        None => phase_seconds(pass, &counters, &finished.phases, resident_warps, gpu)?,
    };
    Ok(KernelResult {
        seconds,
        resident_warps,
        issue: counters.issue,
        traffic: counters.traffic.total(),
        timed,
    })
}

impl Route {
    /// A kind of buffer that takes this way.
    fn kind(self) -> BufferKind {
        match self {
            Self::Buffer => BufferKind::Node,
            Self::Texture => BufferKind::Image,
        }
    }

    /// A pass whose loads take this way.
    fn pass(self) -> Pass {
        match self {
            Self::Buffer => Pass::Primary,
            Self::Texture => Pass::Present,
        }
    }
}

impl KernelTurn {
    fn clear(&mut self) {
        (self.alu, self.efu) = (0, 0);
        self.accesses.clear();
    }
}

/// Writes streams.
struct KernelEmitter<'a> {
    gpu: &'a Gpu,
    /// By route.
    line_shifts: [u32; 2],
    distinct: Distinct,
    writer: StreamWriter,
    stream: TileStream,
}

impl<'a> KernelEmitter<'a> {
    fn new(gpu: &'a Gpu, line_shifts: [u32; 2]) -> Self {
        Self {
            gpu,
            line_shifts,
            distinct: Distinct::new(),
            writer: StreamWriter::new(),
            stream: TileStream::default(),
        }
    }

    fn turn(&mut self, turn: &KernelTurn) -> Result<(), String> {
        let waits = turn.accesses.iter().any(|access| !access.write);
        let pass = turn.accesses.first().map_or(Pass::Primary, |access| access.route.pass());
        let mut port_cycles = 0;
        for access in &turn.accesses {
            port_cycles += self.access(pass, access)?;
        }
        let lanes = u64::from(self.gpu.cores.warp_width);
        let issue = &mut self.stream.issue[pass as usize];
        issue.alu_issued += u64::from(turn.alu) * lanes;
        issue.efu_issued += u64::from(turn.efu) * lanes;
        issue.load_store_cycles += u64::from(port_cycles);
        if !turn.accesses.is_empty() {
            self.writer.end_turn();
            issue.turns += 1;
            issue.memory_waits += u64::from(waits);
        }
        self.stream.turns.push(Turn {
            alu: turn.alu,
            efu: turn.efu,
            port_cycles,
            output_bytes: 0,
            runs: turn.accesses.len() as u16,
            waits,
        });
        Ok(())
    }

    /// Writes the run of a load or store; returns the cycles that its port or texture unit needs for it.
    fn access(&mut self, pass: Pass, access: &LaneAccess) -> Result<u32, String> {
        let LaneAccess { route, write, bytes, ref addresses } = *access;
        let most = (self.gpu.cores.warp_width as usize).min(MOST_LANES);
        if addresses.is_empty() || addresses.len() > most {
            return Err(format!("an access has {} lanes, expected 1 to {most}", addresses.len()));
        }
        if !(1..=16).contains(&bytes) {
            return Err(format!("an access has {bytes} bytes per lane, expected 1 to 16"));
        }
        let shift = self.line_shifts[route as usize];
        if let Some(far) = addresses.iter().find(|&&address| address >> shift > u64::from(u32::MAX)) {
            return Err(format!("address {far} is beyond 2^32 lines"));
        }
        let lines = addresses.iter().map(|&address| (address >> shift) as u32);
        let found = self.distinct.filter(lines, self.writer.lines());
        self.writer.push(Run::new(pass, route.kind(), write, found, 1));
        let lanes = addresses.len() as u32;
        let cycles = match route {
            Route::Buffer => (lanes * bytes).div_ceil(self.gpu.load_store.bytes_per_clock),
            Route::Texture => {
                let samples = f64::from(lanes * bytes.div_ceil(SAMPLE_BYTES));
                (samples / self.gpu.texture.samples_per_clock).ceil() as u32
            }
        };
        let issue = &mut self.stream.issue[pass as usize];
        issue.memory_instructions += 1;
        issue.line_requests += found as u64;
        issue.line_accesses += found as u64;
        issue.lane_bytes += u64::from(lanes * bytes);
        Ok(cycles.max(found as u32))
    }

    fn end_warp(&mut self) {
        self.stream.warp_ends.push(self.writer.len());
        self.stream.turn_ends.push(self.stream.turns.len());
    }

    fn take(&mut self) -> TileStream {
        TileStream { words: self.writer.take(), ..std::mem::take(&mut self.stream) }
    }
}
