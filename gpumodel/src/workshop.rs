//! Makes tiles for variants of a frame: a tile is decoded once, run in lockstep once for all variants whose warps have the same
//! shape, and what these read of the tree is listed once for all to which it lies the same.

use crate::error::Error;
use crate::prepared::Prepared;
use crate::replay::{Maps, refuse};
use crate::schedule::{HELPER, LaneMap};
use crate::warp::{Emitter, Program, Stepper, TileStreams, TreeTurns, Walk, WarpSteps};
use std::sync::{Arc, Mutex, PoisonError};
use tracer::{Tile, TileDraw, TileRect, TileSource, TraceHeader};

/// What a tile is on one variant.
pub(crate) struct VariantTile {
    pub(crate) streams: TileStreams,
    /// Per ray of the tile, where maps are kept.
    pub(crate) node_fetches: Vec<u32>,
    pub(crate) loaded_bytes: Vec<u32>,
    /// In per cent, as [`HeatMaps::wasted_slots`](crate::HeatMaps::wasted_slots); empty where lanes do not wait for each other.
    pub(crate) wasted_slots: Vec<u32>,
}

/// A tile for all variants.
pub(crate) struct MadeTile {
    pub(crate) rect: TileRect,
    pub(crate) draws: Vec<TileDraw>,
    /// By variant.
    pub(crate) variants: Vec<VariantTile>,
}

/// What all threads need to make tiles for all variants.
pub(crate) struct Workshop<'a> {
    header: &'a TraceHeader,
    programs: Vec<Arc<Program>>,
    /// Variants whose warps have the same shape share a lane map.
    shapes: Vec<Shape>,
    maps: Maps,
    /// Some variant rasterises the geometry.
    rasters: bool,
    /// Benches outlast a tile, so that their memory grows to the size of a tile but once.
    benches: Mutex<Vec<Bench>>,
}

struct Shape {
    lane_map: LaneMap,
    walk: Walk,
    /// Ray sets that any of its variants traces.
    wanted: Vec<bool>,
    variants: Vec<Sharer>,
}

/// A variant among those of its shape.
struct Sharer {
    variant: usize,
    /// The variant before it which has their turns on the tree.
    tree_of: Option<usize>,
}

/// What one tile at a time is made with.
struct Bench {
    tile: Tile,
    stepper: Stepper,
    /// By variant.
    emitters: Vec<Emitter>,
}

impl<'a> Workshop<'a> {
    pub(crate) fn new(header: &'a TraceHeader, variants: &[&Prepared<'_>], maps: Maps) -> Self {
        let mut shapes: Vec<Shape> = Vec::new();
        for (index, variant) in variants.iter().enumerate() {
            let wanted = variant.program.wanted();
            let sharer = |earlier: &[Sharer]| {
                let alike = |other: &&Sharer| variant.program.reads_tree_as(&variants[other.variant].program);
                let leads = |other: &&Sharer| other.tree_of.is_none();
                let tree_of = earlier.iter().filter(leads).find(alike).map(|leader| leader.variant);
                Sharer { variant: index, tree_of }
            };
            let alike = |shape: &&mut Shape| shape.lane_map == variant.lane_map && shape.walk == variant.walk;
            match shapes.iter_mut().find(alike) {
                Some(shape) => {
                    let sharer = sharer(&shape.variants);
                    shape.variants.push(sharer);
                    shape.wanted.iter_mut().zip(wanted).for_each(|(any, this)| *any |= this);
                }
                None => {
                    let (lane_map, walk) = (variant.lane_map.clone(), variant.walk.clone());
                    shapes.push(Shape { lane_map, walk, wanted, variants: vec![sharer(&[])] });
                }
            }
        }
        let programs = variants.iter().map(|variant| Arc::clone(&variant.program)).collect();
        let rasters = variants.iter().any(|variant| variant.config.technique.raster.is_some());
        Self { header, programs, shapes, maps, rasters, benches: Mutex::default() }
    }

    fn bench(&self) -> Bench {
        let mut tree_turns = vec![TreeTurns::Joined; self.programs.len()];
        for &Sharer { variant, tree_of } in self.shapes.iter().flat_map(|shape| &shape.variants) {
            if let Some(leader) = tree_of {
                tree_turns[leader] = TreeTurns::Apart;
                tree_turns[variant] = TreeTurns::Elsewhere;
            }
        }
        let emitters = tree_turns.into_iter().map(Emitter::new).collect();
        Bench { tile: Tile::default(), stepper: Stepper::new(), emitters }
    }

    /// Makes a tile.
    ///
    /// # Errors
    /// When it cannot be read or contradicts itself.
    pub(crate) fn tile<S: TileSource>(&self, source: &S, index: u32) -> Result<MadeTile, Error> {
        let free = || self.benches.lock().unwrap_or_else(PoisonError::into_inner);
        let bench = free().pop();
        let mut bench = bench.unwrap_or_else(|| self.bench());
        let made = self.make(source, &mut bench, index)?;
        free().push(bench);
        Ok(made)
    }

    fn make<S: TileSource>(&self, source: &S, bench: &mut Bench, index: u32) -> Result<MadeTile, Error> {
        let Bench { tile, stepper, emitters } = bench;
        source.tile(index, tile)?;
        let rect = self.header.frame.tile(index);
        check(self.header, tile, rect.width * rect.height)?;
        let mut streams: Vec<Option<TileStreams>> = self.programs.iter().map(|_| None).collect();
        let mut wasted: Vec<Vec<u32>> = vec![Vec::new(); self.programs.len()];
        for Shape { lane_map, walk, wanted, variants } in &self.shapes {
            let keeps = self.maps == Maps::Kept && walk.in_lockstep();
            if keeps {
                let empty = vec![0; (rect.width * rect.height) as usize];
                variants.iter().for_each(|sharer| wasted[sharer.variant].clone_from(&empty));
            }
            let emit = |warp: &WarpSteps| {
                variants.iter().try_for_each(|&Sharer { variant, .. }| {
                    if keeps {
                        paint_wasted(&mut wasted[variant], warp, &self.programs[variant].wanted());
                    }
                    emitters[variant].trace(&self.programs[variant], warp, index, rect)
                })
            };
            let tally = stepper
                .run(self.header, (walk, wanted), lane_map, (tile, rect), emit)
                .map_err(|problem| refuse(self.header, problem))?;
            for &Sharer { variant, tree_of } in variants {
                let tree = tree_of.and_then(|leader| streams[leader].as_ref()).map(|leader| &leader.tree);
                let taken = emitters[variant].take(&self.programs[variant], &tally, tree);
                streams[variant] = Some(taken);
            }
        }
        let streams = streams.into_iter().map(|streams| streams.expect("every variant is of some shape"));
        let variants = streams.zip(&self.programs).zip(wasted).map(|((streams, program), wasted_slots)| {
            let (node_fetches, loaded_bytes) = match self.maps {
                Maps::Kept => per_ray(tile, program, rect.width * rect.height),
                Maps::Dropped => (Vec::new(), Vec::new()),
            };
            VariantTile { streams, node_fetches, loaded_bytes, wasted_slots }
        });
        let variants = variants.collect();
        let draws = if self.rasters { std::mem::take(&mut tile.draws) } else { Vec::new() };
        Ok(MadeTile { rect, draws, variants })
    }
}

