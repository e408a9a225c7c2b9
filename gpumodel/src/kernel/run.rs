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
use crate::warp::{Distinct, Run, StreamWriter, TileStream, TileStreams, Turn};

/// Warps of a stream: enough that pushing them costs nothing, and few enough to stay in memory.
const STREAM_WARPS: u32 = 64;
/// What a sample reads at most: four texels of 32 bits for a bilinear one, or one of 128 bits.
const SAMPLE_BYTES: u32 = 16;
const MOST_LANES: usize = 64;
/// Texels of a bilinear sample.
const MOST_PER_LANE: u32 = 4;
/// Lanes that the texture unit serves together.
const QUAD: usize = 4;

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
    let (hierarchy, ids) =
        gpu.hierarchy().map_err(|error| refuse(error.to_string(), "correct [paths] of the GPU"))?;
    let paths = KindPaths::new(&ids, false);
    let line_shifts = [Route::Buffer, Route::Texture]
        .map(|route| hierarchy.granule(paths.of(Pass::Output, route.kind(), false)).log2());
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
            engine.push(&TileStreams::joined(stream));
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
            Self::Buffer => BufferKind::Record,
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
        (self.alu, self.efu, self.output_bytes) = (0, 0, 0);
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
            writer: StreamWriter::default(),
            stream: TileStream::default(),
        }
    }

    fn turn(&mut self, turn: &KernelTurn) -> Result<(), String> {
        let waits = turn.accesses.iter().any(|access| !access.write);
        let pass = turn.accesses.first().map_or(Pass::Primary, |access| access.route.pass());
        let (mut port_cycles, mut runs) = (0.0, 0);
        for access in &turn.accesses {
            let (cycles, of_access) = self.access(pass, access)?;
            port_cycles += cycles;
            runs += of_access;
        }
        let port_cycles = port_cycles.ceil() as u32;
        let lanes = u64::from(self.gpu.cores.warp_width);
        let issue = &mut self.stream.issue[pass as usize];
        issue.alu_issued += u64::from(turn.alu) * lanes;
        issue.efu_issued += u64::from(turn.efu) * lanes;
        issue.load_store_cycles += u64::from(port_cycles);
        issue.output_bytes += u64::from(turn.output_bytes);
        if !turn.accesses.is_empty() {
            self.writer.end_turn();
            issue.turns += 1;
            issue.memory_waits += u64::from(waits);
        }
        self.stream.turns.push(Turn {
            alu: turn.alu,
            efu: turn.efu,
            port_cycles,
            output_bytes: turn.output_bytes,
            runs,
            waits,
        });
        Ok(())
    }

    /// Writes the runs of a load or store; returns the cycles that its port or texture unit needs for it, and the number of runs.
    fn access(&mut self, pass: Pass, access: &LaneAccess) -> Result<(f64, u16), String> {
        let LaneAccess { route, write, bytes, per_lane, ref addresses } = *access;
        let most = (self.gpu.cores.warp_width as usize).min(MOST_LANES);
        let lanes = addresses.len() / per_lane.max(1) as usize;
        if lanes == 0 || lanes > most || !addresses.len().is_multiple_of(lanes) {
            return Err(format!("an access has {lanes} lanes, expected 1 to {most}"));
        }
        if route == Route::Buffer && per_lane != 1 || per_lane > MOST_PER_LANE {
            return Err(format!(
                "an access has {per_lane} addresses per lane, expected 1, or up to {MOST_PER_LANE} of a texture"
            ));
        }
        if !(1..=16).contains(&bytes) {
            return Err(format!("an access has {bytes} bytes per lane, expected 1 to 16"));
        }
        let shift = self.line_shifts[route as usize];
        if let Some(far) = addresses.iter().find(|&&address| address >> shift > u64::from(u32::MAX)) {
            return Err(format!("address {far} is beyond 2^32 lines"));
        }
        let together = match route {
            Route::Buffer => addresses.len(),
            Route::Texture => QUAD * per_lane as usize,
        };
        let (mut cycles, mut runs, mut all_lines) = (0.0, 0, 0);
        for group in addresses.chunks(together) {
            let lines = group.iter().map(|&address| (address >> shift) as u32);
            let found = self.distinct.filter(lines, self.writer.lines());
            let of_group = self.cycles(route, group.len() as u32 / per_lane, bytes * per_lane, found as u32);
            let run = Run::new(pass, route.kind(), write, found, 1);
            self.writer.push(run.with_port_cycles(of_group.ceil() as u32));
            cycles += of_group;
            runs += 1;
            all_lines += found as u64;
        }
        let issue = &mut self.stream.issue[pass as usize];
        issue.memory_instructions += 1;
        issue.line_requests += all_lines;
        issue.line_accesses += all_lines;
        issue.lane_bytes += addresses.len() as u64 * u64::from(bytes);
        Ok((cycles, runs))
    }

    /// What `lanes` that are served together take, of `bytes` each, which lie in so many lines.
    fn cycles(&self, route: Route, lanes: u32, bytes: u32, lines: u32) -> f64 {
        match route {
            Route::Buffer => {
                f64::from((lanes * bytes).div_ceil(self.gpu.load_store.bytes_per_clock).max(lines))
            }
            Route::Texture => {
                let samples = f64::from(lanes * bytes.div_ceil(SAMPLE_BYTES));
                let first = &self.gpu.caches[self.gpu.paths.texture[0]];
                (samples / self.gpu.texture.samples_per_clock).max(f64::from(lines.div_ceil(first.banks)))
            }
        }
    }

    fn end_warp(&mut self) {
        self.stream.warp_ends.push(self.writer.len());
        self.stream.turn_ends.push(self.stream.turns.len());
    }

    fn take(&mut self) -> TileStream {
        TileStream { words: self.writer.take(), ..std::mem::take(&mut self.stream) }
    }
}
