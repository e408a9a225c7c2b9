//! A GPU description as it stands in its TOML file.

use super::gpu::{CacheRole, Family, Scheduler};
use super::operating_points::OperatingPointFile;
use super::ray_unit::RayScheduling;
use super::sourced::Sourced;
use cachesim::{WriteMiss, WritePolicy};
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GpuFile {
    pub(super) identity: IdentityFile,
    pub(super) clock: ClockFile,
    pub(super) shader_cores: ShaderCoresFile,
    pub(super) registers: RegistersFile,
    pub(super) load_store: LoadStoreFile,
    pub(super) texture: TextureFile,
    pub(super) cache: Vec<CacheFile>,
    pub(super) paths: PathsFile,
    pub(super) ray_unit: Option<RayUnitFile>,
    pub(super) ray_pipeline: Option<RayPipelineFile>,
    pub(super) translation: Option<TranslationFile>,
    pub(super) atomics: Option<AtomicsFile>,
    pub(super) internal_memory: Option<InternalMemoryFile>,
    pub(super) dram: DramFile,
    pub(super) tiler: TilerFile,
    pub(super) output: OutputFile,
    pub(super) energy: Option<EnergyFile>,
    #[serde(default)]
    pub(super) operating_point: Vec<OperatingPointFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IdentityFile {
    pub(super) name: Spanned<String>,
    pub(super) title: String,
    pub(super) family: Family,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClockFile {
    pub(super) mhz: Sourced<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShaderCoresFile {
    pub(super) count: Sourced<u32>,
    pub(super) warp_width: Sourced<u32>,
    pub(super) warp_pixels: Sourced<[u32; 2]>,
    pub(super) warp_slots: Sourced<u32>,
    pub(super) alu_lanes: Sourced<f64>,
    pub(super) efu_lanes: Sourced<f64>,
    pub(super) scheduler: Sourced<Scheduler>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegistersFile {
    pub(super) vec4: Sourced<u32>,
    pub(super) granularity: Sourced<u32>,
    pub(super) sizes_vec4: Sourced<Vec<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadStoreFile {
    pub(super) bytes_per_clock: Sourced<u32>,
    pub(super) lines_in_flight: Sourced<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TextureFile {
    pub(super) samples_per_clock: Sourced<f64>,
    pub(super) latency_cycles: Sourced<f64>,
    pub(super) lines_in_flight: Sourced<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CacheFile {
    pub(super) name: Spanned<String>,
    pub(super) role: CacheRole,
    pub(super) per: Spanned<PerFile>,
    pub(super) size: Sourced<u64>,
    pub(super) line: Sourced<u64>,
    pub(super) ways: Sourced<WaysFile>,
    pub(super) policy: Sourced<PolicyFile>,
    pub(super) write: Sourced<WritePolicy>,
    pub(super) write_miss: Sourced<WriteMiss>,
    pub(super) latency_cycles: Sourced<f64>,
    pub(super) bytes_per_clock: Sourced<f64>,
    pub(super) banks: Sourced<u32>,
    pub(super) mshrs: Sourced<u32>,
}

/// Who has a copy of a cache to itself.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected \"core\", \"gpu\", or how many cores share a copy")]
pub(super) enum PerFile {
    Cores(u32),
    Word(PerWord),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum PerWord {
    Core,
    Gpu,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "expected a number of ways from 1, or \"full\"")]
pub(super) enum WaysFile {
    Count(u32),
    Word(FullWord),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum FullWord {
    Full,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum PolicyFile {
    Lru,
    Fifo,
    Plru,
    Srrip,
    Random,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathsFile {
    pub(super) ssbo: Sourced<Vec<String>>,
    pub(super) texture: Sourced<Vec<String>>,
    pub(super) private: Sourced<Vec<String>>,
    pub(super) vertex: Sourced<Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RayUnitFile {
    pub(super) scheduling: Sourced<RayScheduling>,
    pub(super) boxes_per_clock: Sourced<f64>,
    pub(super) triangles_per_clock: Sourced<f64>,
    pub(super) rays_together: Sourced<u32>,
    pub(super) lines_in_flight: Sourced<u32>,
    pub(super) return_cycles: Option<Sourced<f64>>,
    pub(super) path: Sourced<Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RayPipelineFile {
    pub(super) linked_shaders: Sourced<u32>,
    pub(super) inlined_shaders: Sourced<u32>,
    pub(super) emulates_hit_queries: Sourced<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TranslationFile {
    pub(super) page_bytes: Sourced<u64>,
    pub(super) entries: Sourced<u32>,
    pub(super) walk_ns: Sourced<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AtomicsFile {
    pub(super) lane_clocks: Sourced<f64>,
    pub(super) warp_clocks: Sourced<f64>,
    pub(super) joins_uniform: Sourced<bool>,
    pub(super) shared_lane_clocks: Sourced<f64>,
    pub(super) barrier_clocks: Sourced<f64>,
    pub(super) dispatch_us: Sourced<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InternalMemoryFile {
    pub(super) dma_setup_us: Sourced<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DramFile {
    pub(super) standard: Sourced<String>,
    pub(super) channels: Sourced<u32>,
    pub(super) queue: Sourced<u32>,
    pub(super) peak_gbs: Sourced<f64>,
    pub(super) efficiency: Sourced<f64>,
    pub(super) latency_ns: Sourced<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OutputFile {
    pub(super) bytes_per_pixel: Sourced<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnergyFile {
    pub(super) process: Sourced<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TilerFile {
    pub(super) tile_memory_bytes: Sourced<u32>,
    pub(super) bin_alignment: Sourced<[u32; 2]>,
    pub(super) list_bits_per_triangle: Sourced<u32>,
    pub(super) list_bytes_per_entry: Sourced<u32>,
    pub(super) triangles_per_clock: Sourced<f64>,
    pub(super) pixels_per_clock: Sourced<f64>,
}
