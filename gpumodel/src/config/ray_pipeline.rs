//! What a GPU's driver makes of ray-tracing pipelines.

use super::gpu_file::RayPipelineFile;
use super::sourced::File;
use crate::error::Error;

/// Limits of a driver for ray-tracing pipelines (Calvo Lista, Vulkanised 2026).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayPipeline {
    /// Shaders of a pipeline, ray generation included, up to which they are linked into one; 0 where none are.
    pub linked_shaders: u32,
    /// Shaders that one pipeline may inline, each once per call.
    pub inlined_shaders: u32,
    /// Whether rays of a pipeline whose hit shaders send ray queries are walked by shaders, although there is a ray unit.
    pub emulates_hit_queries: bool,
}

/// Shaders of a pipeline that a description may name.
const MOST_SHADERS: u32 = 1 << 16;

pub(super) fn ray_pipeline(file: &File<'_>, raw: &RayPipelineFile) -> Result<RayPipeline, Error> {
    let count = |key: &str, figure| file.within(&format!("ray_pipeline.{key}"), figure, 0..=MOST_SHADERS);
    Ok(RayPipeline {
        linked_shaders: count("linked_shaders", &raw.linked_shaders)?,
        inlined_shaders: count("inlined_shaders", &raw.inlined_shaders)?,
        emulates_hit_queries: *file
            .sourced("ray_pipeline.emulates_hit_queries", &raw.emulates_hit_queries)?,
    })
}
