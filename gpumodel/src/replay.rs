//! From a trace to a frame's counters.
//!
//! Tiles are replayed in parallel, in batches that bound the memory; the interleavers take one batch in order while the
//! next is made. The order of accesses depends on the tiles alone, so the counters do not depend on the threads.
//!
//! Variants of a frame (layouts, techniques, GPUs) are replayed side by side: a tile is decoded once, run in lockstep once for all
//! variants whose warps have the same shape, and what these read of the tree is listed once for all to which it lies the same.

use crate::config::{Gpu, ShaderCosts, Technique};
use crate::counters::{FrameCounters, HeatMap, HeatMaps, Pass, PassCounters};
use crate::engine::{Engine, Finished};
use crate::error::Error;
use crate::geometry;
use crate::interleave::KindPaths;
use crate::layout::{BufferBytes, Buffers, NodeOrder, NodeRecords, PrimitiveLayout, PrimitiveOrder};
use crate::schedule::{HELPER, LaneMap, resident_warps};
use crate::timed::TimedFrame;
use crate::warp::{Emitter, Program, Stepper, TileStreams, TreeTurns};
use crate::windows::PhaseWindows;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tracer::{Frame, Tile, TileDraw, TileRect, TileSource, TraceHeader};

/// Tiles of a batch per thread.
const TILES_PER_THREAD: u32 = 4;

/// How time is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Fidelity {
    /// Warps take turns; time comes from what they ask of each resource.
    #[default]
    Replay,
    /// Warps, caches and memory are simulated event by event.
    Timed,
}

impl Fidelity {
    /// All, the quickest first.
    pub const ALL: [Self; 2] = [Self::Replay, Self::Timed];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Replay => "replay",
            Self::Timed => "timed",
        }
    }

    /// The rung of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|fidelity| fidelity.name() == name)
    }
}

/// What a trace is replayed on.
#[derive(Clone, Debug)]
pub struct ReplayConfig {
    /// The machine.
    pub gpu: Gpu,
    /// The shader.
    pub costs: ShaderCosts,
    /// The passes.
    pub technique: Technique,
    /// How triangles lie in memory.
    pub primitive_layout: PrimitiveLayout,
    /// Where the triangles of a leaf lie; `None` for what the structure uses, [`PrimitiveOrder::of`].
    pub primitive_order: Option<PrimitiveOrder>,
    /// What a node record holds.
    pub node_records: NodeRecords,
    /// In which order nodes lie in memory.
    pub node_order: NodeOrder,
    /// How time is found.
    pub fidelity: Fidelity,
    /// Every request to memory is kept, 24 bytes each; on the rung [`Fidelity::Timed`].
    pub keeps_misses: bool,
}

/// A frame's counts.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// All sums.
    pub counters: FrameCounters,
    /// What each pixel cost, where it was asked for.
    pub maps: Option<HeatMaps>,
    /// Bytes of the tree's node records.
    pub structure_bytes: u64,
    /// Bytes of all buffers.
    pub buffers: BufferBytes,
    /// Warps that a core holds at once.
    pub resident_warps: u32,
    /// What happened when; empty where time was simulated.
    pub phases: Vec<PhaseWindows>,
    /// When what happened, where it was asked for.
    pub timed: Option<TimedFrame>,
}

/// Whether a replay also keeps what each pixel cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maps {
    /// It does, at some cost in time.
    Kept,
    /// It does not.
    Dropped,
}

