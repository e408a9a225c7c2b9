//! The lanes of a dispatch over an image.

use crate::schedule::HELPER;

/// Lanes of a dispatch over all pixels of an image, workgroup after workgroup in rows of the image.
pub(crate) struct Lanes {
    /// By lane, the pixel, row by row from the top left, or [`HELPER`] outside the image.
    pub(crate) pixels: Vec<u32>,
    /// Lanes of a warp: a warp takes rows of one workgroup.
    pub(crate) warp: usize,
    /// Lanes of a workgroup.
    pub(crate) group: usize,
}

impl Lanes {
    pub(crate) fn new((width, height): (u32, u32), workgroup: [u32; 2], warp_width: u32) -> Self {
        let [group_width, group_height] = workgroup;
        let group = (group_width * group_height) as usize;
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for top in (0..height).step_by(group_height as usize) {
            for left in (0..width).step_by(group_width as usize) {
                for y in top..top + group_height {
                    for x in left..left + group_width {
                        pixels.push(if x < width && y < height { y * width + x } else { HELPER });
                    }
                }
            }
        }
        Self { pixels, warp: group.min(warp_width as usize), group }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_pixel_is_one_lane_and_workgroups_are_whole(
            width in 1_u32..70, height in 1_u32..70, log_width in 0_u32..5, log_height in 0_u32..5,
        ) {
            let workgroup = [1 << log_width, 1 << log_height];
            let lanes = Lanes::new((width, height), workgroup, 16);
            let mut pixels: Vec<u32> = lanes.pixels.iter().copied().filter(|&pixel| pixel != HELPER).collect();
            pixels.sort_unstable();
            prop_assert!(pixels.into_iter().eq(0..width * height));
            for group in lanes.pixels.chunks(lanes.group) {
                let inside: Vec<u32> = group.iter().copied().filter(|&pixel| pixel != HELPER).collect();
                let (x, y) = (inside[0] % width, inside[0] / width);
                prop_assert!(inside.iter().all(|pixel| pixel % width - x < workgroup[0] && pixel / width - y < workgroup[1]));
            }
        }
    }
}
