//! How a frame is rendered: which passes it has.

use super::reflection_technique::{HitShading, Reflections, ReflectionsFile};
use super::sourced::{File, Sourced, Tag, tags};
use super::stereo::{Stereo, StereoFile};
use crate::counters::Pass;
use crate::error::Error;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// A technique that comes with the program.
pub struct BuiltinTechnique {
    /// Its name on the command line.
    pub name: &'static str,
    /// The text of its file.
    pub toml: &'static str,
}

/// A technique of `configs/techniques`, called as its file is.
macro_rules! builtin {
    ($name:literal) => {
        BuiltinTechnique {
            name: $name,
            toml: include_str!(concat!("../../../configs/techniques/", $name, ".toml")),
        }
    };
}

/// All techniques that come with the program.
pub const TECHNIQUES: &[BuiltinTechnique] = &[
    builtin!("fragment"),
    builtin!("compute"),
    builtin!("hybrid"),
    builtin!("hybrid-resolved"),
    builtin!("reflections-direct"),
    builtin!("reflections-hybrid-direct"),
    builtin!("reflections-hybrid"),
    builtin!("reflections-hybrid-sign"),
    builtin!("reflections-hybrid-octahedral"),
    builtin!("reflections-hybrid-position"),
    builtin!("reflections-hybrid-position-sign"),
    builtin!("reflections-visibility-buffer"),
    builtin!("reflections-pipeline"),
    builtin!("stereo"),
    builtin!("stereo-in-place"),
    builtin!("stereo-memory"),
];

/// Bytes of a vertex's position, and of its normal.
pub(crate) const VECTOR_BYTES: u32 = 12;

/// The passes of a frame, in the order raster, trace, present.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Technique {
    /// Short name.
    pub name: String,
    /// One line.
    pub title: String,
    /// Rasterises the geometry first; without it primary rays are traced.
    pub raster: Option<Raster>,
    /// The stage that traces.
    pub stage: Stage,
    /// Draws what a compute stage has written.
    pub present: Option<Present>,
    /// Reflections over the G-buffer of a frame that has been drawn before, instead of any of these.
    pub reflections: Option<Reflections>,
    /// How another eye is given what this one has hit, in frames of two.
    pub stereo: Option<Stereo>,
    tags: Vec<(String, Tag)>,
}

/// Rasterisation of the geometry into normal and depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Bytes from vertex to vertex, normals among them; three vertices per triangle.
    pub vertex_bytes: u32,
    /// Where normal and depth are between the passes.
    pub attachments: Attachments,
}

/// Where attachments are between the pass that writes and the pass that reads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Attachments {
    /// In tile memory: framebuffer fetch, no DRAM.
    Tile,
    /// Written to DRAM, read as textures.
    Memory,
}

/// What kind of shader traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A fragment shader: warps of 2x2 quads, colour to tile memory.
    Fragment,
    /// A compute shader: warps of rows of a workgroup, colour to an image.
    Compute {
        /// Lanes of a workgroup, width and height.
        workgroup: [u32; 2],
    },
}

