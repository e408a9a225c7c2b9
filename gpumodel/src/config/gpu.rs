//! A GPU, described and checked.

use super::atomics::{Atomics, atomics};
use super::gpu_checks::{
    IN_FLIGHT, RATE, WIDEST_WARP, cache_latency, caches, dram_standard, energy, path, registers, texture,
    tiler, warp_pixels,
};
use super::gpu_file::GpuFile;
use super::gpu_presets::BuiltinGpu;
use super::operating_points::{OperatingPoint, operating_points};
use super::ray_pipeline::{RayPipeline, ray_pipeline};
use super::ray_unit::{RayUnit, ray_unit};
use super::reflection_technique::Reflections;
use super::sourced::{File, Provenance, Sourced, Tag, tags};
use super::stereo::{InternalMemory, internal_memory};
use super::technique::Technique;
use super::translation::{Translation, translation};
use crate::error::Error;
use cachesim::{DramConfig, DramStandard, Hierarchy, Levels, PathId};
use serde::Deserialize;
use tracer::TraceHeader;

/// A GPU: every figure checked, none defaulted.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// What it is called.
    pub identity: Identity,
    /// Its clock.
    pub clock: Clock,
    /// Its cores.
    pub cores: ShaderCores,
    /// The register file of a core.
    pub registers: Registers,
    /// The load/store unit of a core.
    pub load_store: LoadStore,
    /// The texture unit of a core.
    pub texture: TextureUnit,
    /// Caches from the cores to memory.
    pub caches: Vec<CacheLevel>,
    /// Caches that each kind of buffer goes through.
    pub paths: Paths,
    /// The ray unit of a core, where there is one.
    pub ray_unit: Option<RayUnit>,
    /// What its driver makes of ray-tracing pipelines, where that is known.
    pub ray_pipeline: Option<RayPipeline>,
    /// Translation of addresses, where figures for it are known.
    pub translation: Option<Translation>,
    /// Atomics, barriers and indirect dispatches, where figures for them are given.
    pub atomics: Option<Atomics>,
    /// Memory that kernels address and DMA fills, where there is such.
    pub internal_memory: Option<InternalMemory>,
    /// System memory.
    pub dram: Dram,
    /// Rasterisation in bins.
    pub tiler: Tiler,
    /// The colour buffer.
    pub output: Output,
    /// What its energy depends on, where that is known.
    pub energy: Option<GpuEnergy>,
    /// Clocks that it can run at, the highest first; none where they are not known.
    pub operating_points: Vec<OperatingPoint>,
    levels: Levels,
    tags: Vec<(String, Tag)>,
}

/// What a GPU is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Short name.
    pub name: String,
    /// Full name, with the chips and phones that have it.
    pub title: String,
    /// Whose profiler's words apply.
    pub family: Family,
}

/// Maker's family of GPUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// Qualcomm: Snapdragon Profiler.
    Adreno,
    /// Arm: Streamline.
    Mali,
    /// Neither: the counters keep their canonical names.
    Other,
}

/// The shader clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Cycles per second.
    pub hz: f64,
}

/// The shader cores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaderCores {
    /// Number of cores.
    pub count: u32,
    /// Lanes of a warp.
    pub warp_width: u32,
    /// Pixels of a fragment warp, width and height: powers of two from 2 to 32, as many as lanes.
    pub warp_pixels: [u32; 2],
    /// Most warps resident in a core.
    pub warp_slots: u32,
    /// Full-precision operations per clock and core.
    pub alu_lanes: f64,
    /// Elementary functions per clock and core.
    pub efu_lanes: f64,
    /// Which of the warps that could issue does.
    pub scheduler: Scheduler,
}

/// Which of the warps that could issue does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduler {
    /// The one that has waited longest.
    RoundRobin,
    /// The one that issued last, until it has to wait; then the one that has been resident longest.
    GreedyThenOldest,
}

/// The register file of a core.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Registers {
    /// Registers of four 32-bit words that share out among [`Self::granularity`] warps.
    pub vec4: u32,
    /// Warps that become resident together.
    pub granularity: u32,
    /// Numbers of vec4 registers that a lane can be given, rising; empty where any number can. A lane that needs more than the
    /// largest gets that, and keeps the rest in memory.
    pub sizes_vec4: Vec<u32>,
}

