//! How reflections are traced over a G-buffer: what is looked up on the screen first, how the other rays are launched and ordered, and how
//! what they hit is shaded (Calvo Lista, Vulkanised 2026).

use super::sourced::{File, Sourced};
use crate::counters::Pass;
use crate::error::Error;
use crate::ordering::{AtomicStrategy, Binning};
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

/// Reflections over a G-buffer, by compute shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reflections {
    /// How rays are looked up on the screen before they are traced.
    pub screen_space: ScreenSpace,
    /// Which lane traces a ray.
    pub launch: Launch,
    /// In which order listed rays are traced.
    pub binning: Binning,
    /// Where a ray starts that the screen had no hit for.
    pub query_origin: QueryOrigin,
    /// Which shader shades what rays hit.
    pub hit_shading: HitShading,
    /// Of a ray-tracing pipeline, which shader sends the shadow ray of a hit.
    pub secondary_query: SecondaryQuery,
    /// Of a ray-tracing pipeline, bytes of a ray's payload, instead of those of the cost table.
    pub payload_bytes: Option<u32>,
    /// Shaders that the scene's triangles are given by their place, instead of those of its materials.
    pub materials: Option<u32>,
    /// How lanes count.
    pub atomics: AtomicStrategy,
    /// Lanes of a workgroup, in pixels; its product is that of workgroups over lists.
    pub workgroup: [u32; 2],
}

macro_rules! choices {
    ($(#[$doc:meta])* $name:ident { $($(#[$choice_doc:meta])* $choice:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$choice_doc])* $choice,)* }

        impl $name {
            /// All of them.
            pub const ALL: [Self; [$($text),*].len()] = [$(Self::$choice),*];

            /// Its name on the command line and in files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$choice => $text,)* }
            }

            /// The choice of that name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|choice| choice.name() == name)
            }
        }
    };
}

choices! {
    /// How reflection rays are looked up on the screen.
    ScreenSpace {
        /// Not at all.
        None = "none",
        /// Pixel by pixel along the ray's line.
        Linear = "linear",
        /// Through a pyramid of the least depths.
        Hierarchical = "hierarchical",
    }
}

choices! {
    /// Which lane traces a ray.
    Launch {
        /// That of its pixel.
        Pixel = "pixel",
        /// One of a dispatch over a list of the rays that are left, which has no holes.
        Buffer = "buffer",
    }
}

choices! {
    /// Where a ray starts that the screen had no hit for.
    QueryOrigin {
        /// On its surface.
        Surface = "surface",
        /// At the last position that the march found free.
        LastPosition = "last-position",
    }
}

choices! {
    /// Which shader shades what rays hit.
    HitShading {
        /// The one that traces, by a switch over all materials.
        Uber = "uber",
        /// One per material, over hits sorted by material.
        VisibilityBuffer = "visibility-buffer",
        /// One per material, the closest-hit shader of a ray-tracing pipeline.
        Pipeline = "pipeline",
        /// The same, from pipeline libraries, which are not linked into one shader.
        PipelineLibrary = "pipeline-library",
    }
}

impl HitShading {
    /// Whether it is that of a ray-tracing pipeline.
    pub fn is_pipeline(self) -> bool {
        matches!(self, Self::Pipeline | Self::PipelineLibrary)
    }

    /// Whether a driver may link its shaders into one.
    pub(crate) fn is_linkable(self) -> bool {
        self == Self::Pipeline
    }
}