/// Replays all tiles of `source`; `progress` hears how many of how many are done.
///
/// # Errors
/// When the trace contradicts itself, holds steps that no modelled shader takes, or cannot be read.
pub fn replay<S: TileSource>(
    source: &S,
    config: &ReplayConfig,
    maps: Maps,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Replayed, Error> {
    let mut replayed = replay_all(source, std::slice::from_ref(config), maps, progress)?;
    Ok(replayed.remove(0))
}

/// Replays all tiles of `source` on each of `configs`; as [`replay`] for each, in less time.
///
/// # Errors
/// As [`replay`].
pub fn replay_all<S: TileSource>(
    source: &S,
    configs: &[ReplayConfig],
    maps: Maps,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Vec<Replayed>, Error> {
    let header = source.header();
    let mut variants =
        configs.iter().map(|config| Variant::new(source, config, maps)).collect::<Result<Vec<_>, _>>()?;
    let workshop = Workshop::new(header, &variants, maps);

    let tiles = header.frame.tiles();
    let done = AtomicU64::new(0);
    // Benches outlast a batch, so that their memory grows to the size of a tile but once.
    let benches: Mutex<Vec<Bench>> = Mutex::new(Vec::new());
    let make = |batch: Range<u32>| -> Result<Vec<MadeTile>, Error> {
        let free = || benches.lock().unwrap_or_else(PoisonError::into_inner);
        let one = |index: u32| {
            let bench = free().pop();
            let mut bench = bench.unwrap_or_else(|| workshop.bench());
            let made = workshop.tile(source, &mut bench, index)?;
            free().push(bench);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(tiles));
            Ok(made)
        };
        batch.into_par_iter().map(one).collect()
    };

    let batch_tiles = TILES_PER_THREAD * rayon::current_num_threads() as u32;
    let mut batch = make(0..batch_tiles.min(tiles))?;
    let mut next = batch_tiles.min(tiles);
    let mut draws: Vec<Vec<TileDraw>> = Vec::new();
    while !batch.is_empty() {
        let end = next.saturating_add(batch_tiles).min(tiles);
        let (made, ()) = rayon::join(
            || make(next..end),
            || {
                variants.par_iter_mut().enumerate().for_each(|(index, variant)| {
                    for tile in &batch {
                        variant.take(tile.rect, &tile.variants[index]);
                    }
                });
                draws.extend(batch.iter_mut().map(|tile| std::mem::take(&mut tile.draws)));
            },
        );
        batch = made?;
        next = end;
    }
    variants.into_par_iter().map(|variant| variant.finish(source, &draws)).collect()
}

/// What a tile is on one variant.
struct VariantTile {
    streams: TileStreams,
    /// Per ray of the tile, where maps are kept.
    node_fetches: Vec<u32>,
    loaded_bytes: Vec<u32>,
}

struct MadeTile {
    rect: TileRect,
    draws: Vec<TileDraw>,
    /// By variant.
    variants: Vec<VariantTile>,
}

/// What all threads need to make tiles for all variants.
struct Workshop<'a> {
    header: &'a TraceHeader,
    programs: Vec<Arc<Program>>,
    /// Variants whose warps have the same shape share a lane map.
    shapes: Vec<Shape>,
    maps: Maps,
    /// Some variant rasterises the geometry.
    rasters: bool,
}

struct Shape {
    lane_map: LaneMap,
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
    fn new(header: &'a TraceHeader, variants: &[Variant<'_>], maps: Maps) -> Self {
        let mut shapes: Vec<Shape> = Vec::new();
        for (index, variant) in variants.iter().enumerate() {
            let wanted = variant.program.wanted();
            let sharer = |earlier: &[Sharer]| {
                let alike = |other: &&Sharer| variant.program.reads_tree_as(&variants[other.variant].program);
                let leads = |other: &&Sharer| other.tree_of.is_none();
                let tree_of = earlier.iter().filter(leads).find(alike).map(|leader| leader.variant);
                Sharer { variant: index, tree_of }
            };
            match shapes.iter_mut().find(|shape| shape.lane_map == variant.lane_map) {
                Some(shape) => {
                    let sharer = sharer(&shape.variants);
                    shape.variants.push(sharer);
                    shape.wanted.iter_mut().zip(wanted).for_each(|(any, this)| *any |= this);
                }
                None => {
                    let lane_map = variant.lane_map.clone();
                    shapes.push(Shape { lane_map, wanted, variants: vec![sharer(&[])] });
                }
            }
        }
        let programs = variants.iter().map(|variant| Arc::clone(&variant.program)).collect();
        let rasters = variants.iter().any(|variant| variant.config.technique.raster.is_some());
        Self { header, programs, shapes, maps, rasters }
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

    fn tile<S: TileSource>(&self, source: &S, bench: &mut Bench, index: u32) -> Result<MadeTile, Error> {
        let Bench { tile, stepper, emitters } = bench;
        source.tile(index, tile)?;
        let rect = self.header.frame.tile(index);
        check(self.header, tile, rect.width * rect.height)?;
        let mut streams: Vec<Option<TileStreams>> = self.programs.iter().map(|_| None).collect();
        for Shape { lane_map, wanted, variants } in &self.shapes {
            let emit = |warp: &crate::warp::WarpSteps| {
                variants.iter().try_for_each(|&Sharer { variant, .. }| {
                    emitters[variant].trace(&self.programs[variant], warp, index, rect)
                })
            };
            let tally = stepper
                .run(self.header, wanted, lane_map, (tile, rect), emit)
                .map_err(|problem| refuse(self.header, problem))?;
            for &Sharer { variant, tree_of } in variants {
                let tree = tree_of.and_then(|leader| streams[leader].as_ref()).map(|leader| &leader.tree);
                let taken = emitters[variant].take(&self.programs[variant], &tally, tree);
                streams[variant] = Some(taken);
            }
        }
        let streams = streams.into_iter().map(|streams| streams.expect("every variant is of some shape"));
        let variants = streams.zip(&self.programs).map(|(streams, program)| {
            let (node_fetches, loaded_bytes) = match self.maps {
                Maps::Kept => per_ray(tile, program, rect.width * rect.height),
                Maps::Dropped => (Vec::new(), Vec::new()),
            };
            VariantTile { streams, node_fetches, loaded_bytes }
        });
        let variants = variants.collect();
        let draws = if self.rasters { std::mem::take(&mut tile.draws) } else { Vec::new() };
        Ok(MadeTile { rect, draws, variants })
    }
}