/// The load/store unit of a core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadStore {
    /// Bytes moved to or from registers per clock.
    pub bytes_per_clock: u32,
    /// Lines that can be on their way to the core at once, apart from those that its own cache has.
    pub lines_in_flight: u32,
}

/// The texture unit of a core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUnit {
    /// Bilinear samples of 32-bit texels per clock.
    pub samples_per_clock: f64,
    /// Cycles that a read through this unit takes longer than one past it, where a farther cache than the first of its path, or
    /// memory, has the data: addresses, misses of the first cache, filtering. See [`Gpu::latency_cycles`].
    pub latency_cycles: f64,
    /// Lines that can be on their way to the unit at once, apart from those that the core's own cache has.
    pub lines_in_flight: u32,
}

/// One cache level, beyond what [`Gpu::levels`] says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct CacheLevel {
    /// Its name.
    pub name: String,
    /// What the counters call it.
    pub role: CacheRole,
    /// Private copies; 1 for a shared cache.
    pub copies: u32,
    /// Bytes of a line.
    pub line_bytes: u64,
    /// Cycles from a core's request to its data on a hit here, the way through all nearer levels included; in a cache behind the first
    /// of the texture unit's path, for a read that does not come from that unit.
    pub latency_cycles: f64,
    /// Bytes that each copy delivers per clock, all its banks together.
    pub bytes_per_clock: f64,
    /// Banks of each copy; a line is in the one that its number modulo the banks names.
    pub banks: u32,
    /// Lines that each copy can be waiting for at once.
    pub mshrs: u32,
}

/// What the counters call a cache level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CacheRole {
    /// First level.
    L1,
    /// Shared by some cores, before the second level.
    Cluster,
    /// Second level.
    L2,
    /// Shared by the whole chip.
    Slc,
}

impl CacheRole {
    /// Its name in descriptions and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::L1 => "l1",
            Self::Cluster => "cluster",
            Self::L2 => "l2",
            Self::Slc => "slc",
        }
    }
}

/// Caches that each kind of buffer goes through, as indices into [`Gpu::caches`], nearest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    /// Storage buffers.
    pub ssbo: Vec<usize>,
    /// Textures.
    pub texture: Vec<usize>,
    /// Memory private to a lane.
    pub private: Vec<usize>,
    /// Vertices for rasterisation.
    pub vertex: Vec<usize>,
}

/// System memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Dram {
    /// Timings, banks and rows: one of [`cachesim::DRAM_STANDARDS`].
    pub standard: DramStandard,
    /// Channels, which share the peak.
    pub channels: u32,
    /// Requests that the scheduler of each channel sees.
    pub queue: u32,
    /// Bytes per second at best.
    pub peak_bytes_per_second: f64,
    /// Share of the peak that the way between the last cache and the memory lets through.
    pub efficiency: f64,
    /// Seconds that a miss of the last cache waits where nothing else does, the row that it opens included.
    pub latency_seconds: f64,
    /// Seconds by which a line comes sooner whose row is open already: the standard's tRCD.
    pub row_open_seconds: f64,
    /// Seconds by which a line comes later whose bank has just opened another row: the standard's tRC.
    pub row_cycle_seconds: f64,
}

/// Rasterisation in bins: parts of the screen that fit into tile memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tiler {
    /// Tile memory of the whole GPU.
    pub tile_memory_bytes: u32,
    /// Width and height of a bin are multiples of these.
    pub bin_alignment: [u32; 2],
    /// In the list of a bin, bits for every triangle drawn, inside the bin or not.
    pub list_bits_per_triangle: u32,
    /// In the list of a bin, bytes for every triangle inside it.
    pub list_bytes_per_entry: u32,
    /// Triangles set up per clock.
    pub triangles_per_clock: f64,
    /// Covered pixels tested and written per clock.
    pub pixels_per_clock: f64,
}

/// The colour buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Bytes of a pixel.
    pub bytes_per_pixel: u32,
}

