//! Synthetic kernels: warp programs without any ray, as probes of real GPUs run them.
//!
//! A kernel says for each turn of each warp what it computes and which addresses its lanes read or write. It becomes the same
//! stream of turns and lines that a frame does, and runs on the same engines, so that nothing is modelled twice.

mod observe;
mod pattern;
mod run;

pub use observe::Observation;
pub use pattern::{Pages, Pattern, Probe};
pub use run::{KernelResult, run_kernel};

/// How lanes reach memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Route {
    /// As a storage buffer.
    Buffer,
    /// Through the texture unit, which takes one quad of lanes after the other.
    Texture,
}

/// What warps execute.
pub trait Kernel {
    /// Warps of the whole kernel.
    fn warps(&self) -> u32;

    /// Registers of four words per lane, which decide how many warps a core holds.
    fn registers(&self) -> u32;

    /// Puts what `warp` does in its turn number `turn` into `out`, which is empty; false if the warp has ended.
    fn turn(&self, warp: u32, turn: u32, out: &mut KernelTurn) -> bool;
}

/// What a warp does between two waits: it computes, then loads and stores.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KernelTurn {
    /// Instructions on the ALU.
    pub alu: u32,
    /// Instructions on the elementary function unit.
    pub efu: u32,
    /// Loads and stores of the warp, in order. The warp waits for all of its loads.
    pub accesses: Vec<LaneAccess>,
    /// Bytes of tile memory that the warp fills, which go to DRAM past the caches.
    pub output_bytes: u32,
}

/// One load or store of a warp.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LaneAccess {
    /// How it reaches memory; textures are only read.
    pub route: Route,
    /// Whether it stores.
    pub write: bool,
    /// Bytes of each lane, at most 16.
    pub bytes: u32,
    /// Addresses of each lane: the texels of a filtered sample, or 1.
    pub per_lane: u32,
    /// Where the bytes of each active lane begin, at multiples of `bytes`, lane after lane.
    pub addresses: Vec<u64>,
}
