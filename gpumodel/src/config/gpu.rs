//! A GPU, described and checked.

use super::gpu_file::{
    CacheFile, FullWord, GpuFile, PerFile, PerWord, PolicyFile, RegistersFile, TextureFile, TilerFile,
    WaysFile,
};
use super::sourced::{File, Provenance, Sourced, Tag, tags};
use crate::error::Error;
use cachesim::{
    Bytes, DRAM_STANDARDS, DramConfig, DramStandard, Hierarchy, LevelConfig, Levels, LineSize, Policy, Ways,
};
use serde::Deserialize;
use std::ops::{Range, RangeInclusive};

/// A description that comes with the program.
pub struct BuiltinGpu {
    /// Its name on the command line.
    pub name: &'static str,
    /// The text of its file.
    pub toml: &'static str,
}

/// A description of `configs/gpus`, called as its file is.
macro_rules! builtin {
    ($name:literal) => {
        BuiltinGpu { name: $name, toml: include_str!(concat!("../../../configs/gpus/", $name, ".toml")) }
    };
}

/// All descriptions that come with the program, by maker and number.
pub const GPUS: &[BuiltinGpu] = &[
    builtin!("adreno-530"),
    builtin!("adreno-540"),
    builtin!("adreno-630"),
    builtin!("adreno-640"),
    builtin!("adreno-650"),
    builtin!("adreno-660"),
    builtin!("adreno-730"),
    builtin!("adreno-740"),
    builtin!("adreno-750"),
    builtin!("adreno-830"),
    builtin!("adreno-x1-85"),
    builtin!("mali-g57"),
    builtin!("mali-g71"),
    builtin!("mali-g72"),
    builtin!("mali-g76"),
    builtin!("mali-g77"),
    builtin!("mali-g78"),
    builtin!("mali-g710"),
    builtin!("mali-g715"),
    builtin!("mali-g720"),
    builtin!("mali-g925"),
    builtin!("mali-g1-ultra"),
    builtin!("vulkan-sim-mobile"),
];

impl BuiltinGpu {
    /// The description of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        GPUS.iter().find(|gpu| gpu.name == name)
    }
}

/// Smallest line or sector: the 16 bytes of one vec4 load never straddle two.
const SMALLEST_LINE: u64 = 16;
/// Lines that a unit or cache waits for at once.
const IN_FLIGHT: RangeInclusive<u32> = 1..=65536;
/// Most lanes of a warp: one bit each in a 64-bit mask.
const WIDEST_WARP: u32 = 64;
/// Positive figures are refused below and above these; both are far from any hardware, and far from where f64 loses them.
const RATE: RangeInclusive<f64> = 1e-9..=1e9;

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
    /// System memory.
    pub dram: Dram,
    /// Rasterisation in bins.
    pub tiler: Tiler,
    /// The colour buffer.
    pub output: Output,
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
    /// Lines that can be on their way to the core at once.
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
    /// Lines that can be on their way to the unit at once.
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
    pub standard: String,
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

