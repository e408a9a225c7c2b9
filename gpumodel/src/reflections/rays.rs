//! The passes over lists of rays: they trace, shade, or keep what is hit.

use super::lists::{HIT_BYTES, ID_BYTES, LOAD_BYTES, Lists, MATERIAL_BYTES, POSITION_BYTES, RAY_BYTES};
use super::maps::{LaneSlots, PieceCosts};
use super::march::MarchPass;
use super::pipeline::Pipeline;
use super::prices::Prices;
use crate::counters::Pass;
use crate::dispatch::Bench;
use crate::error::Error;
use crate::layout::{BufferKind, PIXEL_BYTES};
use crate::replay::{Maps, refuse};
use crate::schedule::{HELPER, LaneMap};
use crate::warp::{Emitter, Program, TileStreams, Walk, WarpSteps};
use crate::workshop::per_ray;
use tracer::reflections::ReflectionList;
use tracer::{NOT_CAST, TILE_RAYS};

/// Where its lanes find their rays.
pub(super) enum From<'a> {
    /// In their pixels, which they march first.
    Pixels(&'a MarchPass<'a>, &'a [u32]),
    /// In the list, lane by lane.
    List,
    /// In the list of hits by material: by place, that in this list and that in the list of rays.
    Sorted(&'a [[u32; 2]]),
}

/// What its lanes do with hits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Hits {
    /// They shade them.
    Shaded,
    /// They keep them for a pass that shades.
    Kept,
}

/// What its warps execute.
pub(super) struct RayPass<'a> {
    pub(super) program: &'a Program,
    pub(super) walk: &'a Walk,
    pub(super) lane_map: &'a LaneMap,
    pub(super) prices: Prices<'a>,
    pub(super) lists: &'a Lists,
    /// By place.
    pub(super) rays: &'a (dyn ReflectionList + 'a),
    pub(super) width: u32,
    /// By triangle, its shader.
    pub(super) shaders: &'a [u32],
    pub(super) from: From<'a>,
    /// Whose shaders shade hits; otherwise they do so in a switch.
    pub(super) pipeline: Option<&'a Pipeline>,
    pub(super) hits: Hits,
    /// What is not the traversal's: reading lists, shading, storing.
    pub(super) pass: Pass,
    /// Whether it also keeps what each ray cost.
    pub(super) maps: Maps,
}

/// What a piece of a list comes to.
pub(super) struct OfPiece {
    /// By place, what its ray hit.
    pub(super) hits: Vec<u32>,
    pub(super) costs: Option<PieceCosts>,
}

/// The set of reflection rays in a list.
const REFLECTIONS: usize = 0;

