//! Replays the warps of a tile in lockstep: counts what they issue, and lists the lines that they touch.

mod distinct;
mod lockstep;
mod prefixes;
mod program;
mod steps;
mod stream;

pub(crate) use program::{Emitter, Program};
pub(crate) use steps::{Stepper, WarpSteps};
#[cfg(test)]
pub(crate) use stream::StreamWriter;
pub(crate) use stream::{Run, TileStream};
