//! Replays the warps of a tile in lockstep: counts what they issue, and lists the lines that they touch.

mod distinct;
mod lockstep;
mod program;
mod stream;

pub(crate) use program::{Program, TileReplay};
#[cfg(test)]
pub(crate) use stream::StreamWriter;
pub(crate) use stream::{Pass, Run, TileStream};