impl RayPass<'_> {
    /// Whether reflection rays are traced here, and not only what follows from their hits.
    pub(super) fn traces_reflections(&self) -> bool {
        self.program.wanted()[REFLECTIONS]
    }

    /// The warps of one piece of the list, and what its rays come to.
    ///
    /// # Errors
    /// When the piece takes too many steps.
    pub(super) fn piece(&self, bench: &mut Bench, index: u32) -> Result<(TileStreams, OfPiece), Error> {
        let Bench { tile, stepper, emitter } = bench;
        let header = self.rays.header();
        self.rays.tile(index, tile)?;
        let rect = header.frame.tile(index);
        let hits = tile.ray_sets[REFLECTIONS].hits.clone();
        let wanted = self.program.wanted();
        let mut warps = Vec::new();
        let take = |warp: &WarpSteps| {
            let places = self.warp(emitter, warp, index * TILE_RAYS, &hits)?;
            if self.maps == Maps::Kept {
                let rays = places.iter().map(|place| place - index * TILE_RAYS);
                let slots = LaneSlots::of(warp, REFLECTIONS, &tile.ray_sets[REFLECTIONS], rays);
                warps.push((places, slots));
            }
            Ok(())
        };
        let tally = stepper
            .run(header, (self.walk, &wanted), self.lane_map, (tile, rect), take)
            .map_err(|problem| refuse(header, problem))?;
        let costs = (self.maps == Maps::Kept)
            .then(|| PieceCosts::new(per_ray(tile, self.program, rect.width * rect.height), warps));
        Ok((emitter.take(self.program, &tally, None), OfPiece { hits, costs }))
    }

    /// Answers the places of its rays.
    fn warp(
        &self,
        emitter: &mut Emitter,
        warp: &WarpSteps,
        first: u32,
        hits: &[u32],
    ) -> Result<Vec<u32>, String> {
        let Self { program, prices, lists, rays, pass, shaders, .. } = self;
        let with_rays = || warp.rays.iter().copied().filter(|&ray| ray != HELPER);
        let places: Vec<u32> =
            with_rays().map(|ray| first + ray).filter(|&place| rays.pixel(place).is_some()).collect();
        self.begin(emitter, warp, &places, first);
        let lanes: Vec<u32> = self.pipeline.map_or_else(Vec::new, |_| self.lanes(warp, first));
        if let Some(pipeline) = self.pipeline {
            pipeline.before_trace(self, emitter, &lanes);
        }
        emitter.trace_rays(program, warp)?;
        if !places.is_empty() {
            let hit_by: Vec<u32> = places.iter().map(|&place| hits[(place - first) as usize]).collect();
            match self.hits {
                Hits::Shaded => {
                    let shader = |&triangle: &u32| (triangle < NOT_CAST).then(|| shaders[triangle as usize]);
                    let hits: Vec<Option<u32>> = hit_by.iter().map(shader).collect();
                    match self.pipeline {
                        None => self.shade(emitter, &hits),
                        Some(pipeline) => pipeline.shade(self, emitter, &lanes, &hits),
                    }
                    let colour = (BufferKind::Image, true, PIXEL_BYTES as u32);
                    let pixels = places.iter().filter_map(|&place| rays.pixel(place));
                    let addresses =
                        pixels.map(|pixel| lists.output.address(pixel % self.width, pixel / self.width));
                    emitter.access(program, *pass, colour, addresses);
                    program.spend(prices.store_colour(), 1, places.len() as u64, emitter.issue(*pass));
                }
                Hits::Kept => {
                    let write = |emitter: &mut Emitter, address: fn(&Lists, u32) -> u64, bytes: u64| {
                        self.records(
                            emitter,
                            true,
                            bytes,
                            &places.iter().map(|&place| address(lists, place)),
                        );
                    };
                    write(emitter, Lists::hit, HIT_BYTES);
                    write(emitter, Lists::id, ID_BYTES);
                    write(emitter, Lists::position, POSITION_BYTES);
                    program.spend(prices.write_hit(), 1, places.len() as u64, emitter.issue(*pass));
                }
            }
            emitter.end_turn(program, *pass, false);
        }
        emitter.end_warp(program);
        Ok(places)
    }

    /// Up to where the warp has its rays.
    fn begin(&self, emitter: &mut Emitter, warp: &WarpSteps, places: &[u32], first: u32) {
        let Self { program, prices, lists, pass, .. } = self;
        let lanes = places.len() as u64;
        match &self.from {
            From::Pixels(march, pixels) => {
                let pixels: Vec<u32> = warp
                    .rays
                    .iter()
                    .map(|&ray| if ray == HELPER { HELPER } else { pixels[(first + ray) as usize] })
                    .collect();
                march.look_up(emitter, &pixels);
            }
            _ if places.is_empty() => {}
            From::List => {
                self.records(emitter, false, RAY_BYTES, &places.iter().map(|&place| lists.ray(place)));
                emitter.end_turn(program, *pass, true);
                program.spend(prices.read_ray(), 1, lanes, emitter.issue(*pass));
            }
            From::Sorted(order) => {
                let sorted = |place: &u32| lists.sorted(order[*place as usize][0]);
                let of = |place: &u32| order[*place as usize][1];
                self.records(emitter, false, ID_BYTES, &places.iter().map(sorted));
                emitter.end_turn(program, *pass, true);
                self.records(emitter, false, HIT_BYTES, &places.iter().map(|place| lists.hit(of(place))));
                self.records(
                    emitter,
                    false,
                    POSITION_BYTES,
                    &places.iter().map(|place| lists.position(of(place))),
                );
                emitter.end_turn(program, *pass, true);
                program.spend(prices.read_hit(), 1, lanes, emitter.issue(*pass));
            }
        }
    }

    /// The lanes of a warp that have a ray.
    fn lanes(&self, warp: &WarpSteps, first: u32) -> Vec<u32> {
        let has_ray = |ray: u32| ray != HELPER && self.rays.pixel(first + ray).is_some();
        (0..).zip(&warp.rays).filter(|&(_, &ray)| has_ray(ray)).map(|(lane, _)| lane).collect()
    }

    /// A switch over the shaders of a warp's hits, `None` of a miss: each is executed for its own lanes alone.
    pub(super) fn shade(&self, emitter: &mut Emitter, hits: &[Option<u32>]) {
        let Self { program, prices, lists, pass, .. } = self;
        let of_hits: Vec<u32> = hits.iter().flatten().copied().collect();
        let misses = hits.len() - of_hits.len();
        if misses > 0 {
            program.spend(prices.sky(), 1, misses as u64, emitter.issue(*pass));
        }
        if of_hits.is_empty() {
            return;
        }
        self.records(emitter, false, MATERIAL_BYTES, &of_hits.iter().map(|&shader| lists.material(shader)));
        emitter.end_turn(program, *pass, true);
        let mut distinct = of_hits.clone();
        distinct.sort_unstable();
        distinct.dedup();
        for shader in distinct {
            let lanes = of_hits.iter().filter(|&&of_hit| of_hit == shader).count() as u64;
            program.spend(prices.material(shader), 1, lanes, emitter.issue(*pass));
        }
    }

    /// Loads or stores of records of so many bytes, at most 16 at a time.
    pub(super) fn records(
        &self,
        emitter: &mut Emitter,
        write: bool,
        bytes: u64,
        addresses: &(impl Iterator<Item = u64> + Clone),
    ) {
        for offset in (0..bytes).step_by(LOAD_BYTES as usize) {
            let of_load = LOAD_BYTES.min(bytes - offset) as u32;
            let addresses = addresses.clone().map(|address| address + offset);
            emitter.access(self.program, self.pass, (BufferKind::Record, write, of_load), addresses);
        }
    }
}