/// Node records and bytes that each ray of a tile, and all rays that follow from it, read.
fn per_ray(tile: &Tile, program: &Program, rays: u32) -> (Vec<u32>, Vec<u32>) {
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

pub(crate) fn refuse(header: &TraceHeader, problem: impl Into<String>) -> Error {
    Error::Trace {
        scene: header.scene.clone(),
        problem: problem.into(),
        remedy: "record the trace again".to_owned(),
    }
}

/// A configuration at work.
struct Variant<'a> {
    config: &'a ReplayConfig,
    program: Arc<Program>,
    lane_map: LaneMap,
    engine: Engine,
    resident_warps: u32,
    counters: FrameCounters,
    maps: Option<HeatMaps>,
}

impl<'a> Variant<'a> {
    fn new<S: TileSource>(source: &S, config: &'a ReplayConfig, maps: Maps) -> Result<Self, Error> {
        let header = source.header();
        if config.technique.raster.is_some() {
            geometry::check(header)?;
        }
        let gpu = &config.gpu;
        let resident_warps = resident_warps(gpu, registers(header, config)?, header)?;
        let refused = |error: cachesim::Error| Error::Config {
            file: gpu.name().to_owned(),
            line: None,
            key: "paths: ".to_owned(),
            problem: error.to_string(),
            remedy: "correct [paths]".to_owned(),
        };
        let (hierarchy, ids) = gpu.hierarchy().map_err(refused)?;
        let paths = KindPaths::new(&ids);
        let buffers = Buffers::new(
            source,
            config,
            gpu.cores.count * resident_warps,
            hierarchy.granule(paths.ssbo),
            hierarchy.granule(paths.private),
        )?;
        let mut engine =
            Engine::new(config.fidelity, gpu, hierarchy, paths, buffers.places(), resident_warps, maps)?;
        if config.keeps_misses {
            engine.keep_misses();
        }
        let program = Arc::new(Program::new(header, buffers, config)?);
        let lane_map = LaneMap::new(gpu, header.frame, config.technique.stage);
        let empty = || empty_map(header.frame);
        let maps = (maps == Maps::Kept).then(|| HeatMaps {
            node_fetches: empty(),
            loaded_bytes: empty(),
            warp_misses: empty(),
        });
        let counters = FrameCounters::default();
        Ok(Self { config, program, lane_map, engine, resident_warps, counters, maps })
    }

    /// Takes the next tile of the traced pass.
    fn take(&mut self, rect: TileRect, tile: &VariantTile) {
        add_issue(&mut self.counters, &tile.streams);
        if let Some(maps) = &mut self.maps {
            paint(&mut maps.node_fetches, rect, &tile.node_fetches);
            paint(&mut maps.loaded_bytes, rect, &tile.loaded_bytes);
        }
        self.engine.push(&tile.streams);
        self.engine.run_ahead();
    }

