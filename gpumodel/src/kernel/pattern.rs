//! The access patterns of published probes.

use super::{Kernel, KernelTurn, LaneAccess, Route};
use crate::config::Gpu;
use crate::random::{below, hash, scattered};

/// Bytes of a page of virtual memory.
const PAGE_BYTES: u64 = 4096;
/// Registers of a probe: few, so that as many warps as possible are resident.
const REGISTERS: u32 = 4;
/// Loads that a streaming warp has in flight together.
const UNROLLED: u32 = 4;
/// Bytes of a texel, four channels of 8 bits.
const TEXEL_BYTES: u32 = 4;
/// Edge of a tile of a texture in texels: a page of them, in Morton order, so that 4x4 texels fill a line of 64 bytes.
const TEXTURE_TILE: u32 = 32;
/// Texels of a bilinear sample.
const BILINEAR: u32 = 4;
/// Texels of a looked-up texture along an edge, per pixel of the screen.
const LOOKUP_TEXELS: u32 = 2;
/// Instructions on each side of a branch, and turns of its kernel.
const SIDE_ALU: u32 = 128;

/// Where the pages of a texture or buffer lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pages {
    /// One after the other.
    #[default]
    Contiguous,
    /// Anywhere, as an operating system hands them out: sets of a cache that is addressed physically fill unevenly.
    Scattered,
}

/// A probe. Sizes are bytes, widths those of the GPU's warps.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Pattern {
    /// One lane follows pointers around `footprint` bytes, `stride` apart: each load waits for the one before.
    Chase {
        /// Through which unit.
        route: Route,
        /// Bytes of the ring.
        footprint: u64,
        /// Bytes from one pointer to the next.
        stride: u64,
    },
    /// All lanes read consecutive elements of `footprint` bytes over and over, 64 each as in ArchProbe; if `copies`, each lane reads one and
    /// stores it behind the footprint, as in azhirnov/as-en.
    Stream {
        /// Through which unit.
        route: Route,
        /// Bytes that are read before the first is read again.
        footprint: u64,
        /// Bytes of an element, at most 16.
        element: u32,
        /// Whether each is also written elsewhere.
        #[serde(default)]
        copies: bool,
    },
    /// Each lane takes bilinear samples of a texture of `footprint` bytes, `samples` in flight together: the first at a random place,
    /// the others at the same distances from it, for all lanes. As `TexCache.as` of azhirnov/as-en.
    RandomSamples {
        /// Bytes of the texture.
        footprint: u64,
        /// Samples of a lane.
        samples: u32,
        /// Where its pages lie.
        #[serde(default)]
        pages: Pages,
    },
    /// Each pixel of a screen takes one bilinear sample of a texture of twice as many texels along each edge, and writes a colour. Every
    /// block of `block` x `block` pixels jumps to a random place, or, for 0, none does. As `TexLookup.as` of azhirnov/as-en.
    Lookup {
        /// Edge of a block in pixels, at most 32; 0 for reads in order.
        block: u32,
        /// Edge of the texture in texels, a multiple of 64.
        edge: u32,
        /// By how much coordinates are stretched: neighbours are two texels apart at 1.
        scale: f64,
    },
    /// Two sides of a branch of equal length: all lanes of a warp take the same one, or each lane takes its own.
    Branch {
        /// Whether lanes part.
        divergent: bool,
    },
}

