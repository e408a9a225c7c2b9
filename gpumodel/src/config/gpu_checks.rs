//! Parts of a GPU's description, checked: limits, and figures that must fit each other.

use super::gpu::{CacheLevel, GpuEnergy, Registers, TextureUnit, Tiler};
use super::gpu_file::{
    CacheFile, EnergyFile, FullWord, PerFile, PerWord, PolicyFile, RegistersFile, TextureFile, TilerFile,
    WaysFile,
};
use super::sourced::{File, Sourced};
use crate::error::Error;
use cachesim::{Bytes, DramStandard, LevelConfig, Levels, LineSize, Policy, Ways};
use std::ops::{Range, RangeInclusive};

/// Smallest line or sector: the 16 bytes of one vec4 load never straddle two.
const SMALLEST_LINE: u64 = 16;
/// Lines that a unit or cache waits for at once.
pub(super) const IN_FLIGHT: RangeInclusive<u32> = 1..=65536;
/// Most lanes of a warp: one bit each in a 64-bit mask.
pub(super) const WIDEST_WARP: u32 = 64;
/// Positive figures are refused below and above these; both are far from any hardware, and far from where f64 loses them.
pub(super) const RATE: RangeInclusive<f64> = 1e-9..=1e9;

/// Up to the last cache of the path: see [`Gpu::latency_cycles`].
pub(super) fn cache_latency(
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

pub(super) fn texture(file: &File<'_>, raw: &TextureFile) -> Result<TextureUnit, Error> {
    Ok(TextureUnit {
        samples_per_clock: file.within("texture.samples_per_clock", &raw.samples_per_clock, RATE)?,
        latency_cycles: file.within("texture.latency_cycles", &raw.latency_cycles, 0.0..=*RATE.end())?,
        lines_in_flight: file.within("texture.lines_in_flight", &raw.lines_in_flight, IN_FLIGHT)?,
    })
}

pub(super) fn dram_standard(file: &File<'_>, figure: &Sourced<String>) -> Result<DramStandard, Error> {
    let key = "dram.standard";
    let standard = file.sourced(key, figure)?;
    DramStandard::builtin(standard).map_err(|_| {
        let known: Vec<&str> = cachesim::DRAM_STANDARDS.iter().map(|known| known.name).collect();
        let problem = format!("is '{standard}', expected one of: {}", known.join(", "));
        let remedy = "name the nearest of these, and say so in its source";
        file.refuse(key, &figure.value.span(), problem, remedy)
    })
}

pub(super) fn energy(file: &File<'_>, raw: &EnergyFile) -> Result<GpuEnergy, Error> {
    let process = file.sourced("energy.process", &raw.process)?;
    Ok(GpuEnergy { process: process.clone() })
}

pub(super) fn registers(
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

pub(super) fn tiler(file: &File<'_>, raw: &TilerFile) -> Result<Tiler, Error> {
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

pub(super) fn warp_pixels(
    file: &File<'_>,
    figure: &Sourced<[u32; 2]>,
    warp_width: u32,
) -> Result<[u32; 2], Error> {
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

pub(super) fn caches(
    file: &File<'_>,
    raw: &[CacheFile],
    cores: u32,
) -> Result<(Levels, Vec<CacheLevel>), Error> {
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

pub(super) fn path(
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