/// Node records and bytes that each ray of a tile, and all rays that follow from it, read.
pub(crate) fn per_ray(tile: &Tile, program: &Program, rays: u32) -> (Vec<u32>, Vec<u32>) {
    let wanted = program.wanted();
    let of_ray = |ray: usize| {
        let sets = tile.ray_sets.iter().zip(&wanted).filter(|&(_, &wanted)| wanted).map(|(set, _)| set);
        let steps = sets.flat_map(|set| &set.steps[set.range(ray)]);
        steps.fold((0_u32, 0_u32), |(records, bytes), step| {
            let (op, id) = (step.op(), step.id());
            (records + program.records(op, id), bytes.saturating_add(program.loaded_bytes(op, id)))
        })
    };
    (0..rays as usize).map(of_ray).unzip()
}

/// Gives the rays of a warp the part of its lane slots that was wasted, in per cent, all wanted ray sets together.
fn paint_wasted(by_ray: &mut [u32], warp: &WarpSteps, wanted: &[bool]) {
    let sets = warp.sets.iter().zip(wanted).filter(|&(_, &wanted)| wanted);
    let [slots, used] = sets.fold([0, 0], |[slots, used], (set, _)| {
        let [of_set, used_of_set] = set.lane_slots;
        [slots + of_set, used + used_of_set]
    });
    // A warp that traces nothing wastes nothing.
    let part = if slots > 0 { 1.0 - used as f64 / slots as f64 } else { 0.0 };
    let per_cent = (100.0 * part).round() as u32;
    warp.rays.iter().filter(|&&ray| ray != HELPER).for_each(|&ray| by_ray[ray as usize] = per_cent);
}

/// Checks what lockstep relies on.
fn check(header: &TraceHeader, tile: &Tile, rays: u32) -> Result<(), Error> {
    let (expected, found) = (header.ray_sets.len(), tile.ray_sets.len());
    if found != expected {
        return Err(refuse(header, format!("a tile has {found} ray sets, expected {expected}")));
    }
    for set in &tile.ray_sets {
        let ends_rise = set.ends.is_sorted();
        let last = set.ends.last().copied().unwrap_or(0) as usize;
        let complete = set.ends.len() == rays as usize && set.hits.len() == rays as usize;
        if !(ends_rise && complete && last <= set.steps.len()) {
            let problem = format!(
                "a ray set of a tile of {rays} rays has {} ends, {} hits and {} steps up to {last}",
                set.ends.len(),
                set.hits.len(),
                set.steps.len()
            );
            return Err(refuse(header, problem));
        }
    }
    Ok(())
}