impl Pattern {
    /// The probe on a GPU, `warps` warps of it.
    pub fn on<'a>(&'a self, gpu: &Gpu, warps: u32) -> Probe<'a> {
        Probe { pattern: self, width: gpu.cores.warp_width, pixels: gpu.cores.warp_pixels, warps }
    }

    /// Warps that are enough to fill every core of `gpu` several times and to go around the footprint once.
    pub fn whole(&self, gpu: &Gpu) -> u32 {
        let full = gpu.cores.count * gpu.cores.warp_slots * 4;
        let lanes = gpu.cores.warp_width;
        match *self {
            Self::Chase { footprint, stride, .. } => (footprint / stride).max(1) as u32,
            Self::Stream { footprint, element, copies, .. } => {
                let loads = unrolled(copies) * stream_turns(copies);
                let most = 4 * full * (UNROLLED * STREAM_TURNS / loads);
                let around = footprint.div_ceil(u64::from(lanes * element * loads));
                full.max(around.min(u64::from(most)) as u32)
            }
            Self::RandomSamples { footprint, samples, .. } => {
                full.max((4 * footprint / 64).div_ceil(u64::from(lanes * samples)) as u32)
            }
            Self::Lookup { .. } => 4 * full,
            Self::Branch { .. } => full,
        }
    }

    /// The same on other bytes; a pattern without a footprint stays as it is.
    pub fn with_footprint(&self, bytes: u64) -> Self {
        let mut other = self.clone();
        match &mut other {
            Self::Chase { footprint, .. }
            | Self::Stream { footprint, .. }
            | Self::RandomSamples { footprint, .. } => *footprint = bytes,
            Self::Lookup { .. } | Self::Branch { .. } => {}
        }
        other
    }

    /// The same with other blocks; a pattern without blocks stays as it is.
    pub fn with_block(&self, edge: u32) -> Self {
        let mut other = self.clone();
        if let Self::Lookup { block, .. } = &mut other {
            *block = edge;
        }
        other
    }

    /// Loads of lanes in one warp: pointers of a chase, elements, samples, texels.
    pub fn loads_per_warp(&self, gpu: &Gpu) -> u64 {
        let lanes = u64::from(gpu.cores.warp_width);
        match *self {
            Self::Chase { .. } => 1,
            Self::Stream { copies, .. } => lanes * u64::from(unrolled(copies) * stream_turns(copies)),
            Self::RandomSamples { samples, .. } => lanes * u64::from(samples),
            Self::Lookup { .. } | Self::Branch { .. } => lanes,
        }
    }

    /// Bytes that lanes ask for in one warp, read and written.
    pub fn bytes_per_warp(&self, gpu: &Gpu) -> u64 {
        let loads = self.loads_per_warp(gpu);
        match *self {
            Self::Chase { .. } => loads * u64::from(TEXEL_BYTES),
            Self::RandomSamples { .. } | Self::Lookup { .. } => loads * u64::from(BILINEAR * TEXEL_BYTES),
            Self::Stream { element, copies, .. } => loads * u64::from(element) * if copies { 2 } else { 1 },
            Self::Branch { .. } => 0,
        }
    }
}

/// Turns of a streaming warp: with [`UNROLLED`], 64 loads, as ArchProbe's.
const STREAM_TURNS: u32 = 16;

/// Loads of a stream in flight together.
fn unrolled(copies: bool) -> u32 {
    if copies { 1 } else { UNROLLED }
}

/// Turns of a stream that load.
fn stream_turns(copies: bool) -> u32 {
    if copies { 1 } else { STREAM_TURNS }
}

/// A pattern with a number of warps; of a chase, with a number of pointers.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'a> {
    pattern: &'a Pattern,
    width: u32,
    pixels: [u32; 2],
    warps: u32,
}

impl Kernel for Probe<'_> {
    fn warps(&self) -> u32 {
        if matches!(self.pattern, Pattern::Chase { .. }) { 1 } else { self.warps }
    }

    fn registers(&self) -> u32 {
        REGISTERS
    }

    fn turn(&self, warp: u32, turn: u32, out: &mut KernelTurn) -> bool {
        match *self.pattern {
            Pattern::Chase { route, footprint, stride } => {
                let address = u64::from(turn) * stride % footprint;
                out.accesses.push(load(route, TEXEL_BYTES, vec![address]));
                turn < self.warps
            }
            Pattern::Stream { route, footprint, element, copies } => {
                let (loads, turns) = (unrolled(copies), stream_turns(copies));
                let (part, write) = if copies { (0, turn == 1) } else { (turn, false) };
                for load_number in 0..loads {
                    let row = u64::from(warp * turns + part) * u64::from(loads) + u64::from(load_number);
                    let of_lane =
                        |lane: u32| (row * u64::from(self.width) + u64::from(lane)) * u64::from(element);
                    let behind = if write { footprint.next_multiple_of(PAGE_BYTES) } else { 0 };
                    let addresses = (0..self.width).map(|lane| of_lane(lane) % footprint + behind).collect();
                    let route = if write { Route::Buffer } else { route };
                    out.accesses.push(LaneAccess { route, write, bytes: element, per_lane: 1, addresses });
                }
                turn < turns + u32::from(copies)
            }
            Pattern::RandomSamples { footprint, samples, pages } => {
                let texture = Texture::of(footprint);
                for sample in 0..samples {
                    let of_lane = |lane: u32| {
                        let pixel = u64::from(warp) * u64::from(self.width) + u64::from(lane);
                        let jump =
                            |axis: u64| below(1 << 32, pixel << 1 | axis) as f64 / (1_u64 << 32) as f64;
                        let [x, y] = SAMPLE_OFFSETS[sample as usize % SAMPLE_OFFSETS.len()];
                        texture.bilinear(jump(0) + x, jump(1) + y)
                    };
                    let place = |address: u64| match pages {
                        Pages::Contiguous => address,
                        Pages::Scattered => {
                            scattered(address / PAGE_BYTES) * PAGE_BYTES + address % PAGE_BYTES
                        }
                    };
                    let addresses = (0..self.width).flat_map(of_lane).map(place).collect();
                    out.accesses.push(filtered(addresses));
                }
                turn == 0
            }
            Pattern::Lookup { block, edge, scale } => {
                let texture = Texture { width: edge, height: edge };
                let screen = edge / LOOKUP_TEXELS;
                let of_lane = |lane: u32| {
                    let (x, y) = self.pixel(warp, lane, screen);
                    let jump = |axis: u64| {
                        let number = u64::from(y / block.max(1)) << 32 | u64::from(x / block.max(1));
                        let jumped = below(1 << 32, number << 1 | axis) as f64 / (1_u64 << 32) as f64;
                        if block == 0 { 0.0 } else { jumped }
                    };
                    let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(screen) * scale;
                    texture.bilinear(at(x) + jump(0), at(y) + jump(1))
                };
                out.accesses.push(filtered((0..self.width).flat_map(of_lane).collect()));
                out.output_bytes = self.width * TEXEL_BYTES;
                turn == 0
            }
            Pattern::Branch { divergent } => {
                let side = |lane: u32| {
                    let decides =
                        if divergent { u64::from(warp * self.width + lane) } else { u64::from(warp) };
                    hash(decides) & 1 == 0
                };
                let sides = [true, false].into_iter();
                let taken = sides.filter(|&of| (0..self.width).any(|lane| side(lane) == of)).count();
                out.alu = SIDE_ALU * taken as u32;
                turn == 0
            }
        }
    }
}

