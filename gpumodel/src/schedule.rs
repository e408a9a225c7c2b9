//! Which pixel becomes which lane of which warp, and how many warps a core holds.

use crate::config::Gpu;
use crate::error::Error;
use tracer::{Frame, TILE_EDGE, TILE_RAYS, TileRect, TraceHeader};

/// No ray: a lane outside the image, a helper.
pub(crate) const HELPER: u32 = u32::MAX;

/// The lanes of a tile.
///
/// An image is shaded in 2x2 quads, as a rasteriser emits them. A warp takes a block of
/// [`warp_pixels`](crate::ShaderCores::warp_pixels), its quads in Z order; the warps of a 32x32 tile follow in Z order too. At the
/// right and lower edge of the image, lanes outside it are idle. Rays of a list fill warps one after the other.
pub(crate) struct LaneMap {
    /// Place within a full tile of each lane, warp after warp.
    places: Vec<(u32, u32)>,
    warp_width: usize,
    list: bool,
}

impl LaneMap {
    pub(crate) fn new(gpu: &Gpu, frame: Frame) -> Self {
        let [width, height] = gpu.cores.warp_pixels;
        let list = matches!(frame, Frame::List { .. });
        let places = if list {
            (0..TILE_RAYS).map(|ray| (ray, 0)).collect()
        } else {
            let mut warps: Vec<_> = grid(TILE_EDGE / width, TILE_EDGE / height).collect();
            warps.sort_by_key(|&(x, y)| z_order(x, y));
            let mut quads: Vec<_> = grid(width / 2, height / 2).collect();
            quads.sort_by_key(|&(x, y)| z_order(x, y));
            let mut places = Vec::with_capacity(TILE_RAYS as usize);
            for (warp_x, warp_y) in warps {
                for &(quad_x, quad_y) in &quads {
                    let (x, y) = (warp_x * width + 2 * quad_x, warp_y * height + 2 * quad_y);
                    places.extend([(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]);
                }
            }
            places
        };
        Self { places, warp_width: gpu.cores.warp_width as usize, list }
    }

    /// For each warp of a tile that has any ray, the ray of each lane within the tile, or [`HELPER`].
    pub(crate) fn warps(&self, rect: TileRect) -> impl Iterator<Item = Vec<u32>> {
        let inside = move |&(x, y): &(u32, u32)| {
            let within = x < rect.width && y < rect.height;
            if within { y * rect.width + x } else { HELPER }
        };
        let warp = move |places: &[(u32, u32)]| places.iter().map(inside).collect::<Vec<_>>();
        debug_assert!(!self.list || rect.height == 1);
        self.places.chunks(self.warp_width).map(warp).filter(|lanes| lanes.iter().any(|&ray| ray != HELPER))
    }
}

fn grid(columns: u32, rows: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

/// Morton code: the bits of both coordinates interleaved, x in the lowest.
fn z_order(x: u32, y: u32) -> u32 {
    (0..16).fold(0, |code, bit| code | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1))
}

/// Warps that a core holds at once, by the rule of Mesa's `ir3_get_reg_dependent_max_waves`:
/// `vec4 / registers * granularity`, the quotient rounded down, and at most the slots.
///
/// # Errors
/// When a lane needs more registers than the file has.
pub(crate) fn resident_warps(gpu: &Gpu, registers: u32, header: &TraceHeader) -> Result<u32, Error> {
    let warps = gpu.registers.vec4 / registers * gpu.registers.granularity;
    if warps == 0 {
        return Err(Error::Trace {
            scene: header.scene.clone(),
            problem: format!(
                "its shader needs {registers} vec4 registers per lane, {} has {}",
                gpu.name(),
                gpu.registers.vec4
            ),
            remedy: "shorten the short stack".to_owned(),
        });
    }
    Ok(warps.min(gpu.cores.warp_slots))
}