/// What the energy of a GPU depends on beyond its sizes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuEnergy {
    /// Name of its process in an [`EnergyTable`](crate::EnergyTable).
    pub process: String,
}

impl Dram {
    /// As the simulation of DRAM takes it.
    pub fn simulated(&self) -> DramConfig {
        DramConfig {
            standard: self.standard.clone(),
            channels: self.channels,
            bytes_per_second: self.peak_bytes_per_second,
            queue: self.queue,
        }
    }
}

impl Gpu {
    /// Reads and checks a description; `file_name` is for messages only.
    ///
    /// # Errors
    /// Names the file, the line, the key, what was expected and the remedy.
    pub fn parse(toml_text: &str, file_name: &str) -> Result<Self, Error> {
        let file = File::new(file_name, toml_text);
        let raw: GpuFile = file.read()?;
        let name = raw.identity.name;
        if name.get_ref().is_empty() {
            return Err(file.refuse("identity.name", &name.span(), "is empty", "name the GPU"));
        }
        let cores = &raw.shader_cores;
        let count = file.within("shader_cores.count", &cores.count, 1..=256)?;
        let warp_width = file.within("shader_cores.warp_width", &cores.warp_width, 4..=WIDEST_WARP)?;
        let warp_pixels = warp_pixels(&file, &cores.warp_pixels, warp_width)?;
        let warp_slots = file.within("shader_cores.warp_slots", &cores.warp_slots, 1..=1024)?;
        let (levels, caches) = caches(&file, &raw.cache, count)?;
        let path = |key: &str, names: &Sourced<Vec<String>>| path(&file, key, names, &caches);
        let paths = Paths {
            ssbo: path("paths.ssbo", &raw.paths.ssbo)?,
            texture: path("paths.texture", &raw.paths.texture)?,
            private: path("paths.private", &raw.paths.private)?,
            vertex: path("paths.vertex", &raw.paths.vertex)?,
        };
        let ray_unit = raw.ray_unit.as_ref().map(|raw| ray_unit(&file, raw, &caches)).transpose()?;
        Hierarchy::with_paths(&levels, &all_paths(&paths, ray_unit.as_ref(), &caches)).map_err(|error| {
            let remedy = "correct [paths] or the order of the [[cache]] tables";
            file.refuse("paths", &raw.paths.ssbo.value.span(), error, remedy)
        })?;
        let texture = texture(&file, &raw.texture)?;
        let of_unit = raw.ray_unit.as_ref().zip(ray_unit.as_ref());
        let of_unit = of_unit.map(|(raw, unit)| ("ray_unit.path", &unit.path, raw.path.value.span()));
        let of_paths = [
            ("paths.ssbo", &paths.ssbo, raw.paths.ssbo.value.span()),
            ("paths.texture", &paths.texture, raw.paths.texture.value.span()),
            ("paths.private", &paths.private, raw.paths.private.value.span()),
            ("paths.vertex", &paths.vertex, raw.paths.vertex.value.span()),
        ];
        for (key, path, span) in of_paths.into_iter().chain(of_unit) {
            let cycles = |place| cache_latency(&caches, &paths.texture, &texture, path, place);
            let Some(place) = (1..path.len()).find(|&place| cycles(place) < cycles(place - 1)) else {
                continue;
            };
            let (nearer, farther) = (&caches[path[place - 1]].name, &caches[path[place]].name);
            let problem = format!(
                "reaches '{farther}' in {} cycles, fewer than the {} of '{nearer}' on the way",
                cycles(place),
                cycles(place - 1)
            );
            let remedy = format!(
                "raise cache.{farther}.latency_cycles, which includes the way through nearer caches{}",
                if path[0] == paths.texture[0] { ", or texture.latency_cycles" } else { "" }
            );
            return Err(file.refuse(key, &span, problem, &remedy));
        }
        let standard = dram_standard(&file, &raw.dram.standard)?;
        Ok(Self {
            identity: Identity {
                name: name.into_inner(),
                title: raw.identity.title,
                family: raw.identity.family,
            },
            clock: Clock { hz: file.within("clock.mhz", &raw.clock.mhz, 1e-6..=1e7)? * 1e6 },
            cores: ShaderCores {
                count,
                warp_width,
                warp_pixels,
                warp_slots,
                alu_lanes: file.within("shader_cores.alu_lanes", &cores.alu_lanes, RATE)?,
                efu_lanes: file.within("shader_cores.efu_lanes", &cores.efu_lanes, RATE)?,
                scheduler: *file.sourced("shader_cores.scheduler", &cores.scheduler)?,
            },
            registers: registers(&file, &raw.registers, warp_slots, &cores.warp_slots.value.span())?,
            load_store: LoadStore {
                bytes_per_clock: file.within(
                    "load_store.bytes_per_clock",
                    &raw.load_store.bytes_per_clock,
                    1..=4096,
                )?,
                lines_in_flight: file.within(
                    "load_store.lines_in_flight",
                    &raw.load_store.lines_in_flight,
                    IN_FLIGHT,
                )?,
            },
            texture,
            caches,
            paths,
            ray_unit,
            ray_pipeline: raw.ray_pipeline.map(|raw| ray_pipeline(&file, &raw)).transpose()?,
            translation: raw.translation.map(|raw| translation(&file, &raw)).transpose()?,
            atomics: raw.atomics.map(|raw| atomics(&file, &raw)).transpose()?,
            internal_memory: raw.internal_memory.map(|raw| internal_memory(&file, &raw)).transpose()?,
            dram: Dram {
                channels: file.within("dram.channels", &raw.dram.channels, 1..=cachesim::MAX_CHANNELS)?,
                queue: file.within("dram.queue", &raw.dram.queue, 1..=cachesim::MAX_QUEUE)?,
                peak_bytes_per_second: file.within("dram.peak_gbs", &raw.dram.peak_gbs, 1e-9..=1e7)? * 1e9,
                efficiency: file.within("dram.efficiency", &raw.dram.efficiency, 0.01..=1.0)?,
                latency_seconds: file.within("dram.latency_ns", &raw.dram.latency_ns, RATE)? * 1e-9,
                row_open_seconds: standard.row_open_seconds(),
                row_cycle_seconds: standard.row_cycle_seconds(),
                standard,
            },
            tiler: tiler(&file, &raw.tiler)?,
            output: Output {
                bytes_per_pixel: file.within(
                    "output.bytes_per_pixel",
                    &raw.output.bytes_per_pixel,
                    1..=64,
                )?,
            },
            energy: raw.energy.map(|raw| energy(&file, &raw)).transpose()?,
            operating_points: operating_points(&file, &raw.operating_point)?,
            levels,
            tags: tags(toml_text),
        })
    }

