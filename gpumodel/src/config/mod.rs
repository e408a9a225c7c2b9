//! Descriptions of machines and shaders: TOML in, checked values out. No figure has a default.

mod alpha;
mod atomics;
mod costs;
mod energy_table;
mod gpu;
mod gpu_checks;
mod gpu_file;
mod gpu_presets;
mod intersection_costs;
mod level_costs;
mod operating_points;
mod ray_pipeline;
mod ray_unit;
mod reflection_technique;
mod reflections;
mod sourced;
mod stereo;
mod technique;
mod translation;

pub(crate) use alpha::AlphaCosts;
pub use atomics::Atomics;
pub use costs::{Cost, RayQueryCosts, ShaderCosts, SharedCosts, TraversalCosts};
pub(crate) use costs::{SecondaryCosts, has_secondary};
pub use energy_table::{Boundary, EnergyTable};
pub(crate) use energy_table::{
    DramFigures, LeakageFigures, Logic, LogicFigure, Process, RailFigures, RailLaw,
};
pub use gpu::{
    CacheLevel, CacheRole, Clock, Dram, Family, Gpu, GpuEnergy, Identity, LoadStore, Output, Paths,
    Registers, Scheduler, ShaderCores, TextureUnit, Tiler,
};
pub use gpu_presets::{BuiltinGpu, GPUS};
pub use operating_points::OperatingPoint;
pub use ray_pipeline::RayPipeline;
pub use ray_unit::{RayScheduling, RayUnit};
pub use reflection_technique::{HitShading, Launch, QueryOrigin, Reflections, ScreenSpace, SecondaryQuery};
pub use reflections::{PipelineCosts, ReflectionCosts, ReflectionRegisters};
pub use sourced::{Provenance, Tag};
pub use stereo::{GBufferFields, InternalMemory, Stereo, StereoCosts, StereoLaunch};
pub(crate) use technique::VECTOR_BYTES;
pub use technique::{Attachments, BuiltinTechnique, Present, Raster, Stage, TECHNIQUES, Technique};
pub use translation::Translation;
