//! Options of pictures that this machine's CPU renders.

use super::{FrameArgs, MachineArgs, RunArgs};
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// Built-in scene, .obj, .obj.zst, .gltf, .glb, or a scene file .toml.
    pub(crate) scene: String,
    /// The picture to write.
    #[arg(short, long, value_name = "IMAGE.png")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Args, Debug)]
pub(crate) struct StereoArgs {
    /// Built-in scene, .obj, .obj.zst, .gltf, .glb, or a scene file .toml.
    pub(crate) scene: String,
    /// The folder for the pictures: both eyes, which pixels of the right one were traced, and how far it is from one that is traced whole; with
    /// --gpu also for the reports of both eyes, traced and with reuse.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) eyes: EyesArgs,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Where the eyes are.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
#[command(next_help_heading = "Eyes")]
pub(crate) struct EyesArgs {
    /// From one eye to the other, in units of the scene [default: a thirtieth of the depth of the nearest surface].
    #[arg(long, value_name = "LENGTH")]
    pub(crate) interaxial: Option<f64>,
    /// Depth at which a point has the same place in both images, in units of the scene, or inf for parallel views [default: that of
    /// the camera's target].
    #[arg(long, value_name = "LENGTH")]
    pub(crate) convergence: Option<f64>,
}
