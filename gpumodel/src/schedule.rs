//! Which pixel becomes which lane of which warp, and how many warps a core holds.

use crate::config::{Gpu, Stage};
use crate::error::Error;
use tracer::{Frame, TILE_EDGE, TILE_RAYS, TileRect, TraceHeader};

/// No ray: a lane outside the image, a helper.
pub(crate) const HELPER: u32 = u32::MAX;

/// The lanes of a tile.
///
/// An image is shaded in 2x2 quads, as a rasteriser emits them. A warp takes a block of
/// [`warp_pixels`](crate::ShaderCores::warp_pixels), its quads in Z order; the warps of a 32x32 tile follow in Z order too. At the
/// right and lower edge of the image, lanes outside it are idle.
///
/// A compute shader's workgroups follow each other in rows of the tile; a warp takes whole rows of one, and is filled only in part
/// by a workgroup that is smaller. Rays of a list fill warps one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LaneMap {
    /// Place within a full tile of each lane, warp after warp.
    places: Vec<(u32, u32)>,
    warp_width: usize,
    list: bool,
}

impl LaneMap {
    pub(crate) fn new(gpu: &Gpu, frame: Frame, stage: Stage) -> Self {
        let warp_width = gpu.cores.warp_width as usize;
        let list = matches!(frame, Frame::List { .. });
        match stage {
            _ if list => Self { places: (0..TILE_RAYS).map(|ray| (ray, 0)).collect(), warp_width, list },
            Stage::Fragment => Self { places: quads(gpu.cores.warp_pixels), warp_width, list },
            Stage::Compute { workgroup: [width, height] } => {
                let warp_width = warp_width.min((width * height) as usize);
                let groups = grid(TILE_EDGE / width, TILE_EDGE / height);
                let lanes =
                    |(x, y)| grid(width, height).map(move |(dx, dy)| (x * width + dx, y * height + dy));
                Self { places: groups.flat_map(lanes).collect(), warp_width, list }
            }
        }
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

/// Lanes of fragment warps, as [`LaneMap`] says.
fn quads([width, height]: [u32; 2]) -> Vec<(u32, u32)> {
    let mut warps: Vec<_> = grid(TILE_EDGE / width, TILE_EDGE / height).collect();
    warps.sort_by_key(|&(x, y)| z_order(x * width, y * height));
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
}

fn grid(columns: u32, rows: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

/// Morton code: the bits of both coordinates interleaved, x in the lowest.
pub(crate) fn z_order(x: u32, y: u32) -> u32 {
    (0..16).fold(0, |code, bit| code | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1))
}

/// As [`resident_warps`]; 0 where a lane needs more registers than the file has.
pub(crate) fn warps_that_fit(gpu: &Gpu, registers: u32) -> u32 {
    let sizes = &gpu.registers.sizes_vec4;
    let given = sizes.iter().copied().find(|&size| size >= registers).or(sizes.last().copied());
    let warps = gpu.registers.vec4 / given.unwrap_or(registers.max(1)) * gpu.registers.granularity;
    warps.min(gpu.cores.warp_slots)
}

/// Warps that a core holds at once, by the rule of Mesa's `ir3_get_reg_dependent_max_waves`:
/// `vec4 / registers * granularity`, the quotient rounded down, and at most the slots. Where lanes are given registers in
/// fixed numbers ([`Registers::sizes_vec4`](crate::Registers::sizes_vec4)), the next larger one counts.
///
/// # Errors
/// When a lane needs more registers than the file has.
pub(crate) fn resident_warps(gpu: &Gpu, registers: u32, header: &TraceHeader) -> Result<u32, Error> {
    let warps = warps_that_fit(gpu, registers);
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
    Ok(warps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::{Recorded, gpu};
    use tracer::Accel;

    const WIDE: &[(&str, &str)] =
        &[("value = 32, source", "value = 64, source"), ("value = [8, 4]", "value = [8, 8]")];

    #[test]
    fn a_warp_is_a_block_of_quads_in_z_order() {
        let frame = Frame::Image { width: 32, height: 32 };
        let warps: Vec<_> = LaneMap::new(&gpu(&[]), frame, Stage::Fragment).warps(frame.tile(0)).collect();
        assert_eq!(warps.len(), 32);
        // The first two quads lie side by side, the next two below them.
        assert_eq!(warps[0][..8], [0, 1, 32, 33, 2, 3, 34, 35]);
        assert_eq!(warps[0][8..12], [64, 65, 96, 97]);
        for (warp, first) in warps.iter().zip([0, 4 * 32, 8, 4 * 32 + 8]) {
            assert_eq!(warp[0], first, "blocks of 8x4 in Z order");
            assert!(warp.iter().all(|ray| ray % 32 / 8 == first % 32 / 8 && ray / 128 == first / 128));
        }
    }

    #[test]
    fn every_pixel_is_one_lane_of_one_warp_at_both_widths_and_any_image_edge() {
        for machine in [gpu(&[]), gpu(WIDE)] {
            for (width, height) in [(32, 32), (33, 1), (7, 45), (1, 1)] {
                let frame = Frame::Image { width, height };
                let map = LaneMap::new(&machine, frame, Stage::Fragment);
                for tile in 0..frame.tiles() {
                    let rect = frame.tile(tile);
                    let mut rays: Vec<u32> = map.warps(rect).flatten().filter(|&ray| ray != HELPER).collect();
                    rays.sort_unstable();
                    assert!(rays.into_iter().eq(0..rect.width * rect.height), "{width}x{height}");
                }
            }
        }
    }

    #[test]
    fn warps_outside_the_image_are_not_run_and_those_at_its_edge_have_idle_lanes() {
        let frame = Frame::Image { width: 9, height: 4 };
        let warps: Vec<_> = LaneMap::new(&gpu(&[]), frame, Stage::Fragment).warps(frame.tile(0)).collect();
        assert_eq!(warps.len(), 2);
        assert_eq!(warps[1].iter().filter(|&&ray| ray != HELPER).count(), 4);
    }

    #[test]
    fn a_compute_warp_takes_rows_of_a_workgroup() {
        let frame = Frame::Image { width: 32, height: 32 };
        let warps = |workgroup| -> Vec<Vec<u32>> {
            LaneMap::new(&gpu(&[]), frame, Stage::Compute { workgroup }).warps(frame.tile(0)).collect()
        };
        let two_per_group = warps([8, 8]);
        assert_eq!(two_per_group.len(), 32);
        assert!(two_per_group[0][..8].iter().copied().eq(0..8) && two_per_group[0][8] == 32);
        assert_eq!(two_per_group[1][0], 4 * 32, "the lower half of the group");
        assert_eq!(two_per_group[2][0], 8, "the next group to the right");
        let half_empty = warps([4, 4]);
        assert!(half_empty.len() == 64 && half_empty.iter().all(|lanes| lanes.len() == 16));
    }

    #[test]
    fn rays_of_a_list_fill_warps_in_order() {
        let frame = Frame::List { rays: 1024 + 40 };
        let map = LaneMap::new(&gpu(&[]), frame, Stage::Fragment);
        let warps: Vec<_> = map.warps(frame.tile(1)).collect();
        assert_eq!(warps.len(), 2);
        assert!(warps[0].iter().copied().eq(0..32));
        assert_eq!(warps[1].iter().filter(|&&ray| ray != HELPER).count(), 8);
    }

    #[test]
    fn residency_follows_the_register_rule_and_its_limits() {
        let header = Recorded::list(Accel::Bvh, "stack", 2, &[]).header;
        let resident = |registers| resident_warps(&gpu(&[]), registers, &header);
        // 48 / 12 * 2; 13 registers leave room for 3; 1 register would fit 96 warps, but there are 16 slots.
        for (registers, warps) in [(12, 8), (13, 6), (24, 4), (25, 2), (48, 2), (1, 16)] {
            assert_eq!(resident(registers).unwrap(), warps, "{registers} registers");
        }
        assert!(resident(49).unwrap_err().to_string().contains("49 vec4 registers"));
    }
}
