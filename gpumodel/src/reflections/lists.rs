//! Where the images and lists of a reflections frame lie: behind the buffers of the acceleration structure.
//!
//! | list | record | found by |
//! |---|---|---|
//! | depth pyramid, normal, roughness, colour, output | 4 bytes | level and pixel; 4x4 pixels side by side |
//! | rays that the screen had no hit for | [`RAY_BYTES`] | place in the list |
//! | hits: barycentrics, triangle, pixel; shader; position | [`HIT_BYTES`], [`ID_BYTES`], [`POSITION_BYTES`] | place in the list of rays |
//! | hits by material | [`ID_BYTES`] | place in the sorted list |
//! | materials | [`MATERIAL_BYTES`] | shader |
//! | shader records of a ray-tracing pipeline | by the cost table | hit group |
//! | counters | 4 bytes | the list's, its dispatch's, then those of buckets |

use crate::layout::PIXEL_BYTES;

/// Bytes of a ray that is left for a ray query: pixel, origin, direction, and what it hides of its surface (Calvo Lista, Vulkanised 2026).
pub(super) const RAY_BYTES: u64 = 32;
/// Bytes of what a hit keeps besides: probability and level of detail, pixel, barycentrics, triangle.
pub(super) const HIT_BYTES: u64 = 20;
/// Bytes of a hit's instance, and of its place in the sorted list.
pub(super) const ID_BYTES: u64 = 4;
/// Bytes of a hit's position.
pub(super) const POSITION_BYTES: u64 = 12;
/// Bytes of a material: a cache line of parameters.
pub(super) const MATERIAL_BYTES: u64 = 64;
/// What a load or store of a lane takes at most.
pub(super) const LOAD_BYTES: u64 = 16;
/// Where lists may begin: a multiple of any line.
const ALIGNMENT: u64 = 4096;
/// Edge of a block of pixels that lie side by side.
const BLOCK: u32 = 4;

/// Addresses in bytes.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    /// By level: the address, and blocks per row.
    pyramid: Vec<(u64, u32)>,
    pub(super) normal: Image,
    pub(super) roughness: Image,
    pub(super) colour: Image,
    pub(super) output: Image,
    rays: u64,
    hits: u64,
    ids: u64,
    positions: u64,
    order: u64,
    materials: u64,
    group_records: u64,
    counters: u64,
    /// Behind the last list.
    pub(super) end: u64,
    /// Bytes of all images, and of all other lists.
    pub(super) image_bytes: u64,
    pub(super) record_bytes: u64,
}

/// An image of 4 bytes per pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    base: u64,
    blocks_per_row: u32,
}

impl Image {
    pub(super) fn address(self, x: u32, y: u32) -> u64 {
        let block = u64::from(y / BLOCK) * u64::from(self.blocks_per_row) + u64::from(x / BLOCK);
        let within = y % BLOCK * BLOCK + x % BLOCK;
        self.base + (block * u64::from(BLOCK * BLOCK) + u64::from(within)) * PIXEL_BYTES
    }
}

