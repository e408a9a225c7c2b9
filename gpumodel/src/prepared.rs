//! A configuration of a frame, ready to run: its program, and engines for its warps.

use crate::config::{Gpu, RayUnit};
use crate::engine::Engine;
use crate::error::Error;
use crate::geometry;
use crate::interleave::{Interleaver, KindPaths};
use crate::layout::Buffers;
use crate::replay::{Fidelity, Maps, ReplayConfig};
use crate::schedule::{LaneMap, resident_warps};
use crate::warp::{Program, Walk};
use cachesim::Hierarchy;
use std::sync::Arc;
use tracer::{TileSource, TraceHeader};

/// A configuration of a frame, ready to run.
pub(crate) struct Prepared<'a> {
    pub(crate) config: &'a ReplayConfig,
    pub(crate) program: Arc<Program>,
    pub(crate) lane_map: LaneMap,
    pub(crate) walk: Walk,
    /// Of each core.
    pub(crate) resident_warps: u32,
    by_ray_unit: bool,
}

impl<'a> Prepared<'a> {
    /// # Errors
    /// When the trace and the configuration do not fit each other.
    pub(crate) fn new<S: TileSource>(source: &S, config: &'a ReplayConfig) -> Result<Self, Error> {
        let header = source.header();
        if config.technique.raster.is_some() {
            geometry::check(header)?;
        }
        if config.technique.reflections.is_some() {
            return Err(Error::Trace {
                scene: header.scene.clone(),
                problem: format!(
                    "a trace has the rays of each pixel, and {} lists them anew",
                    config.technique.name
                ),
                remedy: "use --fidelity replay, on a trace with reflection rays or on the scene itself"
                    .to_owned(),
            });
        }
        let gpu = &config.gpu;
        let resident_warps = resident_warps(gpu, registers(header, config)?, header)?;
        let by_ray_unit = gpu.ray_unit_for(header).is_some();
        if by_ray_unit && config.fidelity == Fidelity::Timed {
            return Err(Error::Trace {
                scene: header.scene.clone(),
                problem: "a ray unit tests its nodes, which is not simulated event by event".to_owned(),
                remedy: "use --fidelity replay, or --ray-unit none".to_owned(),
            });
        }
        let (hierarchy, paths) = caches(gpu, by_ray_unit)?;
        let buffers = Buffers::new(
            source,
            config,
            gpu.cores.count * resident_warps,
            hierarchy.granule(paths.traversal),
            hierarchy.granule(paths.private),
        )?;
        let program = Arc::new(Program::new(header, source.topology(), buffers, config)?);
        let lane_map = LaneMap::new(gpu, header.frame, config.technique.stage);
        let walk = Walk::new(header, source.topology(), config);
        Ok(Self { config, program, lane_map, walk, resident_warps, by_ray_unit })
    }

    /// Empty cores and cold caches, on the rung [`Fidelity::Replay`](crate::Fidelity).
    ///
    /// # Errors
    /// When the GPU's caches cannot be as described.
    pub(crate) fn interleaver(&self) -> Result<Interleaver, Error> {
        let Self { config, program, resident_warps, .. } = self;
        let (hierarchy, paths) = caches(&config.gpu, self.by_ray_unit)?;
        let places = program.buffers.places();
        Ok(Interleaver::new(&config.gpu, hierarchy, paths, places, *resident_warps, Maps::Dropped))
    }

    /// Whether one copy of the last cache before memory has room for all buffers.
    pub(crate) fn fits_last_cache(&self) -> bool {
        let gpu = &self.config.gpu;
        let bytes = self.program.buffers.sizes.total();
        gpu.paths.ssbo.last().is_some_and(|&last| bytes <= gpu.levels().as_slice()[last].size.0)
    }

    /// Lines of all copies of the last cache before memory.
    pub(crate) fn last_cache_lines(&self) -> u64 {
        let gpu = &self.config.gpu;
        gpu.paths.ssbo.last().map_or(0, |&last| {
            let level = &gpu.levels().as_slice()[last];
            u64::from(level.count) * level.lines()
        })
    }

    /// Empty cores and cold caches, on the configuration's rung.
    ///
    /// # Errors
    /// When the GPU's caches or memory cannot be as described.
    pub(crate) fn engine(&self, maps: Maps) -> Result<Engine, Error> {
        let Self { config, program, resident_warps, .. } = self;
        let (hierarchy, paths) = caches(&config.gpu, self.by_ray_unit)?;
        let places = program.buffers.places();
        let mut engine =
            Engine::new(config.fidelity, &config.gpu, hierarchy, paths, places, *resident_warps, maps)?;
        if config.keeps_misses {
            engine.keep_misses();
        }
        Ok(engine)
    }
}

pub(crate) fn caches(gpu: &Gpu, by_ray_unit: bool) -> Result<(Hierarchy, KindPaths), Error> {
    let refused = |error: cachesim::Error| Error::Config {
        file: gpu.name().to_owned(),
        line: None,
        key: "paths: ".to_owned(),
        problem: error.to_string(),
        remedy: "correct [paths]".to_owned(),
    };
    let (hierarchy, ids) = gpu.hierarchy().map_err(refused)?;
    Ok((hierarchy, KindPaths::new(&ids, by_ray_unit)))
}

/// Registers of four words per lane, those of a short stack among them.
pub(crate) fn registers(header: &TraceHeader, config: &ReplayConfig) -> Result<u32, Error> {
    let of_alpha = config.costs.alpha(header)?.registers;
    if config.gpu.ray_unit_for(header).is_some_and(RayUnit::walks) {
        return Ok(config.costs.ray_query.registers.max(of_alpha));
    }
    let short_stack = (u64::from(header.short_stack) * 8).div_ceil(16);
    let of_levels = config.costs.two_level(header, &config.gpu)?.map_or(0, |costs| costs.registers);
    let traversal = config.costs.of_shader(header, &config.gpu)?;
    let registers = traversal.registers.max(of_alpha);
    Ok(registers.saturating_add(of_levels).saturating_add(short_stack as u32))
}
