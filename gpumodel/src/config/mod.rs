//! Descriptions of machines and shaders: TOML in, checked values out. No figure has a default.

mod costs;
mod gpu;
mod gpu_file;
mod sourced;

pub use costs::{Cost, ShaderCosts, SharedCosts, TraversalCosts};
pub use gpu::{
    BuiltinGpu, CacheLevel, CacheRole, Clock, Dram, Family, GPUS, Gpu, Identity, LoadStore, Output, Paths,
    Registers, ShaderCores,
};
pub use sourced::{Provenance, Tag};