impl Lists {
    /// From address `base` on, of a frame whose pyramid has levels of these sizes, level 0 the frame's own. Without hits by material there
    /// are none of their lists; `group_records` are the bytes of the shader records of a pipeline.
    pub(super) fn new(
        base: u64,
        levels: &[(u32, u32)],
        rays: u32,
        shaders: u32,
        (by_material, group_records): (bool, u64),
    ) -> Self {
        let mut next = base.next_multiple_of(ALIGNMENT);
        let start = next;
        let mut place = |bytes: u64| {
            let at = next;
            next += bytes.next_multiple_of(ALIGNMENT);
            at
        };
        let bytes_of = |(width, height): (u32, u32)| {
            let blocks = u64::from(width.div_ceil(BLOCK)) * u64::from(height.div_ceil(BLOCK));
            blocks * u64::from(BLOCK * BLOCK) * PIXEL_BYTES
        };
        let pyramid: Vec<_> =
            levels.iter().map(|&size| (place(bytes_of(size)), size.0.div_ceil(BLOCK))).collect();
        let blocks_per_row = levels[0].0.div_ceil(BLOCK);
        let mut image = || Image { base: place(bytes_of(levels[0])), blocks_per_row };
        let [normal, roughness, colour, output] = [image(), image(), image(), image()];
        let first_record = place(0);
        let rays = u64::from(rays);
        let listed = |bytes: u64| if by_material { rays * bytes } else { 0 };
        let ray_list = place(rays * RAY_BYTES);
        let [hits, ids, positions, order] =
            [HIT_BYTES, ID_BYTES, POSITION_BYTES, ID_BYTES].map(|bytes| place(listed(bytes)));
        let materials = place(u64::from(shaders) * MATERIAL_BYTES);
        let group_records = place(group_records);
        // The list's counter, its dispatch's size; sizes and offsets of the buckets.
        let counters = place((2 + 2 * u64::from(shaders + 1)) * ID_BYTES);
        Self {
            pyramid,
            normal,
            roughness,
            colour,
            output,
            rays: ray_list,
            hits,
            ids,
            positions,
            order,
            materials,
            group_records,
            counters,
            end: next,
            image_bytes: first_record - start,
            record_bytes: next - first_record,
        }
    }

    /// A texel of the depth pyramid.
    pub(super) fn depth(&self, level: u32, x: u32, y: u32) -> u64 {
        let (base, blocks_per_row) = self.pyramid[level as usize];
        Image { base, blocks_per_row }.address(x, y)
    }

    pub(super) fn ray(&self, place: u32) -> u64 {
        self.rays + u64::from(place) * RAY_BYTES
    }

    pub(super) fn hit(&self, place: u32) -> u64 {
        self.hits + u64::from(place) * HIT_BYTES
    }

    pub(super) fn id(&self, place: u32) -> u64 {
        self.ids + u64::from(place) * ID_BYTES
    }

    pub(super) fn position(&self, place: u32) -> u64 {
        self.positions + u64::from(place) * POSITION_BYTES
    }

    pub(super) fn sorted(&self, place: u32) -> u64 {
        self.order + u64::from(place) * ID_BYTES
    }

    pub(super) fn material(&self, shader: u32) -> u64 {
        self.materials + u64::from(shader) * MATERIAL_BYTES
    }

    /// The record of a hit group, or of the misses (0), of so many bytes.
    pub(super) fn group_record(&self, group: u32, bytes: u32) -> u64 {
        self.group_records + u64::from(group * bytes)
    }

    /// The list's counter (0), its dispatch's size (1), or from 2 on those of buckets.
    pub(super) fn counter(&self, counter: u32) -> u64 {
        self.counters + u64::from(counter) * ID_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_things_lie_in_one_place() {
        let levels = [(37, 21), (19, 11), (10, 6)];
        let lists = Lists::new(1234, &levels, 777, 5, (true, 6 * 32));
        let mut bytes = BTreeSet::new();
        let mut take = |address: u64, size: u64| {
            assert!(address >= 1234 && address + size <= lists.end);
            (address..address + size).for_each(|byte| assert!(bytes.insert(byte), "{byte} is taken twice"));
        };
        for (level, &(width, height)) in (0..).zip(&levels) {
            (0..height).for_each(|y| (0..width).for_each(|x| take(lists.depth(level, x, y), 4)));
        }
        for image in [lists.normal, lists.roughness, lists.colour, lists.output] {
            (0..21).for_each(|y| (0..37).for_each(|x| take(image.address(x, y), 4)));
        }
        for place in 0..777 {
            take(lists.ray(place), RAY_BYTES);
            take(lists.hit(place), HIT_BYTES);
            take(lists.id(place), ID_BYTES);
            take(lists.position(place), POSITION_BYTES);
            take(lists.sorted(place), ID_BYTES);
        }
        (0..5).for_each(|shader| take(lists.material(shader), MATERIAL_BYTES));
        (0..6).for_each(|group| take(lists.group_record(group, 32), 32));
        (0..2 + 2 * 6).for_each(|counter| take(lists.counter(counter), ID_BYTES));
    }
}
