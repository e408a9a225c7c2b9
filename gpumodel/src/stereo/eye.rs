//! A frame of one of two eyes on its way through a GPU.

use super::Kernels;
use super::buffers::Buffers;
use crate::config::Cost;
use crate::counters::{FrameCounters, Pass};
use crate::dispatch::{Bench, Benches, Running, resident_warps};
use crate::engine::Engine;
use crate::error::Error;
use crate::layout::{BufferBytes, BufferKind, Buffers as SceneBuffers, Places};
use crate::prepared::{caches, registers};
use crate::replay::{Maps, Replayed, refuse};
use crate::schedule::LaneMap;
use crate::warp::{Emitter, Program, TileStreams, Walk, WarpSteps};
use tracer::{TileRect, TileSource};

/// What a load or store of a lane takes at most.
const LOAD_BYTES: u64 = 16;

/// One eye.
pub(super) struct Eye<'a, S> {
    pub(super) source: &'a S,
    pub(super) program: Program,
    walk: Walk,
    lane_map: LaneMap,
    pub(super) buffers: Buffers,
    pub(super) benches: Benches,
    /// That a core holds, of the shader that traces.
    pub(super) tracing_warps: u32,
    /// And of the other kernels.
    pub(super) kernel_warps: u32,
    port_bytes: u64,
    address: Cost,
}

impl<'a, S: TileSource> Eye<'a, S> {
    /// With empty cores and cold caches.
    pub(super) fn new(source: &'a S, kernels: &Kernels<'_>) -> Result<(Self, Running), Error> {
        let Kernels { config, stereo, costs, known, .. } = *kernels;
        let gpu = &config.gpu;
        let header = source.header();
        let resident = |registers: u32| resident_warps(gpu, registers, &config.technique.name);
        let tracing_warps = resident(registers(header, config)?.max(costs.registers))?;
        let (hierarchy, paths) = caches(gpu, gpu.ray_unit_for(header).is_some())?;
        let lines = [paths.traversal, paths.private].map(|path| hierarchy.granule(path));
        let of_scene =
            SceneBuffers::new(source, config, gpu.cores.count * tracing_warps, lines[0], lines[1])?;
        let buffers = Buffers::new(of_scene.end, known.size(), &stereo.fields, !kernels.in_tiles());
        let program = Program::new(header, source.topology(), of_scene, config)?;
        let places = Places { end: buffers.end, ..program.buffers.places() };
        let engine =
            Engine::new(config.fidelity, gpu, hierarchy, paths, places, tracing_warps, Maps::Dropped)?;
        let running = Running {
            engine,
            counters: FrameCounters::default(),
            resident_warps: [tracing_warps; Pass::COUNT],
        };
        let eye = Self {
            source,
            walk: Walk::new(header, source.topology(), config),
            lane_map: LaneMap::new(gpu, header.frame, config.technique.stage),
            program,
            buffers,
            benches: Benches::default(),
            tracing_warps,
            kernel_warps: resident(costs.registers)?,
            port_bytes: u64::from(gpu.load_store.bytes_per_clock),
            address: config.costs.shared.address,
        };
        Ok((eye, running))
    }

    /// A load or store of records of so many bytes in memory, at most 16 at a time, addresses included.
    pub(super) fn records(
        &self,
        emitter: &mut Emitter,
        pass: Pass,
        (write, bytes): (bool, u64),
        addresses: &(impl Iterator<Item = u64> + Clone),
    ) {
        for offset in (0..bytes).step_by(LOAD_BYTES as usize) {
            let of_load = LOAD_BYTES.min(bytes - offset) as u32;
            let at = addresses.clone().map(|address| address + offset);
            emitter.access(&self.program, pass, (BufferKind::Record, write, of_load), at);
            let lanes = addresses.clone().count() as u64;
            self.program.spend(self.address, u64::from(lanes > 0), lanes, emitter.issue(pass));
        }
    }

    /// A load or store of `lanes` lanes of a warp in internal or shared memory: the port takes its width per clock.
    pub(super) fn internal(&self, emitter: &mut Emitter, pass: Pass, lanes: u64, bytes: u64) {
        let (issue, moved) = (emitter.issue(pass), lanes * bytes);
        issue.internal_bytes += moved;
        issue.lane_bytes += moved;
        issue.load_store_cycles += moved.div_ceil(self.port_bytes);
    }

    /// The passes of the dispatch that traces.
    pub(super) fn tracing_passes(&self) -> Vec<Pass> {
        Pass::ALL.into_iter().filter(|pass| pass.traces() || *pass == Pass::Output).collect()
    }

    /// The warps of a tile, each of which `take` emits.
    ///
    /// # Errors
    /// When the tile cannot be read or contradicts itself.
    pub(super) fn tile(
        &self,
        Bench { tile, stepper, emitter }: &mut Bench,
        index: u32,
        mut take: impl FnMut(&mut Emitter, &WarpSteps, TileRect) -> Result<(), String>,
    ) -> Result<TileStreams, Error> {
        let header = self.source.header();
        self.source.tile(index, tile)?;
        let rect = header.frame.tile(index);
        let wanted = self.program.wanted();
        let tally = stepper
            .run(header, (&self.walk, &wanted), &self.lane_map, (tile, rect), |warp| {
                take(emitter, warp, rect)
            })
            .map_err(|problem| refuse(header, problem))?;
        Ok(emitter.take(&self.program, &tally, None))
    }

    /// What was counted, with dirty lines written back.
    pub(super) fn finish(self, mut running: Running) -> Replayed {
        running.counters.stalls = self.source.stalls();
        let SceneBuffers { structure_bytes, sizes, .. } = self.program.buffers;
        running.finish(structure_bytes, BufferBytes { record: self.buffers.bytes, ..sizes })
    }
}