impl Probe<'_> {
    /// The pixel of a lane: warps are blocks, which follow each other in Morton order within tiles of 32x32 pixels.
    fn pixel(&self, warp: u32, lane: u32, edge: u32) -> (u32, u32) {
        let [width, height] = self.pixels;
        let per_tile = TEXTURE_TILE * TEXTURE_TILE / self.width;
        let tiles_across = edge / TEXTURE_TILE;
        let (tile, block) = (warp / per_tile, warp % per_tile);
        let (across, down) = (TEXTURE_TILE / width, TEXTURE_TILE / height);
        let (block_x, block_y) = (block % across, block / across % down);
        (
            tile % tiles_across * TEXTURE_TILE + block_x * width + lane % width,
            tile / tiles_across % tiles_across * TEXTURE_TILE + block_y * height + lane / width,
        )
    }
}

/// Where the samples of a pixel lie from its first, as `TexCache.as` has them.
const SAMPLE_OFFSETS: [[f64; 2]; 8] =
    [[0.0, 0.0], [0.1, 0.5], [0.2, 0.6], [0.3, 0.7], [0.4, 0.8], [0.5, 0.9], [0.6, 0.1], [0.7, 0.2]];

/// A texture of 32-bit texels, whose edges are powers of two; it repeats.
struct Texture {
    width: u32,
    height: u32,
}

impl Texture {
    /// As square as `bytes`, a power of two, allow.
    fn of(bytes: u64) -> Self {
        let bits = (bytes / u64::from(TEXEL_BYTES)).max(1).ilog2();
        Self { width: 1 << bits.div_ceil(2), height: 1 << (bits / 2) }
    }

    /// Addresses of the four texels around a place in units of the texture.
    fn bilinear(&self, u: f64, v: f64) -> [u64; BILINEAR as usize] {
        let first = |at: f64, edge: u32| (at * f64::from(edge) - 0.5).floor() as i64 as u32 & (edge - 1);
        let (x, y) = (first(u, self.width), first(v, self.height));
        let (right, below) = ((x + 1) & (self.width - 1), (y + 1) & (self.height - 1));
        [(x, y), (right, y), (x, below), (right, below)].map(|texel| self.address(texel))
    }

    /// Texels lie in tiles of one page, within which they lie in Morton order.
    fn address(&self, (x, y): (u32, u32)) -> u64 {
        let tiles_across = self.width.div_ceil(TEXTURE_TILE);
        let tile = u64::from(y / TEXTURE_TILE) * u64::from(tiles_across) + u64::from(x / TEXTURE_TILE);
        let within = crate::schedule::z_order(x % TEXTURE_TILE, y % TEXTURE_TILE);
        (tile * u64::from(TEXTURE_TILE * TEXTURE_TILE) + u64::from(within)) * u64::from(TEXEL_BYTES)
    }
}

/// Bilinear samples of 32-bit texels.
fn filtered(addresses: Vec<u64>) -> LaneAccess {
    LaneAccess { route: Route::Texture, write: false, bytes: TEXEL_BYTES, per_lane: BILINEAR, addresses }
}

fn load(route: Route, bytes: u32, addresses: Vec<u64>) -> LaneAccess {
    LaneAccess { route, write: false, bytes, per_lane: 1, addresses }
}