choices! {
    /// Which shader of a ray-tracing pipeline sends the shadow ray of a hit, by a ray query.
    SecondaryQuery {
        /// Ray generation, when the closest-hit shader has answered.
        RayGeneration = "ray-generation",
        /// The closest-hit shader.
        HitShader = "hit-shader",
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReflectionsFile {
    screen_space: Spanned<String>,
    launch: Spanned<String>,
    binning: Spanned<String>,
    query_origin: Spanned<String>,
    hit_shading: Spanned<String>,
    secondary_query: Option<Spanned<String>>,
    atomics: Spanned<String>,
    workgroup: Sourced<[u32; 2]>,
}

/// Bytes of a payload: no more than the registers of a lane hold.
pub(super) const PAYLOAD_BYTES: RangeInclusive<u32> = 4..=1024;
/// Shaders of a scene: at most one for each cell of its box.
const MATERIALS: RangeInclusive<u32> = 1..=512;
/// Lanes that a workgroup of Vulkan may have at least (`maxComputeWorkGroupInvocations`).
const MOST_LANES: u32 = 1024;

impl Reflections {
    pub(super) fn read(file: &File<'_>, raw: &Spanned<ReflectionsFile>) -> Result<Self, Error> {
        let span = raw.span();
        let raw = raw.get_ref();
        const WORKGROUP: &str = "reflections.workgroup";
        let workgroup = *file.sourced(WORKGROUP, &raw.workgroup)?;
        let fits = |edge: u32| edge.is_power_of_two() && edge <= tracer::TILE_EDGE;
        if !workgroup.into_iter().all(fits) || workgroup[0] * workgroup[1] > MOST_LANES {
            let [width, height] = workgroup;
            let problem =
                format!("is [{width}, {height}], expected two powers of two from 1 to {}", tracer::TILE_EDGE);
            return Err(file.refuse(WORKGROUP, &raw.workgroup.value.span(), problem, "correct the value"));
        }
        let read = Self {
            screen_space: choice(file, "screen_space", &raw.screen_space, ScreenSpace::from_name)?,
            launch: choice(file, "launch", &raw.launch, Launch::from_name)?,
            binning: Binning::from_name(raw.binning.get_ref()).map_err(|error| {
                let problem = format!("is \"{}\": {error}", raw.binning.get_ref());
                file.refuse("reflections.binning", &raw.binning.span(), problem, "correct the name")
            })?,
            query_origin: choice(file, "query_origin", &raw.query_origin, QueryOrigin::from_name)?,
            hit_shading: choice(file, "hit_shading", &raw.hit_shading, HitShading::from_name)?,
            secondary_query: match &raw.secondary_query {
                Some(name) => choice(file, "secondary_query", name, SecondaryQuery::from_name)?,
                None => SecondaryQuery::RayGeneration,
            },
            payload_bytes: None,
            materials: None,
            atomics: choice(file, "atomics", &raw.atomics, AtomicStrategy::from_name)?,
            workgroup,
        };
        read.check()
            .map_err(|problem| file.refuse("reflections", &span, problem, "change one of the two"))?;
        Ok(read)
    }

    /// Says which of its parts contradict each other.
    ///
    /// # Errors
    /// A sentence without a subject.
    pub fn check(&self) -> Result<(), &'static str> {
        if self.payload_bytes.is_some_and(|bytes| !PAYLOAD_BYTES.contains(&bytes)) {
            return Err("has a payload of other than 4 to 1024 bytes");
        }
        if self.materials.is_some_and(|materials| !MATERIALS.contains(&materials)) {
            return Err("has other than 1 to 512 materials");
        }
        let of_pipelines =
            self.payload_bytes.is_some() || self.secondary_query != SecondaryQuery::RayGeneration;
        if of_pipelines && !self.hit_shading.is_pipeline() {
            return Err(
                "has a payload or hit shaders, and no pipeline: hit_shading is none of pipeline and pipeline-library",
            );
        }
        if self.launch == Launch::Pixel && self.binning != Binning::None {
            return Err("bins rays that no buffer lists: launch = \"pixel\"");
        }
        if self.launch == Launch::Pixel && self.hit_shading == HitShading::VisibilityBuffer {
            return Err("sorts hits of rays that no buffer lists: launch = \"pixel\"");
        }
        if self.screen_space == ScreenSpace::None && self.query_origin == QueryOrigin::LastPosition {
            return Err("starts rays where a march ended, and there is none: screen_space = \"none\"");
        }
        Ok(())
    }

    /// Whether its rays are those of a pipeline whose hit shaders send ray queries.
    pub fn sends_hit_queries(&self) -> bool {
        self.hit_shading.is_pipeline() && self.secondary_query == SecondaryQuery::HitShader
    }

    /// The passes of a frame, in order.
    pub(super) fn passes(&self) -> Vec<Pass> {
        let sorted = self.hit_shading == HitShading::VisibilityBuffer;
        let has = |pass: &Pass| match pass {
            Pass::ScreenSpace | Pass::Reflection => true,
            Pass::BucketCount | Pass::BucketOffset | Pass::BucketCopy | Pass::HitShading => sorted,
            _ => false,
        };
        Pass::ALL.into_iter().filter(has).collect()
    }
}

fn choice<T>(
    file: &File<'_>,
    key: &str,
    name: &Spanned<String>,
    from_name: impl Fn(&str) -> Option<T>,
) -> Result<T, Error> {
    from_name(name.get_ref()).ok_or_else(|| {
        let problem = format!("is \"{}\", which is no choice", name.get_ref());
        file.refuse(
            &format!("reflections.{key}"),
            &name.span(),
            problem,
            "name one that `raybudget profile --help` lists",
        )
    })
}
