//! The dispatches of a frame, one after the other.

use super::listing::Listing;
use super::lists::Lists;
use super::maps::MapPainter;
use super::march::MarchPass;
use super::pipeline::Pipeline;
use super::prices::Prices;
use super::rays::{From, Hits, OfPiece, RayPass};
use super::sort::SortPass;
use super::{ReflectionFrame, ReplayedReflections, Shadows, Technique, size};
use crate::config::{Atomics, HitShading, Launch, ReflectionRegisters, ScreenSpace};
use crate::counters::{FrameCounters, Pass};
use crate::dispatch::{Benches, Running, resident_warps};
use crate::engine::Engine;
use crate::error::Error;
use crate::interleave::KindPaths;
use crate::lanes::Lanes;
use crate::layout::{BufferBytes, Buffers, Places};
use crate::ordering::{AtomicTally, Bucket, BucketSort, Sorted, bucket_of};
use crate::prepared::{caches, registers};
use crate::replay::{Maps, ReplayConfig, Replayed};
use crate::schedule::LaneMap;
use crate::warp::{Program, Walk};
use tracer::reflections::{NO_RAY, ReflectionList};
use tracer::{Frame, NOT_CAST, RayKind, RaySetId, TILE_RAYS, TraceHeader};

/// A frame of reflections on its way through a GPU.
pub(super) struct Replay<'a, 'f> {
    frame: &'a ReflectionFrame<'f>,
    config: &'a ReplayConfig,
    technique: &'a Technique,
    prices: Prices<'a>,
    atomics: &'a Atomics,
    lanes: Lanes,
    /// Whose shaders shade hits, in a technique of one.
    pipeline: Option<Pipeline>,
    benches: Benches,
    maps: Maps,
}

/// What a list of rays is traced with.
struct Tracing<'a> {
    rays: Box<dyn ReflectionList + 'a>,
    program: Program,
    walk: Walk,
    lane_map: LaneMap,
    paths: KindPaths,
    /// Of a core.
    warps: u32,
}

impl<'a, 'f> Replay<'a, 'f> {
    pub(super) fn new(
        frame: &'a ReflectionFrame<'f>,
        config: &'a ReplayConfig,
        technique: &'a Technique,
        (prices, atomics): (Prices<'a>, &'a Atomics),
        maps: Maps,
    ) -> Self {
        let warp_width = config.gpu.cores.warp_width;
        let lanes = Lanes::new(size(frame.reflections), technique.workgroup, warp_width);
        let pipeline = Pipeline::of(technique, &config.gpu, prices.costs.pipeline, shaders(frame));
        let benches = Benches::default();
        Self { frame, config, technique, prices, atomics, lanes, pipeline, benches, maps }
    }

    pub(super) fn run(&self) -> Result<ReplayedReflections, Error> {
        let Self { frame, config, technique, lanes, .. } = self;
        let prices = self.prices;
        let march_warps = self.resident_warps(self.march_registers())?;
        let listing = Listing::new(frame, (technique, &prices, &config.gpu), lanes, march_warps)?;
        let sorts = technique.hit_shading == HitShading::VisibilityBuffer;
        let registers = &prices.costs.registers;
        let (shadows, shading, own) = match technique.hit_shading {
            HitShading::VisibilityBuffer => (Shadows::None, None, registers.query),
            HitShading::Uber | HitShading::Pipeline | HitShading::PipelineLibrary => {
                let of_pipeline = self.pipeline.map(|pipeline| pipeline.registers(registers.uber));
                (Shadows::Traced, Some(Pass::Reflection), of_pipeline.unwrap_or(registers.uber))
            }
        };
        // In one shader, the march is another part of it.
        let own = if technique.launch == Launch::Pixel { own.max(self.march_registers()) } else { own };
        let tracing = self.tracing(listing.order.clone(), shadows, (None, shading), own)?;
        let lists = self.lists(&tracing, sorts);
        let mut running = self.start(&tracing, &lists)?;
        let mut painter =
            (self.maps == Maps::Kept).then(|| MapPainter::new(frame, tracing.walk.in_lockstep()));
        let march = MarchPass {
            program: &tracing.program,
            technique,
            prices,
            frame: frame.reflections,
            lists: &lists,
            lanes,
        };
        let from = match technique.launch {
            Launch::Pixel => From::Pixels(&march, &lanes.pixels),
            Launch::Buffer => {
                self.march(&march, &listing, march_warps, &mut running)?;
                From::List
            }
        };
        let passes: &[Pass] = match technique.launch {
            Launch::Pixel => &[Pass::ScreenSpace, Pass::Reflection, Pass::ReflectionShadow],
            Launch::Buffer => &[Pass::Reflection, Pass::ReflectionShadow],
        };
        let hits = if sorts { Hits::Kept } else { Hits::Shaded };
        let pass = self.ray_pass(&tracing, &lists, (from, hits), Pass::Reflection);
        let hits = self.run_rays(&pass, passes, tracing.warps, (&mut running, &mut painter))?;
        if let Some(painter) = &mut painter {
            painter.hits(&pass, &hits);
        }
        let (width, height) = size(frame.reflections);
        let frame = Frame::Image { width, height };
        let mut header = TraceHeader { frame, ..tracing.rays.header().clone() };
        if sorts {
            header.ray_sets =
                self.shade_by_material(&listing, &hits, &lists, (&mut running, &mut painter))?;
        }
        running.counters.materials = shaders(self.frame);
        running.counters.stalls = tracing.rays.stalls();
        let (maps, heat) = painter.map(MapPainter::finish).unzip();
        let replayed = Replayed { maps: heat, ..Self::finish(&tracing, &lists, running) };
        Ok(ReplayedReflections { replayed, header, maps })
    }

