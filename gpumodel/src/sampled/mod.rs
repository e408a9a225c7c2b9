//! The rung that replays a designed sample of a frame's tiles, and says how far its figures may be off.
//!
//! Blocks of tiles are replayed each on cores and caches that the tiles before it have filled, and stand for the others, see
//! `design`. What they count is expanded to the frame's counts, from which time is found as on the rung
//! [`Fidelity::Replay`](crate::Fidelity). The same is done for replicates of the sample, from whose spread every counter has its
//! interval. Lines that a cache might have had if it had seen the whole frame widen it.

mod block;
mod calibration;
mod design;
mod expand;
mod goal;
mod interval;

pub use goal::{Attempt, Goal};
pub use interval::Intervals;

use crate::config::Technique;
use crate::counters::{FrameCounters, Pass};
use crate::engine::{Engine, Finished};
use crate::error::Error;
use crate::estimate::{Estimate, estimate};
use crate::layout::Buffers;
use crate::prepared::Prepared;
use crate::replay::{Fidelity, Maps, ReplayConfig, Replayed, present};
use crate::schedule::LaneMap;
use crate::windows::PhaseWindows;
use crate::workshop::Workshop;
use block::Counted;
use design::{Blocks, Pick};
use expand::{Expanded, Uncertain, expand};
use rayon::prelude::*;
use tracer::{Frame, TILE_RAYS, TileOutline, TileSource};

/// Fewest blocks that are drawn: with fewer, intervals are so wide that they say nothing.
const FEWEST_BLOCKS: u32 = 12;

/// A sample of so many of the tiles still takes less time than all of them, though blocks are run once more for what comes before them.
const LARGEST_PART: f64 = 0.5;

/// A frame from a sample of its tiles.
pub struct Sampled {
    /// The frame's counts, expanded; without maps.
    pub replayed: Replayed,
    /// What it costs.
    pub estimate: Estimate,
    /// How far each counter may be off.
    pub intervals: Intervals,
    /// Tiles that were replayed, those among them that only filled cores and caches.
    pub tiles: u32,
}

/// A frame that can be sampled.
pub struct Sampler<'a, S> {
    source: &'a S,
    prepared: Prepared<'a>,
    blocks: Blocks,
    /// Tiles of a block, and as many that come before it.
    block_tiles: u32,
}

/// Why frames of a technique cannot be sampled; `None` if they can.
pub fn unsampled(technique: &Technique) -> Option<&'static str> {
    technique.raster.map(|_| "the geometry is drawn bin by bin, for which all tiles of a trace are needed")
}

impl<'a, S: TileSource> Sampler<'a, S> {
    /// Prepares samples of `source` on `config`, whose technique [`unsampled`] does not rule out, on the rung [`Fidelity::Replay`].
    ///
    /// # Errors
    /// As [`replay`](crate::replay).
    pub fn new(source: &'a S, config: &'a ReplayConfig) -> Result<Self, Error> {
        debug_assert!(unsampled(&config.technique).is_none() && config.fidelity == Fidelity::Replay);
        let prepared = Prepared::new(source, config)?;
        let frame = source.header().frame;
        let outlines: Option<Vec<TileOutline>> =
            (0..frame.tiles()).into_par_iter().map(|tile| source.outline(tile)).collect::<Result<_, _>>()?;
        let warps_of_tile = TILE_RAYS.div_ceil(config.gpu.cores.warp_width);
        // So many fill all cores.
        let resident = config.gpu.cores.count * prepared.resident_warps;
        let block_tiles = resident.div_ceil(warps_of_tile).max(1);
        let blocks = Blocks::new(frame, outlines.as_deref(), block_tiles, [resident, warps_of_tile]);
        Ok(Self { source, prepared, blocks, block_tiles })
    }

    /// The smallest part of the frame's tiles that makes a sample, and the largest that leaves something to be gained.
    pub fn parts(&self) -> [f64; 2] {
        let all = f64::from(self.source.header().frame.tiles());
        let of_blocks = |blocks: f64| blocks * 2.0 * f64::from(self.block_tiles) / all;
        [of_blocks(f64::from(FEWEST_BLOCKS + 2)), LARGEST_PART]
    }

