//! Options of techniques of reflections.

use clap::Args;
use clap::builder::PossibleValuesParser;

/// Parts of a technique of reflections, instead of those in its file.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub(crate) struct ReflectionArgs {
    /// How reflection rays are looked up on the screen before they are traced.
    #[arg(long, value_name = "HOW", value_parser = PossibleValuesParser::new(gpumodel::ScreenSpace::ALL.map(gpumodel::ScreenSpace::name)))]
    pub(crate) screen_space: Option<String>,
    /// Which lanes trace the rays that are left: those of their pixels, or those of a dispatch over a buffer.
    #[arg(long, value_name = "LANES", value_parser = PossibleValuesParser::new(gpumodel::Launch::ALL.map(gpumodel::Launch::name)))]
    pub(crate) launch: Option<String>,
    /// Into which bins workgroups sort the rays of the buffer: none, sign, octahedral-4x4, position-2, position-sign-1, or other numbers.
    #[arg(long, value_name = "BINS")]
    pub(crate) binning: Option<String>,
    /// Where rays start that the screen had no hit for.
    #[arg(long, value_name = "PLACE", value_parser = PossibleValuesParser::new(gpumodel::QueryOrigin::ALL.map(gpumodel::QueryOrigin::name)))]
    pub(crate) query_origin: Option<String>,
    /// Which shader shades what rays hit: the one that traces, one per material over sorted hits, or one per material in a ray-tracing pipeline, linked
    /// where the GPU's driver does so, or from libraries.
    #[arg(long, value_name = "SHADER", value_parser = PossibleValuesParser::new(gpumodel::HitShading::ALL.map(gpumodel::HitShading::name)))]
    pub(crate) hit_shading: Option<String>,
    /// Of a ray-tracing pipeline, which shader sends the shadow ray of a hit.
    #[arg(long, value_name = "SHADER", value_parser = PossibleValuesParser::new(gpumodel::SecondaryQuery::ALL.map(gpumodel::SecondaryQuery::name)))]
    pub(crate) secondary_query: Option<String>,
    /// Of a ray-tracing pipeline, bytes of a ray's payload, from 4 to 1024, instead of those of the cost table.
    #[arg(long, value_name = "BYTES")]
    pub(crate) payload: Option<String>,
    /// Gives the scene so many materials of its own shader, from 1 to 512, by the place of each triangle.
    #[arg(long, value_name = "N")]
    pub(crate) materials: Option<String>,
    /// How the lanes of a warp add to counters in memory.
    #[arg(long, value_name = "STRATEGY", value_parser = PossibleValuesParser::new(gpumodel::ordering::AtomicStrategy::ALL.map(gpumodel::ordering::AtomicStrategy::name)))]
    pub(crate) atomics: Option<String>,
}

impl ReflectionArgs {
    /// Names and values of the options that were given.
    pub(crate) fn given(&self) -> Vec<(&'static str, &str)> {
        let Self {
            screen_space,
            launch,
            binning,
            query_origin,
            hit_shading,
            secondary_query,
            payload,
            materials,
            atomics,
        } = self;
        [
            ("screen-space", screen_space),
            ("launch", launch),
            ("binning", binning),
            ("query-origin", query_origin),
            ("hit-shading", hit_shading),
            ("secondary-query", secondary_query),
            ("payload", payload),
            ("materials", materials),
            ("atomics", atomics),
        ]
        .into_iter()
        .filter_map(|(option, value)| Some((option, value.as_deref()?)))
        .collect()
    }
}