/// A full-screen quad that reads an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Present;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TechniqueFile {
    technique: Spanned<IdentityFile>,
    raster: Option<Spanned<RasterFile>>,
    trace: Option<Spanned<TraceFile>>,
    present: Option<Spanned<PresentFile>>,
    reflections: Option<Spanned<ReflectionsFile>>,
    stereo: Option<Spanned<StereoFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct IdentityFile {
    name: Spanned<String>,
    title: String,
    source: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RasterFile {
    vertex_bytes: Sourced<u32>,
    attachments: Attachments,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TraceFile {
    stage: StageFile,
    primary: Spanned<bool>,
    workgroup: Option<Sourced<[u32; 2]>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum StageFile {
    Fragment,
    Compute,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PresentFile {
    source: Spanned<String>,
}

impl Technique {
    /// Reads and checks a technique; `file_name` is for messages only.
    ///
    /// # Errors
    /// Names the file, the line, the key, what was expected and the remedy.
    pub fn parse(toml_text: &str, file_name: &str) -> Result<Self, Error> {
        let file = File::new(file_name, toml_text);
        let raw: TechniqueFile = file.read()?;
        let identity = raw.technique.get_ref();
        file.said("technique.source", &identity.source)?;
        if identity.name.get_ref().is_empty() {
            return Err(file.refuse(
                "technique.name",
                &identity.name.span(),
                "is empty",
                "name the technique",
            ));
        }
        if let Some(reflections) = &raw.reflections {
            let others = [
                ("raster", raw.raster.as_ref().map(Spanned::span)),
                ("trace", raw.trace.as_ref().map(Spanned::span)),
                ("present", raw.present.as_ref().map(Spanned::span)),
                ("stereo", raw.stereo.as_ref().map(Spanned::span)),
            ];
            for (key, span) in others {
                if let Some(span) = span {
                    let problem = "stands beside [reflections], whose G-buffer has been drawn before";
                    return Err(file.refuse(key, &span, problem, "leave out one of them"));
                }
            }
            let reflections = Reflections::read(&file, reflections)?;
            let IdentityFile { name, title, .. } = raw.technique.into_inner();
            return Ok(Self {
                name: name.into_inner(),
                title,
                raster: None,
                stage: Stage::Compute { workgroup: reflections.workgroup },
                present: None,
                reflections: Some(reflections),
                stereo: None,
                tags: tags(toml_text),
            });
        }
        let Some(trace) = raw.trace else {
            let problem = "has neither [trace] nor [reflections]";
            return Err(file.refuse("technique", &raw.technique.span(), problem, "add one of them"));
        };
        let raster = raw.raster.as_ref().map(|raster| read_raster(&file, raster.get_ref())).transpose()?;
        let trace_span = trace.span();
        let trace = trace.into_inner();
        let primary = *trace.primary.get_ref();
        if primary == raster.is_some() {
            let (problem, remedy) = if primary {
                ("is true, and [raster] finds the same hits", "leave out [raster], or set it to false")
            } else {
                (
                    "is false, and nothing else finds the hits that shadow rays start from",
                    "add [raster], or set it to true",
                )
            };
            return Err(file.refuse("trace.primary", &trace.primary.span(), problem, remedy));
        }
        let stage = read_stage(&file, &trace, &trace_span)?;
        if let Some(present) = &raw.present {
            file.said("present.source", &present.get_ref().source)?;
        }
        let compute = matches!(stage, Stage::Compute { .. });
        let stereo = raw.stereo.as_ref().map(|stereo| stereo.get_ref().read(&file)).transpose()?;
        if let Some(span) = raw.stereo.as_ref().filter(|_| !compute).map(Spanned::span) {
            let problem = "is of kernels that hand pixels on to each other, and the stage is fragment";
            return Err(file.refuse("stereo", &span, problem, "use the compute stage"));
        }
        if let Some(span) = raw.present.as_ref().filter(|_| stereo.is_some()).map(Spanned::span) {
            let problem = "draws an image, and [stereo] has its colours in tiles";
            return Err(file.refuse("present", &span, problem, "leave out one of them"));
        }
        if stereo.is_none() && compute != raw.present.is_some() {
            let (problem, remedy) = if compute {
                ("is compute, whose image nothing draws", "add [present]")
            } else {
                ("is fragment, which writes no image for [present] to draw", "leave out [present]")
            };
            return Err(file.refuse("trace.stage", &trace_span, problem, remedy));
        }
        if compute && raster.is_some() {
            let problem = "is compute, which cannot read the attachments of [raster] from tile memory";
            return Err(file.refuse("trace.stage", &trace_span, problem, "use the fragment stage"));
        }
        let IdentityFile { name, title, .. } = raw.technique.into_inner();
        Ok(Self {
            name: name.into_inner(),
            title,
            raster,
            stage,
            present: raw.present.map(|_| Present),
            reflections: None,
            stereo,
            tags: tags(toml_text),
        })
    }

    /// The technique of that name that comes with the program.
    pub fn builtin(name: &str) -> Option<Result<Self, Error>> {
        let technique = TECHNIQUES.iter().find(|technique| technique.name == name)?;
        Some(Self::parse(technique.toml, &format!("{name}.toml")))
    }

    /// The passes that a frame of this technique has, in order; those of rays that a frame has only on request are not among them.
    pub fn passes(&self) -> Vec<Pass> {
        if let Some(reflections) = &self.reflections {
            return reflections.passes();
        }
        let has = |pass: &Pass| match pass {
            Pass::Binning | Pass::Geometry => self.raster.is_some(),
            Pass::Primary => self.raster.is_none(),
            Pass::Shadow | Pass::Output => true,
            Pass::ErrorDetection | Pass::Reprojection => self.stereo.is_some(),
            Pass::SoftShadow
            | Pass::ScreenSpace
            | Pass::Reflection
            | Pass::BucketCount
            | Pass::BucketOffset
            | Pass::BucketCopy
            | Pass::HitShading
            | Pass::ReflectionShadow
            | Pass::AmbientOcclusion
            | Pass::Diffuse
            | Pass::DiffuseShadow => false,
            Pass::Present => self.present.is_some(),
        };
        Pass::ALL.into_iter().filter(has).collect()
    }

    /// Whether passes of it list what others take.
    pub(crate) fn has_lists(&self) -> bool {
        self.reflections.is_some() || self.stereo.is_some()
    }

    /// The pass after which dirty lines are written back: the last one that shades.
    pub(crate) fn last_shading(&self) -> Pass {
        match &self.reflections {
            None => Pass::Output,
            Some(reflections) if reflections.hit_shading == HitShading::VisibilityBuffer => Pass::HitShading,
            Some(_) => Pass::Reflection,
        }
    }

    /// Dotted keys of its figures that are estimates.
    pub fn estimates(&self) -> Vec<String> {
        let estimates = self.tags.iter().filter(|(_, tag)| *tag == Tag::Estimate);
        estimates.map(|(key, _)| key.clone()).collect()
    }
}

impl Raster {
    /// Bytes from vertex to vertex where vertices have normals, or where those are left out.
    pub(crate) fn vertex_stride(&self, normals: bool) -> u32 {
        if normals { self.vertex_bytes } else { self.vertex_bytes - VECTOR_BYTES }
    }

    /// Names of the attachments that go through DRAM.
    pub fn attachments_in_memory(&self) -> &'static [&'static str] {
        match self.attachments {
            Attachments::Tile => &[],
            Attachments::Memory => &Self::ATTACHMENTS,
        }
    }

    /// What the geometry pass writes, 4 bytes per pixel each.
    pub const ATTACHMENTS: [&'static str; 2] = ["normal", "depth"];
}

fn read_raster(file: &File<'_>, raw: &RasterFile) -> Result<Raster, Error> {
    let vertex_bytes = file.within("raster.vertex_bytes", &raw.vertex_bytes, 2 * VECTOR_BYTES..=4096)?;
    if !vertex_bytes.is_multiple_of(4) {
        let problem = format!("is {vertex_bytes}, expected a multiple of 4");
        let span = raw.vertex_bytes.value.span();
        return Err(file.refuse("raster.vertex_bytes", &span, problem, "correct the value"));
    }
    Ok(Raster { vertex_bytes, attachments: raw.attachments })
}

fn read_stage(file: &File<'_>, raw: &TraceFile, span: &Range<usize>) -> Result<Stage, Error> {
    const KEY: &str = "trace.workgroup";
    match (raw.stage, &raw.workgroup) {
        (StageFile::Fragment, None) => Ok(Stage::Fragment),
        (StageFile::Compute, Some(figure)) => {
            let workgroup = *file.sourced(KEY, figure)?;
            let fits = |edge: u32| edge.is_power_of_two() && edge <= tracer::TILE_EDGE;
            if workgroup.into_iter().all(fits) {
                return Ok(Stage::Compute { workgroup });
            }
            let [width, height] = workgroup;
            let problem =
                format!("is [{width}, {height}], expected two powers of two from 1 to {}", tracer::TILE_EDGE);
            Err(file.refuse(KEY, &figure.value.span(), problem, "correct the value"))
        }
        (StageFile::Compute, None) => {
            Err(file.refuse(KEY, span, "is missing, and the stage is compute", "give a workgroup"))
        }
        (StageFile::Fragment, Some(figure)) => {
            let problem = "is of compute stages, and the stage is fragment";
            Err(file.refuse(KEY, &figure.value.span(), problem, "leave it out"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IN_WORKGROUPS: &str = "stage = \"compute\"\nprimary = true\n# Lanes of a workgroup, in pixels: its warps are rows of it.\n\
                                 workgroup = { value = [8, 8], source = \"the paper gives no size; as compute\", tag = \"estimate\" }\n";

    fn refusal(name: &str, from: &str, to: &str) -> String {
        let text = TECHNIQUES.iter().find(|technique| technique.name == name).expect("built in").toml;
        assert!(text.contains(from), "{name} has '{from}'");
        Technique::parse(&text.replace(from, to), "t.toml").expect_err("it is wrong now").to_string()
    }

    #[test]
    fn every_built_in_technique_is_valid_and_has_its_name() {
        for builtin in TECHNIQUES {
            let technique = Technique::builtin(builtin.name).expect("built in").expect("valid");
            assert_eq!(technique.name, builtin.name);
            assert!(Technique::builtin("forward").is_none());
        }
    }

    #[test]
    fn a_technique_has_the_passes_that_it_needs_and_no_others() {
        use Pass::{Binning, ErrorDetection, Geometry, Output, Present, Primary, Reprojection, Shadow};
        let passes = |name: &str| Technique::builtin(name).expect("built in").expect("valid").passes();
        assert_eq!(passes("fragment"), [Primary, Shadow, Output]);
        assert_eq!(passes("compute"), [Primary, Shadow, Output, Present]);
        assert_eq!(passes("hybrid"), [Binning, Geometry, Shadow, Output]);
        assert_eq!(passes("hybrid-resolved"), passes("hybrid"));
        assert_eq!(passes("stereo"), [ErrorDetection, Primary, Shadow, Output, Reprojection]);
        assert_eq!(passes("stereo-memory"), passes("stereo"));
    }

    #[test]
    fn techniques_that_contradict_themselves_are_refused_with_their_line() {
        for (name, from, to, line, expected) in [
            ("fragment", "primary = true", "primary = false", 11, "add [raster]"),
            ("hybrid", "primary = false", "primary = true", 17, "leave out [raster]"),
            ("compute", "[present]", "[resolve]", 14, "unknown field `resolve`"),
            ("compute", "stage = \"compute\"", "stage = \"fragment\"", 12, "leave it out"),
            ("compute", "value = [8, 8]", "value = [8, 3]", 12, "powers of two"),
            ("compute", "value = [8, 8]", "value = [64, 1]", 12, "powers of two"),
            ("hybrid", "value = 24", "value = 23", 11, "expected 24 to 4096"),
            ("hybrid", "value = 24", "value = 25", 11, "multiple of 4"),
            ("hybrid", "\"tile\"", "\"cloud\"", 13, "unknown variant"),
            ("fragment", "name = \"fragment\"", "name = \"\"", 4, "is empty"),
            ("stereo", "stage = \"compute\"", "stage = \"fragment\"", 13, "leave it out"),
            ("stereo", IN_WORKGROUPS, "stage = \"fragment\"\nprimary = true\n", 13, "use the compute stage"),
            ("stereo", "[stereo]", "[present]\nsource = \"s\"\n[stereo]", 15, "leave out one of them"),
            ("stereo", "colour = 4", "colour = 3", 21, "expected 4, 8, 12 or 16"),
            ("stereo", "normal = 12", "normal = 20", 21, "expected 4, 8, 12 or 16"),
            ("stereo", "value = [32, 16]", "value = [0, 16]", 23, "expected two sides of 1 to 16384"),
            ("stereo", "value = [32, 16]", "value = [16384, 5]", 23, "expected at most 65536 pixels"),
            ("stereo", "value = [32, 16]", "value = [32, 16385]", 23, "expected two sides of 1 to 16384"),
            ("stereo", "\"lists\"", "\"queues\"", 19, "unknown variant"),
        ] {
            let message = refusal(name, from, to);
            assert!(message.starts_with(&format!("t.toml:{line}: ")), "{message}");
            assert!(message.contains(expected), "{message}");
        }
    }
}