    /// Warps that a core holds of a shader with so many registers.
    fn resident_warps(&self, registers: u32) -> Result<u32, Error> {
        resident_warps(&self.config.gpu, registers, &self.config.technique.name)
    }

    fn march_registers(&self) -> u32 {
        let ReflectionRegisters { march, hierarchical, .. } = self.prices.costs.registers;
        if self.technique.screen_space == ScreenSpace::Hierarchical { hierarchical } else { march }
    }

    /// Rays of an order. Those of a kind may be `known` from a pass before; what reflection rays hit is shaded in the pass `shading`, if at all.
    fn tracing(
        &self,
        order: Vec<u32>,
        shadows: Shadows,
        (known, shading): (Option<RayKind>, Option<Pass>),
        own_registers: u32,
    ) -> Result<Tracing<'f>, Error> {
        let Self { frame, config, .. } = self;
        let gpu = &config.gpu;
        let rays = (frame.list)(order, shadows)?;
        let header = rays.header();
        let warps = self.resident_warps(registers(header, config)?.max(own_registers))?;
        let (hierarchy, paths) = caches(gpu, gpu.ray_unit_for(header).is_some())?;
        let lines = [paths.traversal, paths.private].map(|path| hierarchy.granule(path));
        let mut buffers = Buffers::new(&*rays, config, gpu.cores.count * warps, lines[0], lines[1])?;
        if let Some(pipeline) = &self.pipeline {
            buffers.add_call_frames(pipeline.stack_bytes(), gpu.cores.count * warps, lines[1]);
        }
        let program = Program::new(header, rays.topology(), buffers, config)?.over_list(known, shading);
        let walk = Walk::new(header, rays.topology(), config);
        let lane_map = LaneMap::new(gpu, header.frame, config.technique.stage);
        Ok(Tracing { program, walk, lane_map, paths, warps, rays })
    }

    fn lists(&self, tracing: &Tracing<'_>, by_material: bool) -> Lists {
        let Self { frame, technique, .. } = self;
        let levels: Vec<(u32, u32)> = match frame.reflections.depth() {
            Some(depth) if technique.screen_space == ScreenSpace::Hierarchical => {
                (0..depth.levels()).map(|level| depth.size(level).into()).collect()
            }
            _ => vec![size(frame.reflections)],
        };
        let rays = frame.reflections.rays().len() as u32;
        let lists = (by_material, self.pipeline.map_or(0, |pipeline| pipeline.record_bytes()));
        Lists::new(tracing.program.buffers.end, &levels, rays, shaders(frame), lists)
    }

    /// Empty cores and cold caches.
    fn start(&self, tracing: &Tracing<'_>, lists: &Lists) -> Result<Running, Error> {
        let Self { config, maps, .. } = self;
        let Tracing { program, paths, warps, rays, .. } = tracing;
        let (hierarchy, _) = caches(&config.gpu, config.gpu.ray_unit_for(rays.header()).is_some())?;
        let places = Places { end: lists.end, ..program.buffers.places() };
        let engine = Engine::new(config.fidelity, &config.gpu, hierarchy, *paths, places, *warps, *maps)?;
        Ok(Running { engine, counters: FrameCounters::default(), resident_warps: [*warps; Pass::COUNT] })
    }

    /// The dispatch that marches, and lists the rays that are left.
    fn march(
        &self,
        march: &MarchPass<'_>,
        listing: &Listing,
        warps: u32,
        running: &mut Running,
    ) -> Result<(), Error> {
        let Self { lanes, benches, .. } = self;
        let piece = lanes.group * (TILE_RAYS as usize).div_ceil(lanes.group);
        let pieces = lanes.pixels.len().div_ceil(piece) as u32;
        let make = |index: u32| {
            benches.with(|bench| {
                let emitter = &mut bench.emitter;
                let start = index as usize * piece;
                let end = lanes.pixels.len().min(start + piece);
                for first in (start..end).step_by(lanes.warp) {
                    march.look_up(emitter, &lanes.pixels[first..first + lanes.warp]);
                    march.list(emitter, first, listing);
                    emitter.end_warp(march.program);
                }
                Ok((emitter.take(march.program, &Default::default(), None), ()))
            })
        };
        running.dispatch(&[Pass::ScreenSpace], warps, pieces, make, |()| {})?;
        let Listing { compacted, .. } = listing;
        // Each add is followed by a maximum, for the size of the next dispatch.
        for _ in ["add", "maximum"] {
            self.count_atomics(march.program, running, Pass::ScreenSpace, compacted.global);
        }
        let issue = &mut running.counters.passes[Pass::ScreenSpace as usize].issue;
        let clocks = compacted.shared.atomics as f64 * self.atomics.shared_lane_clocks;
        issue.load_store_cycles += clocks.round() as u64;
        self.spend_trips(march.program, running, Pass::ScreenSpace, compacted.shared);
        Ok(())
    }

    fn count_atomics(&self, program: &Program, running: &mut Running, pass: Pass, tally: AtomicTally) {
        let Atomics { lane_clocks, warp_clocks, joins_uniform, .. } = *self.atomics;
        let reaching = tally.reaching_memory(joins_uniform);
        let clocks = reaching as f64 * lane_clocks + tally.instructions as f64 * warp_clocks;
        let issue = &mut running.counters.passes[pass as usize].issue;
        issue.atomics += reaching;
        issue.atomic_clocks += clocks.round() as u64;
        self.spend_trips(program, running, pass, tally);
    }

    /// What warps issue for the loops around their atomics, in which all of their lanes take part.
    fn spend_trips(&self, program: &Program, running: &mut Running, pass: Pass, tally: AtomicTally) {
        let trip = self.prices.atomic_trip(self.technique.atomics);
        let lanes = tally.instructions * self.lanes.warp as u64;
        program.spend(trip, tally.instructions, lanes, &mut running.counters.passes[pass as usize].issue);
    }

    fn ray_pass<'b>(
        &'b self,
        tracing: &'b Tracing<'f>,
        lists: &'b Lists,
        (from, hits): (From<'b>, Hits),
        pass: Pass,
    ) -> RayPass<'b> {
        let Self { frame, maps, .. } = self;
        let Tracing { program, walk, lane_map, rays, .. } = tracing;
        RayPass {
            program,
            walk,
            lane_map,
            prices: self.prices,
            lists,
            rays: &**rays,
            width: size(frame.reflections).0,
            shaders: frame.shaders,
            from,
            pipeline: self.pipeline.as_ref(),
            hits,
            pass,
            maps: *maps,
        }
    }

    /// What each place's ray hit.
    fn run_rays(
        &self,
        pass: &RayPass<'_>,
        passes: &[Pass],
        warps: u32,
        (running, painter): (&mut Running, &mut Option<MapPainter>),
    ) -> Result<Vec<u32>, Error> {
        let (mut hits, mut costs) = (Vec::new(), Vec::new());
        let pieces = pass.rays.header().frame.tiles();
        let make = |index: u32| self.benches.with(|bench| pass.piece(bench, index));
        let before = running.engine.misses_by_warp().len();
        running.dispatch(passes, warps, pieces, make, |of_piece: OfPiece| {
            hits.extend(of_piece.hits);
            costs.extend(of_piece.costs);
        })?;
        if let Some(painter) = painter {
            painter.costs(pass, &costs, &running.engine.misses_by_warp()[before..]);
        }
        Ok(hits)
    }

    /// Count, offset, copy; then a dispatch for each material, and one for the misses. Answers the ray sets of the frame.
    fn shade_by_material(
        &self,
        listing: &Listing,
        hits: &[u32],
        lists: &Lists,
        (running, painter): (&mut Running, &mut Option<MapPainter>),
    ) -> Result<Vec<RaySetId>, Error> {
        let Self { frame, config, technique, lanes, benches, .. } = self;
        let gpu = &config.gpu;
        let shader = |&triangle: &u32| (triangle < NOT_CAST).then(|| frame.shaders[triangle as usize]);
        let elements: Vec<u32> = hits.iter().map(|hit| bucket_of(shader(hit))).collect();
        let buckets = shaders(frame) + 1;
        let sort = BucketSort {
            buckets,
            warp_width: gpu.cores.warp_width as usize,
            consumer: lanes.group as u32,
            strategy: technique.atomics,
        };
        // Lanes of these passes all do the same: they come in their order.
        let offsets: Vec<usize> = (0..buckets as usize).collect();
        let copies: Vec<usize> = (0..sort.warps(elements.len())).collect();
        let sorted = sort.run(&elements, &offsets, &copies)?;
        let mut places = vec![0; elements.len()];
        (0..).zip(&sorted.order).for_each(|(place, &element)| places[element] = place);

        let padded = padded(&sorted, lanes.group as u32);
        let order =
            padded.iter().map(|place| place.map_or(NO_RAY, |[_, element]| listing.order[element as usize]));
        let known = Some(RayKind::Reflection);
        let tracing = self.tracing(
            order.collect(),
            Shadows::Traced,
            (known, Some(Pass::HitShading)),
            self.prices.costs.registers.shade,
        )?;
        let pass = SortPass {
            program: &tracing.program,
            prices: self.prices,
            lists,
            warp: sort.warp_width,
            elements: &elements,
            buckets,
            places: &places,
        };
        let warps = self.resident_warps(self.prices.costs.registers.sort)?;
        for of_elements in [Pass::BucketCount, Pass::BucketOffset, Pass::BucketCopy] {
            let (pieces, atomics) = match of_elements {
                Pass::BucketOffset => (1, self.adds_of_offsets(buckets)),
                _ => (pass.pieces(), sorted.atomics),
            };
            let make = |index: u32| {
                benches.with(|bench| {
                    let streams = match of_elements {
                        Pass::BucketOffset => pass.offsets(&mut bench.emitter),
                        _ => pass.piece(&mut bench.emitter, of_elements, index),
                    };
                    Ok((streams, ()))
                })
            };
            running.dispatch(&[of_elements], warps, pieces, make, |()| {})?;
            self.count_atomics(&tracing.program, running, of_elements, atomics);
        }

        let sorted_places: Vec<[u32; 2]> = padded.iter().map(|place| place.unwrap_or_default()).collect();
        let shading =
            self.ray_pass(&tracing, lists, (From::Sorted(&sorted_places), Hits::Shaded), Pass::HitShading);
        self.run_rays(
            &shading,
            &[Pass::HitShading, Pass::ReflectionShadow],
            tracing.warps,
            (running, painter),
        )?;
        Ok(tracing.rays.header().ray_sets.clone())
    }

    /// Every bucket adds its size to one counter.
    fn adds_of_offsets(&self, buckets: u32) -> AtomicTally {
        let warps = u64::from(buckets.div_ceil(self.config.gpu.cores.warp_width));
        let buckets = u64::from(buckets);
        AtomicTally { instructions: warps, counters: warps, atomics: buckets, joined: buckets }
    }

    fn finish(tracing: &Tracing<'_>, lists: &Lists, running: Running) -> Replayed {
        let Buffers { structure_bytes, sizes, .. } = tracing.program.buffers;
        let buffers = BufferBytes { image: lists.image_bytes, record: lists.record_bytes, ..sizes };
        running.finish(structure_bytes, buffers)
    }
}

/// Shaders of the scene's materials.
fn shaders(frame: &ReflectionFrame<'_>) -> u32 {
    frame.shaders.iter().max().map_or(0, |&last| last + 1)
}

/// By lane of the dispatches over buckets, one after the other and each of whole workgroups: the place in the sorted list and the element there.
fn padded(sorted: &Sorted, group: u32) -> Vec<Option<[u32; 2]>> {
    let mut lanes = Vec::new();
    for &Bucket { start, size, .. } in &sorted.buckets {
        lanes.extend((start..start + size).map(|place| Some([place, sorted.order[place as usize] as u32])));
        lanes.resize(lanes.len().next_multiple_of(group as usize), None);
    }
    lanes
}
