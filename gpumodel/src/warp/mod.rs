//! Replays the warps of a tile in lockstep: counts what they issue, and lists the lines that they touch.

mod distinct;
mod emit;
mod levels;
mod lockstep;
mod pairs;
mod prefixes;
mod program;
mod ray_unit;
mod seam;
mod steps;
mod stream;

pub(crate) use distinct::Distinct;
pub(crate) use emit::Emitter;
pub(crate) use program::Program;
pub(crate) use seam::TreeTurns;
pub(crate) use steps::{Stepper, Walk, WarpSteps};
pub(crate) use stream::{PADDING, Run, StreamWriter, TileStream, TileStreams, Turn};