    fn finish<S: TileSource>(mut self, source: &S, draws: &[Vec<TileDraw>]) -> Result<Replayed, Error> {
        let header = source.header();
        let frame = header.frame;
        self.engine.drain(Pass::Primary);
        if let Some(maps) = &mut self.maps {
            paint_warps(&mut maps.warp_misses, frame, &self.lane_map, self.engine.misses_by_warp());
        }
        if let Some(raster) = self.config.technique.raster {
            let Self { config, program, engine, counters, .. } = &mut self;
            let mut before = None;
            geometry::run(header, draws, config, raster, program, &mut |pass, streams| {
                if let Some(before) = before.replace(pass).filter(|&before| before != pass) {
                    engine.drain(before);
                }
                add_issue(counters, &streams);
                engine.push(&streams);
                engine.run_ahead();
            })?;
            engine.drain(Pass::Geometry);
        }
        if self.config.technique.present.is_some() {
            self.present(frame);
        }
        let Self { program, engine, resident_warps, mut counters, maps, .. } = self;
        let Finished { traffic, flush, schedule, phases, timed } = engine.finish();
        for (pass, traffic) in counters.passes.iter_mut().zip(traffic) {
            pass.traffic = traffic;
        }
        counters.flush = flush;
        counters.schedule = schedule;
        counters.stalls = source.stalls();
        let Buffers { structure_bytes, sizes: buffers, .. } = program.buffers;
        Ok(Replayed { counters, maps, structure_bytes, buffers, resident_warps, phases, timed })
    }

    /// The full-screen quad that draws the image of a compute stage.
    fn present(&mut self, frame: Frame) {
        let Self { config, program, engine, counters, .. } = self;
        let lane_map = LaneMap::new(&config.gpu, frame, crate::config::Stage::Fragment);
        let mut emitter = Emitter::new(TreeTurns::Joined);
        for index in 0..frame.tiles() {
            let rect = frame.tile(index);
            let (mut warps, mut lanes) = (0, 0);
            for rays in lane_map.warps(rect) {
                emitter.present(program, &rays, index, rect);
                warps += 1;
                lanes += rays.iter().filter(|&&ray| ray != HELPER).count() as u64;
            }
            let issue = emitter.issue(Pass::Present);
            program.spend(program.present, warps, lanes, issue);
            issue.output_bytes += lanes * u64::from(config.gpu.output.bytes_per_pixel);
            let streams = emitter.take(program, &Default::default(), None);
            add_issue(counters, &streams);
            engine.push(&streams);
            engine.run_ahead();
        }
        engine.drain(Pass::Present);
    }
}

/// Registers of four words per lane, those of a short stack among them.
fn registers(header: &TraceHeader, config: &ReplayConfig) -> Result<u32, Error> {
    let short_stack = (u64::from(header.short_stack) * 8).div_ceil(16);
    Ok(config.costs.traversal(header)?.registers.saturating_add(short_stack as u32))
}

fn empty_map(frame: Frame) -> HeatMap {
    let (width, height) = match frame {
        Frame::Image { width, height } => (width, height),
        Frame::List { rays } => (rays, 1),
    };
    HeatMap { width, height, values: vec![0; frame.rays() as usize] }
}

fn add_issue(counters: &mut FrameCounters, TileStreams { tree, own }: &TileStreams) {
    for stream in [tree, own] {
        for (sum, &issue) in counters.passes.iter_mut().zip(&stream.issue) {
            *sum += PassCounters { issue, ..PassCounters::default() };
        }
    }
}

fn paint(map: &mut HeatMap, rect: TileRect, values: &[u32]) {
    for (y, row) in (rect.y as usize..).zip(values.chunks_exact(rect.width as usize)) {
        let start = y * map.width as usize + rect.x as usize;
        map.values[start..start + row.len()].copy_from_slice(row);
    }
}

/// Gives every pixel the figure of its warp; `by_warp` is in the order of tiles and of their warps.
fn paint_warps(map: &mut HeatMap, frame: Frame, lane_map: &LaneMap, by_warp: &[u32]) {
    let mut figures = by_warp.iter();
    let mut values = Vec::new();
    for index in 0..frame.tiles() {
        let rect = frame.tile(index);
        values.clear();
        values.resize((rect.width * rect.height) as usize, 0);
        for (rays, &figure) in lane_map.warps(rect).zip(figures.by_ref()) {
            for ray in rays.into_iter().filter(|&ray| ray != HELPER) {
                values[ray as usize] = figure;
            }
        }
        paint(map, rect, &values);
    }
}