    /// The built-in description of that name.
    pub fn builtin(name: &str) -> Option<Result<Self, Error>> {
        let gpu = BuiltinGpu::named(name)?;
        Some(Self::parse(gpu.toml, &format!("{name}.toml")))
    }

    /// Its short name.
    pub fn name(&self) -> &str {
        &self.identity.name
    }

    /// How many of its figures carry each tag.
    pub fn provenance(&self) -> Provenance {
        Provenance::of(&self.tags)
    }

    /// Dotted keys of the figures that are estimates.
    pub fn estimates(&self) -> Vec<String> {
        let estimates = self.tags.iter().filter(|(_, tag)| *tag == Tag::Estimate);
        estimates.map(|(key, _)| key.clone()).collect()
    }

    /// Cycles from a core's request to its data, where the cache at `place` of `path` has it, or memory where `place` is the path's
    /// length, and nothing else is under way.
    ///
    /// The [`CacheLevel::latency_cycles`] of that cache; memory adds [`Dram::latency_seconds`] to the last. Behind the first cache of
    /// a path that begins where the texture unit's does, [`TextureUnit::latency_cycles`] is added: on the Adreno 640 a buffer and an image
    /// find the same UCHE after 66 and 146 cycles, and the system cache behind it about as far apart.
    pub fn latency_cycles(&self, path: &[usize], place: usize) -> f64 {
        let memory = if place < path.len() { 0.0 } else { self.dram.latency_seconds * self.clock.hz };
        cache_latency(&self.caches, &self.paths.texture, &self.texture, path, place) + memory
    }

