//! From a trace to a frame's counters.
//!
//! Tiles are replayed in parallel, in batches that bound the memory; the interleaver takes one batch in order while the
//! next is made. Its order of accesses depends on the tiles alone, so the counters do not depend on the threads.

use crate::config::{Gpu, ShaderCosts};
use crate::counters::{FrameCounters, HeatMap, PassCounters};
use crate::error::Error;
use crate::interleave::{Interleaver, KindPaths};
use crate::layout::{Buffers, NodeOrder, PrimitiveLayout};
use crate::schedule::resident_warps;
use crate::warp::{Pass, Program, TileReplay, TileStream};
use cachesim::Hierarchy;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tracer::{Frame, Tile, TileRect, TileSource, TraceHeader};

/// Tiles of a batch per thread.
const TILES_PER_THREAD: u32 = 4;

/// What a trace is replayed on.
#[derive(Clone, Debug)]
pub struct ReplayConfig {
    /// The machine.
    pub gpu: Gpu,
    /// The shader.
    pub costs: ShaderCosts,
    /// How triangles lie in memory.
    pub primitive_layout: PrimitiveLayout,
    /// In which order nodes lie in memory.
    pub node_order: NodeOrder,
}

/// A frame's counts.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// All sums.
    pub counters: FrameCounters,
    /// Node fetches of each pixel, by all of its rays.
    pub node_fetches: HeatMap,
    /// Bytes of the tree's node records.
    pub structure_bytes: u64,
    /// Warps that a core holds at once.
    pub resident_warps: u32,
}

/// Replays all tiles of `source`; `progress` hears how many of how many are done.
///
/// # Errors
/// When the trace contradicts itself, holds steps that no modelled shader takes, or cannot be read.
pub fn replay<S: TileSource>(
    source: &S,
    config: &ReplayConfig,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Replayed, Error> {
    let header = source.header();
    let gpu = &config.gpu;
    let resident_warps = resident_warps(gpu, registers(header, config)?, header)?;
    let refused = |error: cachesim::Error| Error::Config {
        file: gpu.name().to_owned(),
        line: None,
        key: "paths: ".to_owned(),
        problem: error.to_string(),
        remedy: "correct [paths]".to_owned(),
    };
    let (hierarchy, ids) = Hierarchy::with_paths(gpu.levels(), &gpu.paths.as_slices()).map_err(refused)?;
    let paths = KindPaths { ssbo: ids[0], private: ids[2] };
    let buffers = Buffers::new(
        source,
        config,
        gpu.cores.count * resident_warps,
        hierarchy.granule(paths.ssbo),
        hierarchy.granule(paths.private),
    )?;
    let program = Program::new(header, &buffers, config)?;
    let mut interleaver = Interleaver::new(gpu, hierarchy, paths, &buffers, resident_warps);

    let tiles = header.frame.tiles();
    let done = AtomicU64::new(0);
    let make = |batch: std::ops::Range<u32>| -> Result<Vec<(TileRect, Arc<TileStream>)>, Error> {
        let scratch = || (Tile::default(), TileReplay::new(&program));
        let one = |(tile, replay): &mut (Tile, TileReplay<'_>), index: u32| {
            source.tile(index, tile)?;
            let rect = header.frame.tile(index);
            let stream = replay.run(tile, rect)?;
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(tiles));
            Ok((rect, Arc::new(stream)))
        };
        batch.into_par_iter().map_init(scratch, one).collect()
    };

    let batch_tiles = TILES_PER_THREAD * rayon::current_num_threads() as u32;
    let mut counters = FrameCounters::default();
    let mut node_fetches = empty_map(header.frame);
    let mut batch = make(0..batch_tiles.min(tiles))?;
    let mut next = batch_tiles.min(tiles);
    while !batch.is_empty() {
        let end = next.saturating_add(batch_tiles).min(tiles);
        let (made, ()) = rayon::join(
            || make(next..end),
            || {
                for (rect, stream) in &batch {
                    add_tile(&mut counters, &mut node_fetches, *rect, stream);
                    interleaver.push(stream);
                    interleaver.run_ahead();
                }
            },
        );
        batch = made?;
        next = end;
    }

    let ([primary, shadow, output], flush, schedule) = interleaver.finish();
    counters.primary.traffic = primary;
    counters.shadow.traffic = shadow;
    counters.output.traffic = output;
    counters.flush = flush;
    counters.schedule = schedule;
    counters.stalls = source.stalls();
    Ok(Replayed { counters, node_fetches, structure_bytes: buffers.structure_bytes, resident_warps })
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

fn add_tile(counters: &mut FrameCounters, map: &mut HeatMap, rect: TileRect, stream: &TileStream) {
    counters.primary += PassCounters::of(stream, Pass::Primary);
    counters.shadow += PassCounters::of(stream, Pass::Shadow);
    counters.output += PassCounters::of(stream, Pass::Output);
    let rows = stream.node_fetches.chunks_exact(rect.width as usize);
    for (y, row) in (rect.y as usize..).zip(rows) {
        let start = y * map.width as usize + rect.x as usize;
        map.values[start..start + row.len()].copy_from_slice(row);
    }
}
