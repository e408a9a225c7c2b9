//! The command line as it is written: the one definition that parsing, help, completions and the man page come from.
//!
//! These are raw settings; [`crate::settings`] and [`crate::machine`] check them and turn them into what the work needs.

mod check;
mod compare;
mod machine;
mod pictures;
mod reflections;
mod sweep;
mod thermal;
mod verify;

pub(crate) use check::{CheckArgs, CheckFormat};
pub(crate) use compare::{CompareArgs, WhatifArgs};
pub(crate) use machine::MachineArgs;
pub(crate) use pictures::{EyesArgs, RenderArgs, StereoArgs};
pub(crate) use reflections::ReflectionArgs;
pub(crate) use sweep::SweepArgs;
pub(crate) use thermal::{SustainedArgs, ThermalArgs};
pub(crate) use verify::{AccuracyArgs, ClaimsArgs, HardwareArgs, StabilityArgs, VerifyArgs, VerifyWhat};

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// Predicts what a ray-traced frame costs a mobile GPU, without the GPU.
///
/// It builds the acceleration structure, traces the frame in software, and replays what every ray fetched and computed
/// through a described GPU: its warps, caches, memory and ALUs. Without a command, it profiles the scene 'atrium' and
/// writes its reports into ./raybudget-out.
#[derive(Debug, Parser)]
#[command(
    name = "raybudget",
    version,
    max_term_width = 100,
    after_help = "Exit codes: 0 done, 1 a check failed, 2 an error in the input or its use."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Report what a scene's frame costs on a GPU.
    Profile(ProfileArgs),
    /// Render a picture of a scene on this machine's CPU, and report how long that took; no GPU is modelled.
    Render(RenderArgs),
    /// Render a scene for two eyes on this machine's CPU, the right image from what the left one shows as far as that goes; with --gpu, report what
    /// both cost there.
    Stereo(StereoArgs),
    /// Record what every ray of a frame visits into a file.
    Trace(TraceArgs),
    /// Report what a recorded frame costs on a GPU; exactly as `profile` would, without tracing again.
    Replay(ReplayArgs),
    /// Report what several frames cost, side by side: traversals, layouts, SAH costs, techniques, GPUs, scenes.
    Compare(CompareArgs),
    /// Report what a recorded frame would cost with other layouts, techniques or GPUs, the best change first.
    Whatif(WhatifArgs),
    /// Report what many frames cost: a grid or a list of options from a file, with the best of them and what each option does.
    Sweep(SweepArgs),
    /// Hold a frame's counters against the limits of a budget file; exit 1 if a hard one is broken.
    Check(CheckArgs),
    /// Hold the model against what others have stated or measured.
    Verify(VerifyArgs),
    /// Count hits and misses of a stream of addresses in a hierarchy of caches.
    Cache(CacheArgs),
    /// List what there is to choose from.
    List(ListArgs),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the manual page, in roff.
    Man {
        /// Of this command; without it, of the whole program.
        subcommand: Option<String>,
    },
}

