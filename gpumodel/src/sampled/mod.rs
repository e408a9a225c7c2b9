//! The rung that replays a designed sample of a frame's tiles, and says how far its figures may be off.
//!
//! Blocks of tiles are replayed each on cores and caches that the tiles before it have filled, and stand for the others, see
//! `design`. What they count is expanded to the frame's counts, from which time is found as on the rung
//! [`Fidelity::Replay`](crate::Fidelity). The same is done for replicates of the sample, from whose spread every counter has its
//! interval. Lines that a cache might have had if it had seen the whole frame widen it.
//!
//! Variants of a frame are sampled by the same blocks: how they differ is known much better than what each of them costs (Cochran 1977,
//! chapter 6, on ratios of what is measured on the same units).

mod block;
mod calibration;
mod design;
mod expand;
mod goal;
mod interval;
mod warm_up;

pub use goal::{Attempt, Goal};
pub use interval::{Intervals, Ratio};

use crate::config::Technique;
use crate::counters::{COUNTERS, FrameCounters, Pass};
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
use interval::Basis;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use tracer::{Frame, TILE_RAYS, TileOutline, TileSource};
use warm_up::WarmUp;

/// Fewest blocks that are drawn: with fewer, intervals are so wide that they say nothing.
const FEWEST_BLOCKS: u32 = 12;

/// A sample of so many of the tiles still takes less time than all of them, though blocks are run once more for what comes before them.
const LARGEST_PART: f64 = 0.5;

/// Turns that the picked stretches of time stand for, as a part of those of all tiles, if the frame's work was seen. They were 0.92 to
/// 1.12 of Crytek Sponza and Bistro on four GPUs; of Buddha, before an empty background, they were 0.10 on Mali-G78, whose DRAM
/// traffic was missed, and 0.50 on Adreno 640.
const SEEN: RangeInclusive<f64> = 0.8..=1.25;

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
    basis: Basis,
}

/// A frame that can be sampled, or variants of one.
pub struct Sampler<'a, S> {
    source: &'a S,
    variants: Vec<Sampleable<'a>>,
    /// Tiles of a block, and as many that come before it.
    block_tiles: u32,
    warm_up: WarmUp<'a, S>,
}

/// A variant of the frame, and its blocks: those of all variants are of the same tiles.
struct Sampleable<'a> {
    prepared: Prepared<'a>,
    blocks: Blocks,
}

/// Why frames of a technique cannot be sampled; `None` if they can.
pub fn unsampled(technique: &Technique) -> Option<&'static str> {
    technique.raster.map(|_| "the geometry is drawn bin by bin, for which all tiles of a trace are needed")
}

impl<'a, S: TileSource> Sampler<'a, S> {
    /// Prepares samples of `source` on each of `configs`, at least one, whose techniques [`unsampled`] does not rule out, on the rung
    /// [`Fidelity::Replay`].
    ///
    /// # Errors
    /// As [`replay`](crate::replay).
    ///
    /// # Panics
    /// Without `configs`.
    pub fn new(source: &'a S, configs: &'a [ReplayConfig]) -> Result<Self, Error> {
        let can_be = |config: &ReplayConfig| {
            unsampled(&config.technique).is_none() && config.fidelity == Fidelity::Replay
        };
        debug_assert!(configs.iter().all(can_be));
        let prepared: Vec<Prepared<'_>> =
            configs.iter().map(|config| Prepared::new(source, config)).collect::<Result<_, _>>()?;
        let frame = source.header().frame;
        let outlines: Option<Vec<TileOutline>> =
            (0..frame.tiles()).into_par_iter().map(|tile| source.outline(tile)).collect::<Result<_, _>>()?;
        let warps = |prepared: &Prepared<'_>| {
            let gpu = &prepared.config.gpu;
            // So many fill all cores, and so many make a tile.
            [gpu.cores.count * prepared.resident_warps, TILE_RAYS.div_ceil(gpu.cores.warp_width)]
        };
        let filling = prepared.iter().map(warps).map(|[resident, of_tile]| resident.div_ceil(of_tile));
        let block_tiles = filling.max().expect("there is a variant").max(1);
        let variant = |prepared| {
            let blocks = Blocks::new(frame, outlines.as_deref(), block_tiles, warps(&prepared));
            Sampleable { prepared, blocks }
        };
        let variants = prepared.into_iter().map(variant).collect();
        Ok(Self { source, variants, block_tiles, warm_up: WarmUp::new(source) })
    }

    /// The smallest part of the frame's tiles that makes a sample, and the largest that leaves something to be gained.
    pub fn parts(&self) -> [f64; 2] {
        let all = f64::from(self.source.header().frame.tiles());
        let of_blocks = |blocks: f64| blocks * 2.0 * f64::from(self.block_tiles) / all;
        [of_blocks(f64::from(FEWEST_BLOCKS + 2)), LARGEST_PART]
    }

    /// Replays about this part of all tiles on every variant, drawn by `seed`.
    ///
    /// # Errors
    /// As [`replay`](crate::replay).
    pub fn sample(&self, part: f64, seed: u64) -> Result<Vec<Sampled>, Error> {
        let Self { source, variants, block_tiles, warm_up } = self;
        let header = source.header();
        let tiles = f64::from(header.frame.tiles());
        let wanted = part * tiles / (2.0 * f64::from(*block_tiles)) - 2.0;
        let blocks = &variants[0].blocks;
        let picks = blocks.pick((wanted.round() as u32).max(FEWEST_BLOCKS), seed);

        let prepared: Vec<&Prepared<'_>> = variants.iter().map(|variant| &variant.prepared).collect();
        let workshop = Workshop::new(header, &prepared, Maps::Dropped);
        let count = |pick: &Pick| {
            let tiles = blocks.tiles(pick.block);
            block::count(*source, &prepared, &workshop, warm_up, (tiles, *block_tiles))
        };
        let counted = picks.par_iter().map(count).collect::<Result<Vec<Vec<Counted>>, Error>>()?;
        let mut by_variant: Vec<Vec<Counted>> = variants.iter().map(|_| Vec::new()).collect();
        for of_pick in counted {
            by_variant.iter_mut().zip(of_pick).for_each(|(of_variant, counted)| of_variant.push(counted));
        }
        let sampled = |(variant, counted): (&Sampleable<'_>, &Vec<Counted>)| {
            variant.sampled(*source, &picks, counted, *block_tiles)
        };
        variants.iter().zip(&by_variant).map(sampled).collect()
    }
}