    /// Lines that can be on their way to a core at once for reads that take `path`: those of the texture unit or of the ray unit where it begins
    /// with that unit's own cache, otherwise those of the load/store unit.
    pub fn lines_in_flight(&self, path: &[usize]) -> u32 {
        match &self.ray_unit {
            Some(unit) if self.through_unit_port(path) => unit.lines_in_flight,
            _ if path.first() == self.paths.texture.first() => self.texture.lines_in_flight,
            _ => self.load_store.lines_in_flight,
        }
    }

    /// Clocks that the port of a ray unit with its own cache takes for a line; 0 where there is none.
    pub(crate) fn unit_port_line_cycles(&self) -> f64 {
        let own = self.ray_unit.as_ref().filter(|unit| self.through_unit_port(&unit.path));
        own.map_or(0.0, |unit| {
            let cache = &self.caches[unit.path[0]];
            cache.line_bytes as f64 / cache.bytes_per_clock
        })
    }

    /// Whether reads that take `path` leave the core through a port of the ray unit: its first cache is its own. A unit that shares the
    /// first cache of storage buffers shares the load/store port before it.
    pub(crate) fn through_unit_port(&self, path: &[usize]) -> bool {
        let own = self.ray_unit.as_ref().and_then(|unit| unit.path.first());
        own.is_some() && own == path.first() && own != self.paths.ssbo.first()
    }

    /// The ray unit that walks the structure of a trace, or tests its nodes: such units know wide BVHs, and shaders do everything else.
    pub fn ray_unit_for(&self, header: &TraceHeader) -> Option<&RayUnit> {
        self.ray_unit.as_ref().filter(|unit| unit.takes(header))
    }

    /// Whether its ray unit tests the nodes of a trace at an instruction of the shader, which walks.
    pub(crate) fn has_instruction_for(&self, header: &TraceHeader) -> bool {
        self.ray_unit_for(header).is_some_and(|unit| !unit.walks())
    }

    /// Whether its driver has shaders walk the rays of this technique, although it has a ray unit.
    pub fn emulates(&self, technique: &Technique) -> bool {
        let sends_hit_queries = technique.reflections.as_ref().is_some_and(Reflections::sends_hit_queries);
        sends_hit_queries && self.ray_pipeline.is_some_and(|pipeline| pipeline.emulates_hit_queries)
    }

    /// The caches as the cache simulator takes them, in the order of [`Self::caches`].
    pub fn levels(&self) -> &Levels {
        &self.levels
    }

    /// The way of atomics on storage buffers.
    pub(crate) fn atomic_path(&self) -> &[usize] {
        atomic_path(&self.paths, &self.caches)
    }

    /// The caches, empty, with the TLB behind them, and their paths: storage buffers, textures, private memory, vertices, and the ray unit, which
    /// has that of storage buffers where there is none.
    ///
    /// # Errors
    /// When the paths contradict each other.
    pub(crate) fn hierarchy(&self) -> Result<(Hierarchy, Vec<PathId>), cachesim::Error> {
        let (hierarchy, paths) = Hierarchy::with_paths(
            &self.levels,
            &all_paths(&self.paths, self.ray_unit.as_ref(), &self.caches),
        )?;
        let hierarchy = match self.translation {
            Some(Translation { tlb, .. }) => hierarchy.with_tlb(tlb),
            None => hierarchy,
        };
        Ok((hierarchy, paths))
    }
}

/// As the cache simulator takes them: storage buffers, textures, private memory, vertices, ray unit, atomics.
fn all_paths<'a>(paths: &'a Paths, ray_unit: Option<&'a RayUnit>, caches: &[CacheLevel]) -> [&'a [usize]; 6] {
    let Paths { ssbo, texture, private, vertex } = paths;
    let unit = ray_unit.map_or(ssbo, |unit| &unit.path);
    [ssbo, texture, private, vertex, unit, atomic_path(paths, caches)]
}

/// Past the caches that not all cores share.
fn atomic_path<'a>(paths: &'a Paths, caches: &[CacheLevel]) -> &'a [usize] {
    let shared = paths.ssbo.iter().position(|&level| caches[level].copies == 1);
    &paths.ssbo[shared.unwrap_or(paths.ssbo.len() - 1)..]
}