#[derive(Args, Debug)]
pub(crate) struct ProfileArgs {
    /// Built-in scene, .obj, .obj.zst, .gltf, .glb, or a scene file .toml.
    #[arg(default_value = DEFAULT_SCENE)]
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
    #[command(flatten)]
    pub(crate) sample: SampleArgs,
    #[command(flatten)]
    pub(crate) sustained: SustainedArgs,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// The scene that is profiled when none is named.
pub(crate) const DEFAULT_SCENE: &str = "atrium";

impl ProfileArgs {
    /// What `raybudget` alone stands for.
    pub(crate) fn bare() -> Self {
        Self {
            scene: DEFAULT_SCENE.to_owned(),
            frame: FrameArgs::default(),
            machine: MachineArgs::default(),
            sample: SampleArgs::default(),
            sustained: SustainedArgs::default(),
            report: ReportArgs { format: Format::Text, out: Some(PathBuf::from("raybudget-out")) },
            run: RunArgs::default(),
        }
    }
}

#[derive(Args, Debug)]
pub(crate) struct TraceArgs {
    /// Built-in scene, .obj, .obj.zst, .gltf, .glb, or a scene file .toml.
    pub(crate) scene: String,
    /// The trace file to write.
    #[arg(short, long, value_name = "F.rbt")]
    pub(crate) out: PathBuf,
    /// Trace these rays, each for its closest hit, instead of the camera's: little-endian f32 x 8 per ray, origin xyz,
    /// t_min, direction xyz, t_max.
    #[arg(long, value_name = "RAYS.bin", conflicts_with = "size")]
    pub(crate) rays: Option<PathBuf>,
    /// Write what every primary ray hit: ray,primitive,t,u,v; primitive is the triangle's index in file order; all but
    /// the ray's number empty on a miss.
    #[arg(long, value_name = "HITS.csv")]
    pub(crate) hits: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// A form of memory traces.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MissTrace {
    /// DRAMsim3: address, READ or WRITE, and the cycle of the memory's clock.
    Dramsim3,
    /// Ramulator 2: LD or ST and the address, without time.
    Ramulator2,
}

#[derive(Args, Debug)]
pub(crate) struct ReplayArgs {
    /// A trace file that `raybudget trace` wrote.
    #[arg(value_name = "F.rbt")]
    pub(crate) trace: PathBuf,
    /// Also write every request to memory, for a simulator of DRAM; needs --fidelity timed.
    #[arg(long, value_name = "FILE", requires = "fidelity")]
    pub(crate) miss_trace: Option<PathBuf>,
    /// Whose form the requests are written in.
    #[arg(long, value_enum, default_value_t = MissTrace::Dramsim3, requires = "miss_trace")]
    pub(crate) miss_trace_format: MissTrace,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
    #[command(flatten)]
    pub(crate) sample: SampleArgs,
    #[command(flatten)]
    pub(crate) report: ReportArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// How a miss-ratio curve is made.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CurveKind {
    /// From stack distances.
    Exact,
    /// From average eviction times: several times faster, and within 0.03 in miss ratio on trees.
    Aet,
}

#[derive(Args, Debug)]
pub(crate) struct CacheArgs {
    /// .din (Dinero: `0|1|2 hex-address`), .csv (`op,address,size`), or .u64 (raw little-endian).
    pub(crate) addresses: PathBuf,
    /// The caches, one `level` table each, from the requester to memory.
    #[arg(long, value_name = "LEVELS.toml")]
    pub(crate) levels: PathBuf,
    /// Also give the misses of a fully associative LRU cache of every size, in lines of the first level, and
    /// what they say of the first level itself.
    #[arg(long, value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "exact")]
    pub(crate) curve: Option<CurveKind>,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
}

#[derive(Args, Debug)]
pub(crate) struct ListArgs {
    #[arg(value_enum)]
    pub(crate) what: Listed,
    /// What to print.
    #[arg(long, value_enum, default_value_t = ListFormat::Text)]
    pub(crate) format: ListFormat,
}

/// How a list is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ListFormat {
    /// For people.
    Text,
    /// For programs.
    Json,
    /// For spreadsheets.
    Csv,
    /// For documents; of counters, the page docs/counters.md.
    Markdown,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listed {
    /// Described GPUs.
    Gpus,
    /// Built-in scenes.
    Scenes,
    /// How a frame is rendered.
    Techniques,
    /// Counters with unit, formula and denominator.
    Counters,
    /// Structures and the traversals that walk them.
    Traversals,
    /// How triangles lie in memory.
    Layouts,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
    /// For spreadsheets.
    Csv,
}

/// Which rays are traced through which structure.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Frame")]
pub(crate) struct FrameArgs {
    /// Acceleration structure [default: bvh].
    #[arg(long, value_parser = PossibleValuesParser::new(["bvh", "wide-bvh", "kd", "grid", "two-level"]))]
    pub(crate) accel: Option<String>,
    /// How rays walk it; see `raybudget list traversals` [default: stack; of a grid: dda].
    #[arg(long, value_name = "T", value_parser = PossibleValuesParser::new(traversal_names()))]
    pub(crate) traversal: Option<String>,
    /// Size of the image in pixels [default: 1024x1024].
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<String>,
    /// Tree: SAH cost of visiting an inner node [default: 3].
    #[arg(long, value_name = "COST", allow_negative_numbers = true)]
    pub(crate) ct: Option<f64>,
    /// Tree: SAH cost of testing a triangle [default: 1.5].
    #[arg(long, value_name = "COST", allow_negative_numbers = true)]
    pub(crate) ci: Option<f64>,
    /// Wide BVH, or both of two levels: children per node, and how their boxes are held [default: compressed-8; short-stack: adreno-8; full stack of two levels: binary nodes].
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(tracer::wide::NodeFormat::ALL.map(tracer::wide::NodeFormat::name)))]
    pub(crate) node_format: Option<String>,
    /// Entries of the short stack of restart-trail and push-down [default: 0], and of short-stack [default: 8].
    #[arg(long, value_name = "N")]
    pub(crate) short_stack: Option<u32>,
    /// Width of the restart trail [default: 32 where the tree's depth allows, else 64].
    #[arg(long, value_name = "BITS", value_parser = PossibleValuesParser::new(["32", "64"]))]
    pub(crate) trail_bits: Option<String>,
    /// What the frame has although the scene does not need it; the report says what it costs. Shadow rays of a scene without light go
    /// to a point above and behind the camera.
    #[arg(long, value_name = "FEATURE", value_delimiter = ',', value_parser = feature_names())]
    pub(crate) force: Vec<String>,
    /// What the frame does not have although the scene needs it; the report says what that saves.
    #[arg(long, value_name = "FEATURE", value_delimiter = ',', value_parser = feature_names())]
    pub(crate) leave_out: Vec<String>,
    /// Which rays follow the primary ones, instead of those that the scene asks for [default: hard-shadows]. Shadow rays also follow
    /// what mirror, glossy and diffuse rays hit.
    #[arg(long, value_name = "SET", value_delimiter = ',', value_parser = PossibleValuesParser::new(crate::ray_sets::names()))]
    pub(crate) ray_sets: Vec<String>,
    /// Rays per pixel of each set that is drawn at random: soft-shadows (and there per light), glossy, ao, diffuse [default: 1].
    #[arg(long, value_name = "N")]
    pub(crate) spp: Option<u32>,
    /// Draws other rays [default: 0].
    #[arg(long, value_name = "N")]
    pub(crate) ray_seed: Option<u32>,
    /// What shadow rays ask for: whether anything is hit, or, as without gl_RayFlagsTerminateOnFirstHitEXT, what is closest
    /// [default: any-hit].
    #[arg(long, value_name = "QUERY", value_parser = PossibleValuesParser::new(tracer::Query::ALL.map(tracer::Query::name)))]
    pub(crate) shadow_query: Option<String>,
    /// How alpha-tested triangles are treated: an any-hit shader tests them, and all others are marked opaque; no triangle is marked, so all
    /// hits go to the shader; rays take all as opaque, or pass through those tested; opacity micromaps spare shaders [default: any-hit].
    #[arg(long, value_name = "MODE", value_parser = PossibleValuesParser::new(tracer::AlphaMode::ALL.map(tracer::AlphaMode::name)))]
    pub(crate) alpha: Option<String>,
    /// Opacity micromaps: how often a triangle is cut in four, 0 to 4 [default: 4].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(tracer::MicromapFormat::MAX_LEVEL)))]
    pub(crate) micromap_level: Option<u32>,
    /// Opacity micromaps: with 4 states an any-hit shader decides what is unknown, with 2 none is run, and hits differ from the mask's
    /// along its outlines [default: 4].
    #[arg(long, value_name = "N", value_parser = PossibleValuesParser::new(tracer::MicromapStates::ALL.map(tracer::MicromapStates::name)))]
    pub(crate) micromap_states: Option<String>,
    /// Radius of the sphere that each light is to soft shadows [default: 1/20 of the scene's radius].
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) light_radius: Option<f32>,
    /// How far rays of ambient occlusion reach [default: 1/10 of the scene's radius].
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(crate) ao_radius: Option<f32>,
    /// How rays are tested against triangles [default: moeller-trumbore]. Costs of operations are those of the default for either.
    #[arg(long, value_name = "TEST", value_parser = PossibleValuesParser::new(tracer::TriangleTest::ALL.map(tracer::TriangleTest::name)))]
    pub(crate) triangle_test: Option<String>,
    /// kd-tree: how large a triangle is in a cell: its clamped box, or exactly the part inside [default: bounding-box].
    #[arg(long, value_name = "KIND", value_parser = PossibleValuesParser::new(["bounding-box", "perfect"]))]
    pub(crate) splits: Option<String>,
    /// kd-tree: whether cells without thickness may be made [default: allowed].
    #[arg(long, value_name = "RULE", value_parser = PossibleValuesParser::new(["allowed", "forbidden"]))]
    pub(crate) flat_cells: Option<String>,
    /// kd-tree: factor on the cost of a split with an empty side [default: 1, no bonus].
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub(crate) empty_bonus: Option<f64>,
    /// kd-tree: longest path from the root, in edges [default: by the number of triangles].
    #[arg(long, value_name = "EDGES")]
    pub(crate) max_depth: Option<u32>,
}

