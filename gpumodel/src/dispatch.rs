//! One dispatch after another on the same caches.

use crate::config::Gpu;
use crate::counters::{FrameCounters, Pass};
use crate::engine::{Engine, Finished};
use crate::error::Error;
use crate::layout::BufferBytes;
use crate::replay::{Replayed, add_issue};
use crate::warp::{Emitter, Stepper, TileStreams, TreeTurns};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};
use tracer::Tile;

/// Pieces of a batch per thread, so that few are in memory at once.
const PIECES_PER_THREAD: u32 = 16;

/// A GPU in the middle of a frame.
pub(crate) struct Running {
    pub(crate) engine: Engine,
    pub(crate) counters: FrameCounters,
    pub(crate) resident_warps: [u32; Pass::COUNT],
}

/// What one piece at a time is made with.
pub(crate) struct Bench {
    pub(crate) tile: Tile,
    pub(crate) stepper: Stepper,
    pub(crate) emitter: Emitter,
}

/// Benches outlast a piece, so that their memory grows to the size of a piece but once.
#[derive(Default)]
pub(crate) struct Benches(Mutex<Vec<Bench>>);

impl Benches {
    pub(crate) fn with<T>(&self, work: impl FnOnce(&mut Bench) -> Result<T, Error>) -> Result<T, Error> {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let bench = free().pop();
        let mut bench = bench.unwrap_or_else(|| Bench {
            tile: Tile::default(),
            stepper: Stepper::new(),
            emitter: Emitter::new(TreeTurns::Joined),
        });
        let done = work(&mut bench)?;
        free().push(bench);
        Ok(done)
    }
}

impl Running {
    /// What was counted, with dirty lines written back, of a frame with these buffers.
    pub(crate) fn finish(self, structure_bytes: u64, buffers: BufferBytes) -> Replayed {
        let Self { engine, mut counters, resident_warps } = self;
        let Finished { traffic, flush, schedule, phases, timed } = engine.finish();
        for (pass, traffic) in counters.passes.iter_mut().zip(traffic) {
            pass.traffic = traffic;
        }
        counters.flush = flush;
        counters.schedule = schedule;
        Replayed { counters, maps: None, structure_bytes, buffers, resident_warps, phases, timed }
    }

    /// Runs a dispatch, piece by piece, to its end: `make` makes the warps of a piece and what `keep` hears of it, in order. `passes` are those of the
    /// dispatch, the first of them first; a core holds `resident_warps` of its warps.
    pub(crate) fn dispatch<T: Send>(
        &mut self,
        passes: &[Pass],
        resident_warps: u32,
        pieces: u32,
        make: impl Fn(u32) -> Result<(TileStreams, T), Error> + Sync,
        mut keep: impl FnMut(T),
    ) -> Result<(), Error> {
        let Self { engine, counters, resident_warps: by_pass, .. } = self;
        engine.set_resident_warps(resident_warps);
        passes.iter().for_each(|&pass| by_pass[pass as usize] = resident_warps);
        let batch = PIECES_PER_THREAD * rayon::current_num_threads() as u32;
        let mut made: Vec<(TileStreams, T)> = Vec::new();
        let mut next = 0;
        while next < pieces || !made.is_empty() {
            let pieces = next..next.saturating_add(batch).min(pieces);
            next = pieces.end;
            let mut kept = Vec::with_capacity(made.len());
            let (next_made, ()) = rayon::join(
                || pieces.into_par_iter().map(&make).collect::<Result<Vec<_>, Error>>(),
                || {
                    for (streams, of_piece) in made.drain(..) {
                        add_issue(counters, &streams);
                        engine.push(&streams);
                        engine.run_ahead();
                        kept.push(of_piece);
                    }
                },
            );
            kept.into_iter().for_each(&mut keep);
            made = next_made?;
        }
        counters.passes[passes[0] as usize].issue.dispatches += 1;
        engine.drain(passes[0]);
        Ok(())
    }
}

/// Warps that a core holds of a shader with so many registers of four words per lane.
///
/// # Errors
/// When none fits.
pub(crate) fn resident_warps(gpu: &Gpu, registers: u32, technique: &str) -> Result<u32, Error> {
    match crate::schedule::warps_that_fit(gpu, registers) {
        0 => Err(Error::Config {
            file: technique.to_owned(),
            line: None,
            key: String::new(),
            problem: format!(
                "one of its shaders needs {registers} vec4 registers per lane, {} has {}",
                gpu.name(),
                gpu.registers.vec4
            ),
            remedy: "use a GPU with more, or other --costs".to_owned(),
        }),
        warps => Ok(warps),
    }
}