impl Sampleable<'_> {
    /// What the picks counted stands for.
    fn sampled<S: TileSource>(
        &self,
        source: &S,
        picks: &[Pick],
        counted: &[Counted],
        block_tiles: u32,
    ) -> Result<Sampled, Error> {
        let Self { prepared, blocks } = self;
        let header = source.header();
        let present = self.present(source)?;
        let weights = design::weights(picks);
        let frame = |weights: &[f64], uncertain| -> Result<(Replayed, Estimate, f64), Error> {
            let expanded = expand(blocks, picks, weights, counted, uncertain);
            let seen = expanded.seen;
            let replayed = self.replayed(source, expanded, &present);
            let estimate = estimate(&replayed, header, source.topology(), prepared.config)?;
            Ok((replayed, estimate, seen))
        };
        // A cache that holds all that there is would have had every line by then.
        let (likely, other) = if prepared.fits_last_cache() {
            (Uncertain::Spared, Uncertain::Counted)
        } else {
            (Uncertain::Counted, Uncertain::Spared)
        };
        let (replayed, estimate, seen) = frame(&weights, likely)?;
        let others = [frame(&weights, other)?.1, frame(&weights, Uncertain::Evicting)?.1];
        let replicates = design::replicates(picks)
            .par_iter()
            .flatten_iter()
            .map(|weights| frame(weights, likely).map(|(_, estimate, _)| estimate))
            .collect::<Result<Vec<_>, _>>()?;
        let represents = SEEN.contains(&seen);
        let intervals = Intervals::new(&estimate, &others, &replicates, represents);
        let tiles = picks.iter().map(|pick| {
            let tiles = blocks.tiles(pick.block);
            tiles.end - tiles.start.saturating_sub(block_tiles)
        });
        let frames = |estimates: &[Estimate]| estimates.iter().map(|of| of.frame.clone()).collect();
        let basis = Basis {
            picks: picks.to_vec(),
            represents,
            whole: estimate.frame.clone(),
            others: frames(&others),
            replicates: frames(&replicates),
        };
        Ok(Sampled { replayed, estimate, intervals, tiles: tiles.sum(), basis })
    }

    /// The pass that draws the image of a compute stage, whole; it is the same in all samples.
    fn present<S: TileSource>(
        &self,
        source: &S,
    ) -> Result<Option<(FrameCounters, Vec<PhaseWindows>)>, Error> {
        let Self { prepared, .. } = self;
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

    fn replayed<S: TileSource>(
        &self,
        source: &S,
        Expanded { mut counters, phase, .. }: Expanded,
        present: &Option<(FrameCounters, Vec<PhaseWindows>)>,
    ) -> Replayed {
        let Prepared { program, resident_warps, lane_map, .. } = &self.prepared;
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

impl Sampled {
    /// Whether the sample has seen about as many turns as its tiles stand for. Where it has not, warps ran when it did not look: beside
    /// an object, those of the background come and go by the hundred while the object's still run. Nothing is then known of how far
    /// counters may be off.
    pub fn represents(&self) -> bool {
        self.basis.represents
    }

    /// How many times as large the counters of the frame are as those of `first`, a sample of the same blocks, by id; none where only the
    /// first is 0 or one of the two is not there. `None` if the blocks are others.
    pub fn ratios_to(&self, first: &Self) -> Option<Vec<(&'static str, Ratio)>> {
        let ratios = self.basis.ratios(&first.basis)?;
        let named = COUNTERS.iter().zip(ratios).filter_map(|(info, ratio)| Some((info.id, ratio?)));
        Some(named.collect())
    }
}

/// Warps of the traced pass.
fn warps(frame: Frame, lane_map: &LaneMap) -> u64 {
    (0..frame.tiles()).map(|tile| lane_map.warps(frame.tile(tile)).count() as u64).sum()
}
