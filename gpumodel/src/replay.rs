//! From a trace to a frame's counters.
//!
//! Tiles are replayed in parallel, in batches that bound the memory; the interleavers take one batch in order while the
//! next is made. The order of accesses depends on the tiles alone, so the counters do not depend on the threads.
//!
//! Variants of a frame (layouts, techniques, GPUs) are replayed side by side.

use crate::config::{EnergyTable, Gpu, ShaderCosts, Technique};
use crate::counters::{FrameCounters, HeatMap, HeatMaps, Pass, PassCounters};
use crate::engine::{Engine, Finished};
use crate::error::Error;
use crate::geometry;
use crate::layout::{BufferBytes, Buffers, NodeOrder, NodeRecords, PrimitiveLayout, PrimitiveOrder};
use crate::prepared::Prepared;
use crate::schedule::{HELPER, LaneMap};
use crate::timed::TimedFrame;
use crate::warp::{Emitter, TileStreams, TreeTurns};
use crate::windows::PhaseWindows;
use crate::workshop::{MadeTile, VariantTile, Workshop};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use tracer::{Frame, TileDraw, TileRect, TileSource, TraceHeader};

/// Tiles of a batch per thread.
const TILES_PER_THREAD: u32 = 16;

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
    /// What events take.
    pub energy: EnergyTable,
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
    /// Warps that a core holds at once, by [`Pass`].
    pub resident_warps: [u32; Pass::COUNT],
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
    let prepared =
        configs.iter().map(|config| Prepared::new(source, config)).collect::<Result<Vec<_>, _>>()?;
    let header = source.header();
    let workshop = Workshop::new(header, &prepared.iter().collect::<Vec<_>>(), maps);
    let variants = prepared.into_iter().map(|prepared| Variant::new(header.frame, prepared, maps));
    let mut variants = variants.collect::<Result<Vec<_>, _>>()?;

    let tiles = header.frame.tiles();
    let done = AtomicU64::new(0);
    let make = |index: u32| {
        let made = workshop.tile(source, index)?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(tiles));
        Ok(made)
    };

    let batch_tiles = TILES_PER_THREAD * rayon::current_num_threads() as u32;
    let mut batch: Vec<MadeTile> = Vec::new();
    let mut draws: Vec<Vec<TileDraw>> = Vec::new();
    let mut next = 0;
    while next < tiles || !batch.is_empty() {
        draws.extend(batch.iter_mut().map(|tile| std::mem::take(&mut tile.draws)));
        let indices = next..next.saturating_add(batch_tiles).min(tiles);
        next = indices.end;
        let mut made: Vec<Option<Result<MadeTile, Error>>> = indices.clone().map(|_| None).collect();
        // First in, first out: the variants are the long jobs, and tiles fill what time they leave.
        rayon::scope_fifo(|scope| {
            for (index, variant) in variants.iter_mut().enumerate() {
                let batch = &batch;
                scope.spawn_fifo(move |_| {
                    for tile in batch {
                        variant.take(tile.rect, &tile.variants[index]);
                    }
                });
            }
            for (index, place) in indices.zip(&mut made) {
                let make = &make;
                scope.spawn_fifo(move |_| *place = Some(make(index)));
            }
        });
        batch = made.into_iter().map(|made| made.expect("the scope has ended")).collect::<Result<_, _>>()?;
    }
    variants.into_par_iter().map(|variant| variant.finish(source, &draws)).collect()
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
    prepared: Prepared<'a>,
    engine: Engine,
    counters: FrameCounters,
    maps: Option<HeatMaps>,
}

impl<'a> Variant<'a> {
    fn new(frame: Frame, prepared: Prepared<'a>, maps: Maps) -> Result<Self, Error> {
        let engine = prepared.engine(maps)?;
        let empty = || empty_map(frame);
        let maps = (maps == Maps::Kept).then(|| HeatMaps {
            node_fetches: empty(),
            loaded_bytes: empty(),
            warp_misses: empty(),
            wasted_slots: prepared.walk.in_lockstep().then(empty),
        });
        Ok(Self { prepared, engine, counters: FrameCounters::default(), maps })
    }

    /// Takes the next tile of the traced pass.
    fn take(&mut self, rect: TileRect, tile: &VariantTile) {
        add_issue(&mut self.counters, &tile.streams);
        if let Some(maps) = &mut self.maps {
            paint(&mut maps.node_fetches, rect, &tile.node_fetches);
            paint(&mut maps.loaded_bytes, rect, &tile.loaded_bytes);
            if let Some(map) = &mut maps.wasted_slots {
                paint(map, rect, &tile.wasted_slots);
            }
        }
        self.engine.push(&tile.streams);
        self.engine.run_ahead();
    }

    fn finish<S: TileSource>(mut self, source: &S, draws: &[Vec<TileDraw>]) -> Result<Replayed, Error> {
        let header = source.header();
        let frame = header.frame;
        self.engine.drain(Pass::Primary);
        if let Some(maps) = &mut self.maps {
            let lane_map = &self.prepared.lane_map;
            paint_warps(&mut maps.warp_misses, frame, lane_map, self.engine.misses_by_warp());
        }
        if let Some(raster) = self.prepared.config.technique.raster {
            let Self { prepared: Prepared { config, program, .. }, engine, counters, .. } = &mut self;
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
        if self.prepared.config.technique.present.is_some() {
            present(&self.prepared, frame, &mut self.engine, &mut self.counters);
        }
        let Self { prepared: Prepared { program, resident_warps, .. }, engine, mut counters, maps } = self;
        let Finished { traffic, flush, schedule, phases, timed } = engine.finish();
        for (pass, traffic) in counters.passes.iter_mut().zip(traffic) {
            pass.traffic = traffic;
        }
        counters.flush = flush;
        counters.schedule = schedule;
        counters.stalls = source.stalls();
        let Buffers { structure_bytes, sizes: buffers, .. } = program.buffers;
        let resident_warps = [resident_warps; Pass::COUNT];
        Ok(Replayed { counters, maps, structure_bytes, buffers, resident_warps, phases, timed })
    }
}

/// The full-screen quad that draws the image of a compute stage.
pub(crate) fn present(
    Prepared { config, program, .. }: &Prepared<'_>,
    frame: Frame,
    engine: &mut Engine,
    counters: &mut FrameCounters,
) {
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

fn empty_map(frame: Frame) -> HeatMap {
    let (width, height) = match frame {
        Frame::Image { width, height } => (width, height),
        Frame::List { rays } => (rays, 1),
    };
    HeatMap { width, height, values: vec![0; frame.rays() as usize] }
}

pub(crate) fn add_issue(counters: &mut FrameCounters, TileStreams { tree, own }: &TileStreams) {
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