impl Dram {
    /// As the simulation of DRAM takes it.
    ///
    /// # Errors
    /// When the standard is none that comes with the program.
    pub fn simulated(&self) -> Result<DramConfig, cachesim::Error> {
        Ok(DramConfig {
            standard: DramStandard::builtin(&self.standard)?,
            channels: self.channels,
            bytes_per_second: self.peak_bytes_per_second,
            queue: self.queue,
        })
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
        Hierarchy::with_paths(&levels, &paths.as_slices()).map_err(|error| {
            let remedy = "correct [paths] or the order of the [[cache]] tables";
            file.refuse("paths", &raw.paths.ssbo.value.span(), error, remedy)
        })?;
        let texture = texture(&file, &raw.texture)?;
        for (key, path, span) in [
            ("paths.ssbo", &paths.ssbo, raw.paths.ssbo.value.span()),
            ("paths.texture", &paths.texture, raw.paths.texture.value.span()),
            ("paths.private", &paths.private, raw.paths.private.value.span()),
            ("paths.vertex", &paths.vertex, raw.paths.vertex.value.span()),
        ] {
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
            dram: Dram {
                standard: dram_standard(&file, &raw.dram.standard)?,
                channels: file.within("dram.channels", &raw.dram.channels, 1..=cachesim::MAX_CHANNELS)?,
                queue: file.within("dram.queue", &raw.dram.queue, 1..=cachesim::MAX_QUEUE)?,
                peak_bytes_per_second: file.within("dram.peak_gbs", &raw.dram.peak_gbs, 1e-9..=1e7)? * 1e9,
                efficiency: file.within("dram.efficiency", &raw.dram.efficiency, 0.01..=1.0)?,
                latency_seconds: file.within("dram.latency_ns", &raw.dram.latency_ns, RATE)? * 1e-9,
            },
            tiler: tiler(&file, &raw.tiler)?,
            output: Output {
                bytes_per_pixel: file.within(
                    "output.bytes_per_pixel",
                    &raw.output.bytes_per_pixel,
                    1..=64,
                )?,
            },
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

    /// Lines that can be on their way to a core at once for reads that take `path`: those of the texture unit where it begins with
    /// that unit's cache, otherwise those of the load/store unit.
    pub fn lines_in_flight(&self, path: &[usize]) -> u32 {
        if path.first() == self.paths.texture.first() {
            self.texture.lines_in_flight
        } else {
            self.load_store.lines_in_flight
        }
    }

    /// The caches as the cache simulator takes them, in the order of [`Self::caches`].
    pub fn levels(&self) -> &Levels {
        &self.levels
    }
}

impl Paths {
    /// As the cache simulator takes them: storage buffers, textures, private memory, vertices.
    pub(crate) fn as_slices(&self) -> [&[usize]; 4] {
        [&self.ssbo, &self.texture, &self.private, &self.vertex]
    }
}

/// Up to the last cache of the path: see [`Gpu::latency_cycles`].
fn cache_latency(
    caches: &[CacheLevel],
    texture_path: &[usize],
    texture: &TextureUnit,
    path: &[usize],
    place: usize,
) -> f64 {
    let through_unit = place > 0 && path[0] == texture_path[0];
    caches[path[place.min(path.len() - 1)]].latency_cycles
        + if through_unit { texture.latency_cycles } else { 0.0 }
}

fn texture(file: &File<'_>, raw: &TextureFile) -> Result<TextureUnit, Error> {
    Ok(TextureUnit {
        samples_per_clock: file.within("texture.samples_per_clock", &raw.samples_per_clock, RATE)?,
        latency_cycles: file.within("texture.latency_cycles", &raw.latency_cycles, 0.0..=*RATE.end())?,
        lines_in_flight: file.within("texture.lines_in_flight", &raw.lines_in_flight, IN_FLIGHT)?,
    })
}

fn dram_standard(file: &File<'_>, figure: &Sourced<String>) -> Result<String, Error> {
    let key = "dram.standard";
    let standard = file.sourced(key, figure)?;
    let known: Vec<&str> = DRAM_STANDARDS.iter().map(|known| known.name).collect();
    if known.contains(&standard.as_str()) {
        return Ok(standard.clone());
    }
    let problem = format!("is '{standard}', expected one of: {}", known.join(", "));
    Err(file.refuse(
        key,
        &figure.value.span(),
        problem,
        "name the nearest of these, and say so in its source",
    ))
}

fn registers(
    file: &File<'_>,
    raw: &RegistersFile,
    warp_slots: u32,
    slots_span: &Range<usize>,
) -> Result<Registers, Error> {
    let vec4 = file.within("registers.vec4", &raw.vec4, 1..=65536)?;
    let key = "registers.sizes_vec4";
    let sizes_vec4 = file.sourced(key, &raw.sizes_vec4)?;
    let rising = sizes_vec4.windows(2).all(|pair| pair[0] < pair[1]);
    if !rising || sizes_vec4.iter().any(|&size| size == 0 || size > vec4) {
        let problem =
            format!("is {sizes_vec4:?}, expected rising numbers from 1 to the {vec4} of registers.vec4");
        return Err(file.refuse(key, &raw.sizes_vec4.value.span(), problem, "correct the list"));
    }
    let granularity = file.within("registers.granularity", &raw.granularity, 1..=64)?;
    if warp_slots < granularity {
        let problem = format!(
            "is {warp_slots}, expected no fewer than the {granularity} warps of registers.granularity"
        );
        let remedy = "raise it, or lower registers.granularity: these warps become resident together";
        return Err(file.refuse("shader_cores.warp_slots", slots_span, problem, remedy));
    }
    Ok(Registers { vec4, granularity, sizes_vec4: sizes_vec4.clone() })
}

fn tiler(file: &File<'_>, raw: &TilerFile) -> Result<Tiler, Error> {
    let key = "tiler.bin_alignment";
    let bin_alignment = *file.sourced(key, &raw.bin_alignment)?;
    if bin_alignment.iter().any(|&edge| edge == 0 || edge > 4096 || !edge.is_multiple_of(tracer::TILE_EDGE)) {
        let [width, height] = bin_alignment;
        let problem =
            format!("is [{width}, {height}], expected two multiples of {} up to 4096", tracer::TILE_EDGE);
        let remedy = "round the figures up: triangles are listed by tiles of that edge";
        return Err(file.refuse(key, &raw.bin_alignment.value.span(), problem, remedy));
    }
    let count = |key: &str, figure: &Sourced<u32>| file.within(&format!("tiler.{key}"), figure, 0..=4096);
    let rate = |key: &str, figure: &Sourced<f64>| file.within(&format!("tiler.{key}"), figure, RATE);
    Ok(Tiler {
        tile_memory_bytes: file.within("tiler.tile_memory_bytes", &raw.tile_memory_bytes, 1..=1 << 30)?,
        bin_alignment,
        list_bits_per_triangle: count("list_bits_per_triangle", &raw.list_bits_per_triangle)?,
        list_bytes_per_entry: count("list_bytes_per_entry", &raw.list_bytes_per_entry)?,
        triangles_per_clock: rate("triangles_per_clock", &raw.triangles_per_clock)?,
        pixels_per_clock: rate("pixels_per_clock", &raw.pixels_per_clock)?,
    })
}

fn warp_pixels(file: &File<'_>, figure: &Sourced<[u32; 2]>, warp_width: u32) -> Result<[u32; 2], Error> {
    let key = "shader_cores.warp_pixels";
    let [width, height] = *file.sourced(key, figure)?;
    let fits = |edge: u32| edge.is_power_of_two() && (2..=tracer::TILE_EDGE).contains(&edge);
    if fits(width) && fits(height) && width * height == warp_width {
        return Ok([width, height]);
    }
    let problem = format!(
        "is [{width}, {height}], expected two powers of two from 2 to {} whose product is the warp width {warp_width}",
        tracer::TILE_EDGE
    );
    Err(file.refuse(key, &figure.value.span(), problem, "give as many pixels as lanes, in whole 2x2 quads"))
}

fn caches(file: &File<'_>, raw: &[CacheFile], cores: u32) -> Result<(Levels, Vec<CacheLevel>), Error> {
    let mut configs = Vec::new();
    let mut caches = Vec::new();
    for cache in raw {
        let name = cache.name.get_ref();
        let key = |field: &str| format!("cache.{name}.{field}");
        let line_key = key("line");
        let line = file.within(&line_key, &cache.line, SMALLEST_LINE..=4096)?;
        let Some(line_size) = LineSize::new(line) else {
            let problem = format!("is {line}, expected a power of two");
            return Err(file.refuse(&line_key, &cache.line.value.span(), problem, "correct the value"));
        };
        let ways = match *file.sourced(&key("ways"), &cache.ways)? {
            WaysFile::Count(ways) => Ways::Count(ways),
            WaysFile::Word(FullWord::Full) => Ways::Full,
        };
        let policy = match *file.sourced(&key("policy"), &cache.policy)? {
            PolicyFile::Lru => Policy::Lru,
            PolicyFile::Fifo => Policy::Fifo,
            PolicyFile::Plru => Policy::Plru,
            PolicyFile::Srrip => Policy::Srrip,
            PolicyFile::Random => Policy::Random { seed: 0 },
        };
        let copies = match cache.per.get_ref() {
            PerFile::Word(PerWord::Core) => cores,
            PerFile::Word(PerWord::Gpu) => 1,
            PerFile::Cores(sharing) if *sharing > 0 && cores.is_multiple_of(*sharing) => cores / sharing,
            PerFile::Cores(sharing) => {
                let problem =
                    format!("is {sharing}, expected a divisor of the {cores} cores of shader_cores.count");
                let remedy = "say how many cores share a copy, or write \"core\" or \"gpu\"";
                return Err(file.refuse(&key("per"), &cache.per.span(), problem, remedy));
            }
        };
        let config = LevelConfig {
            write: *file.sourced(&key("write"), &cache.write)?,
            write_miss: *file.sourced(&key("write_miss"), &cache.write_miss)?,
            count: copies,
            ..LevelConfig::new(
                name,
                Bytes(*file.sourced(&key("size"), &cache.size)?),
                line_size,
                ways,
                policy,
            )
        };
        // Alone first, so that a message points at the right table.
        Levels::new(vec![config.clone()]).map_err(|error| {
            file.refuse(&format!("cache.{name}"), &cache.name.span(), error, "correct this [[cache]] table")
        })?;
        let banks = file.within(&key("banks"), &cache.banks, 1..=256)?;
        if u64::from(banks) > config.lines() {
            let problem =
                format!("is {banks}, expected no more than the {} lines of the cache", config.lines());
            let remedy = "lower it, or raise size: a line lies in one bank";
            return Err(file.refuse(&key("banks"), &cache.banks.value.span(), problem, remedy));
        }
        configs.push(config);
        caches.push(CacheLevel {
            name: name.clone(),
            role: cache.role,
            copies,
            line_bytes: line,
            latency_cycles: file.within(&key("latency_cycles"), &cache.latency_cycles, RATE)?,
            bytes_per_clock: file.within(&key("bytes_per_clock"), &cache.bytes_per_clock, RATE)?,
            banks,
            mshrs: file.within(&key("mshrs"), &cache.mshrs, IN_FLIGHT)?,
        });
    }
    let span = raw.first().map_or(0..0, |cache| cache.name.span());
    let levels = Levels::new(configs)
        .map_err(|error| file.refuse("cache", &span, error, "correct the [[cache]] tables"))?;
    Ok((levels, caches))
}

fn path(
    file: &File<'_>,
    key: &str,
    names: &Sourced<Vec<String>>,
    caches: &[CacheLevel],
) -> Result<Vec<usize>, Error> {
    let wanted = file.sourced(key, names)?;
    let span = names.value.span();
    if wanted.is_empty() {
        return Err(file.refuse(key, &span, "is empty, expected at least one cache", "name a [[cache]]"));
    }
    let find = |name: &String| {
        caches.iter().position(|cache| cache.name == *name).ok_or_else(|| {
            let known: Vec<_> = caches.iter().map(|cache| cache.name.as_str()).collect();
            let problem = format!("names '{name}', expected one of: {}", known.join(", "));
            file.refuse(key, &span, problem, "name a [[cache]] of this file")
        })
    };
    wanted.iter().map(find).collect()
}