    /// Replays about this part of all tiles, drawn by `seed`.
    ///
    /// # Errors
    /// As [`replay`](crate::replay).
    pub fn sample(&self, part: f64, seed: u64) -> Result<Sampled, Error> {
        let Self { source, prepared, blocks, block_tiles } = self;
        let header = source.header();
        let tiles = f64::from(header.frame.tiles());
        let wanted = part * tiles / (2.0 * f64::from(*block_tiles)) - 2.0;
        let picks = blocks.pick((wanted.round() as u32).max(FEWEST_BLOCKS), seed);

        let workshop = Workshop::new(header, &[prepared], Maps::Dropped);
        let count = |pick: &Pick| {
            let tiles = blocks.tiles(pick.block);
            block::count(*source, prepared, &workshop, tiles, *block_tiles)
        };
        let counted = picks.par_iter().map(count).collect::<Result<Vec<Counted>, Error>>()?;

        let present = self.present()?;
        let weights = design::weights(&picks);
        let frame = |weights: &[f64], uncertain| -> Result<(Replayed, Estimate), Error> {
            let replayed = self.replayed(expand(blocks, &picks, weights, &counted, uncertain), &present);
            let estimate = estimate(&replayed, header, source.topology(), prepared.config)?;
            Ok((replayed, estimate))
        };
        // A cache that holds all that there is would have had every line by then.
        let (likely, other) = if prepared.fits_last_cache() {
            (Uncertain::Spared, Uncertain::Counted)
        } else {
            (Uncertain::Counted, Uncertain::Spared)
        };
        let (replayed, estimate) = frame(&weights, likely)?;
        let others = [frame(&weights, other)?.1, frame(&weights, Uncertain::Evicting)?.1];
        let replicates = design::replicates(&picks)
            .par_iter()
            .flatten_iter()
            .map(|weights| frame(weights, likely).map(|(_, estimate)| estimate))
            .collect::<Result<Vec<_>, _>>()?;
        let intervals = Intervals::new(&estimate, &others, &replicates);
        let tiles = picks.iter().map(|pick| {
            let tiles = blocks.tiles(pick.block);
            tiles.end - tiles.start.saturating_sub(*block_tiles)
        });
        Ok(Sampled { replayed, estimate, intervals, tiles: tiles.sum() })
    }

    /// The pass that draws the image of a compute stage, whole; it is the same in all samples.
    fn present(&self) -> Result<Option<(FrameCounters, Vec<PhaseWindows>)>, Error> {
        let Self { source, prepared, .. } = self;
        if prepared.config.technique.present.is_none() {
            return Ok(None);
        }
        let mut engine = Engine::Interleaved(prepared.interleaver()?);
        let mut counters = FrameCounters::default();
        present(prepared, source.header().frame, &mut engine, &mut counters);
        let Finished { traffic, flush, schedule, phases, .. } = engine.finish();
        counters.passes.iter_mut().zip(traffic).for_each(|(pass, traffic)| pass.traffic = traffic);
        counters.flush = flush;
        counters.schedule = schedule;
        Ok(Some((counters, phases)))
    }

    fn replayed(
        &self,
        Expanded { mut counters, phase }: Expanded,
        present: &Option<(FrameCounters, Vec<PhaseWindows>)>,
    ) -> Replayed {
        let Self { source, prepared: Prepared { program, resident_warps, lane_map, .. }, .. } = self;
        counters.schedule.warps = warps(source.header().frame, lane_map);
        let mut phases = vec![phase];
        if let Some((of_present, windows)) = present {
            counters.passes.iter_mut().zip(of_present.passes).for_each(|(sum, pass)| *sum += pass);
            counters.flush += of_present.flush;
            counters.schedule += of_present.schedule;
            phases.extend_from_slice(windows);
        }
        counters.stalls = source.stalls();
        let Buffers { structure_bytes, sizes: buffers, .. } = program.buffers;
        let resident_warps = [*resident_warps; Pass::COUNT];
        Replayed { counters, maps: None, structure_bytes, buffers, resident_warps, phases, timed: None }
    }
}

/// Warps of the traced pass.
fn warps(frame: Frame, lane_map: &LaneMap) -> u64 {
    (0..frame.tiles()).map(|tile| lane_map.warps(frame.tile(tile)).count() as u64).sum()
}
