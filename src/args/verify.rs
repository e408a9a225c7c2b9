//! Options of checks of the model.

use super::{Format, RunArgs, ThermalArgs};
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct VerifyArgs {
    #[command(subcommand)]
    pub(crate) what: VerifyWhat,
}

#[derive(Debug, Subcommand)]
pub(crate) enum VerifyWhat {
    /// Say for each statement of a paper whether the model reproduces it.
    Claims(ClaimsArgs),
    /// Say how far the quick rung of fidelity is from the simulated one, frame by frame.
    Accuracy(AccuracyArgs),
    /// Run the access patterns of published measurements of real GPUs; exit code 1 when a row or a mean misses its limit.
    Hardware(HardwareArgs),
    /// Drive tracer, solvers and models to the ends of their ranges; exit code 1 when a case misses its limit.
    Stability(StabilityArgs),
    /// Hold the simulation of temperatures against closed forms, its integrators against each other; exit code 1 when a case misses its
    /// limit.
    Thermal(ThermalArgs),
}

#[derive(Args, Debug)]
pub(crate) struct HardwareArgs {
    /// Only the rows of this GPU.
    #[arg(long, value_name = "NAME")]
    pub(crate) gpu: Option<String>,
    /// How the judging time is found: timed or replay. The other stands beside it.
    #[arg(long, default_value = "timed", value_parser = ["timed", "replay"])]
    pub(crate) fidelity: String,
    /// Only the judging rung.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write the table and charts of the model beside what was published into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct ClaimsArgs {
    /// The paper: A is Sousa et al. 2019, acceleration structures on a mobile GPU; B is Lee et al. 2017, two eyes; C is Calvo Lista 2026, ray tracing and reflections on
    /// Mali GPUs.
    #[arg(long, value_name = "LETTER")]
    pub(crate) paper: String,
    /// Folder with the paper's scenes; built-in ones stand in for those that are not there.
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
    /// Only see that it works: built-in scenes and small images.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write the verdicts, and for A the counterparts of its charts and heat maps, into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct AccuracyArgs {
    /// Built-in scene, .obj, .obj.zst, .gltf, .glb, or a scene file .toml; may be given again [default: cornell,
    /// teapot, stadium, figure, atrium, soup].
    #[arg(long, value_name = "SCENE")]
    pub(crate) scene: Vec<String>,
    /// A described GPU by name, or a file that describes one; may be given again [default: adreno-540, adreno-640, mali-g78,
    /// mali-g715].
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    pub(crate) gpu: Vec<String>,
    /// Structure and traversal; may be given again [default: bvh-parent-link, bvh-restart-trail, kd-push-down, kd-backtrack].
    #[arg(long, value_name = "T", value_delimiter = ',')]
    pub(crate) traversal: Vec<String>,
    /// Size of the images in pixels [default: 256x256].
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<String>,
    /// Hold samples against the replay instead of the replay against the simulation [default: scene soup, 1024x1024, bvh-stack,
    /// adreno-540].
    #[arg(long)]
    pub(crate) samples: bool,
    /// Samples of each part [default: 20].
    #[arg(long, value_name = "N", requires = "samples", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) seeds: Option<u32>,
    /// A part of the tiles; may be given again [default: 6%, 7.5%, 12%, 25%].
    #[arg(long, value_name = "PART", requires = "samples", value_delimiter = ',')]
    pub(crate) part: Vec<String>,
    /// What a sample of both frames says of a change is held against their replays too, such as layout=split; may be given again
    /// [default: layout=split, node-order=breadth-first].
    #[arg(long, value_name = "AXIS=V+V", requires = "samples", value_delimiter = ',')]
    pub(crate) change: Vec<String>,
    /// Only see that it works: two scenes, two traversals, two GPUs and small images, where these are not given.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write the tables and charts into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct StabilityArgs {
    /// Every case with fewer rays and smaller caches: rates of one in a million are then not seen.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write the table into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