/// The rung that replays a sample.
pub(crate) const SAMPLED: &str = "sampled";

/// How much of a frame is replayed.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Sampling")]
pub(crate) struct SampleArgs {
    /// Replay about this part of the tiles, such as 8%, and say how far each figure may be off [default: 6% with --fidelity sampled].
    #[arg(long, value_name = "PART", conflicts_with_all = ["within", "time_limit"])]
    pub(crate) sample: Option<String>,
    /// Sample until the intervals of the frame time and of the bytes of DRAM are that tight, such as 2%, or that of one counter, such as
    /// frame_time_ms=2%; may be given again. Of frames that are compared, those of the differences from the first, in points. Where a sample
    /// cannot be, everything is replayed.
    #[arg(long, value_name = "[COUNTER=]PART", conflicts_with = "time_limit")]
    pub(crate) within: Vec<String>,
    /// Give the best answer in that time, such as 1s or 500ms.
    #[arg(long, value_name = "TIME")]
    pub(crate) time_limit: Option<String>,
    /// Draws another sample [default: 0].
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
}

#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Output")]
pub(crate) struct ReportArgs {
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write report.html, report.txt, report.json, counters.csv, timeline.json (for ui.perfetto.dev) and heat maps of node fetches, bytes, misses and
    /// divergence into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunArgs {
    /// Worker threads [default: one per core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) threads: Option<u32>,
}

fn feature_names() -> PossibleValuesParser {
    PossibleValuesParser::new(scenes::Feature::ALL.map(scenes::Feature::name))
}

/// Every traversal's name once.
fn traversal_names() -> Vec<&'static str> {
    let mut names = Vec::new();
    for traversal in tracer::Traversal::ALL {
        if !names.contains(&traversal.name()) {
            names.push(traversal.name());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_default_scene_is_built_in_and_the_help_names_it() {
        assert!(scenes::BUILTINS.iter().any(|scene| scene.name == DEFAULT_SCENE));
        let help = Cli::command().render_long_help().to_string();
        assert!(help.contains(&format!("the scene '{DEFAULT_SCENE}'")), "{help}");
    }
}
