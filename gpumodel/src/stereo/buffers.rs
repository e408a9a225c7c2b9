//! Where the G-buffer and the lists of two eyes lie in memory: behind the buffers of the acceleration structure.

use crate::config::GBufferFields;
use crate::layout::PIXEL_BYTES;

/// Bytes of what the row test needs of a pixel: its column in the right image, and its inverse depth.
pub(super) const SPAN_BYTES: u64 = 8;
/// Bytes of a pixel in a list: its number, and by how many columns its source is shifted.
pub(super) const ENTRY_BYTES: u64 = 4;
/// Where buffers may begin: a multiple of any line.
const ALIGNMENT: u64 = 4096;

/// Edge of a block of pixels that lie side by side.
const BLOCK: u32 = 4;

/// Addresses in bytes, of an image. Without a G-buffer in memory there are neither its planes nor lists.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    /// One for each field.
    planes: [Plane; 4],
    spans: Plane,
    list: u64,
    counters: u64,
    /// Behind the last of them.
    pub(super) end: u64,
    /// Bytes of all.
    pub(super) bytes: u64,
}

/// A field of all pixels, in blocks of 4x4: rows of a screen may be as far apart as the sets of a cache go round.
#[derive(Clone, Copy, Debug)]
struct Plane {
    base: u64,
    bytes: u64,
    width: u32,
}

impl Plane {
    fn address(self, pixel: u32) -> u64 {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let blocks_per_row = u64::from(self.width.div_ceil(BLOCK));
        let block = u64::from(y / BLOCK) * blocks_per_row + u64::from(x / BLOCK);
        let within = u64::from(y % BLOCK * BLOCK + x % BLOCK);
        self.base + (block * u64::from(BLOCK * BLOCK) + within) * self.bytes
    }
}

/// The field of the G-buffer that reprojection reads.
pub(super) const POSITION: usize = 3;

impl Buffers {
    pub(super) fn new(base: u64, [width, height]: [u32; 2], fields: &GBufferFields, in_memory: bool) -> Self {
        let start = base.next_multiple_of(ALIGNMENT);
        let mut next = start;
        let mut place = |bytes: u64| {
            let at = next;
            next += bytes.next_multiple_of(ALIGNMENT);
            at
        };
        let in_blocks = |side: u32| u64::from(side.next_multiple_of(BLOCK));
        let pixels = in_blocks(width) * in_blocks(height);
        let of_memory = |bytes: u64| if in_memory { pixels * bytes } else { 0 };
        let mut plane = |bytes: u64, size: u64| Plane { base: place(size), bytes, width };
        let planes = fields.all().map(|bytes| plane(u64::from(bytes), of_memory(u64::from(bytes))));
        let spans = plane(SPAN_BYTES, pixels * SPAN_BYTES);
        let list = place(of_memory(ENTRY_BYTES));
        let counters = place(if in_memory { 2 * PIXEL_BYTES } else { 0 });
        Self { planes, spans, list, counters, end: next, bytes: next - start }
    }

    /// Where a pixel is in each field.
    pub(super) fn gbuffer(&self, pixel: u32) -> [u64; 4] {
        self.planes.map(|plane| plane.address(pixel))
    }

    pub(super) fn span(&self, pixel: u32) -> u64 {
        self.spans.address(pixel)
    }

    /// A place in the two lists, one after the other.
    pub(super) fn entry(&self, place: u32) -> u64 {
        self.list + u64::from(place) * ENTRY_BYTES
    }

    /// Of the pixels that are traced (0), and of the others (1).
    pub(super) fn counter(&self, list: u32) -> u64 {
        self.counters + u64::from(list) * PIXEL_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_things_lie_in_one_place() {
        let fields = GBufferFields { colour: 4, normal: 12, texcoord: 8, position: 16 };
        let buffers = Buffers::new(1234, [13, 6], &fields, true);
        let mut bytes = BTreeSet::new();
        let mut take = |address: u64, size: u64| {
            assert!(address >= 1234 && address + size <= buffers.end);
            (address..address + size).for_each(|byte| assert!(bytes.insert(byte), "{byte} is taken twice"));
        };
        for pixel in 0..13 * 6 {
            buffers
                .gbuffer(pixel)
                .into_iter()
                .zip(fields.all())
                .for_each(|(at, size)| take(at, u64::from(size)));
            take(buffers.span(pixel), SPAN_BYTES);
            take(buffers.entry(pixel), ENTRY_BYTES);
        }
        [0, 1].into_iter().for_each(|list| take(buffers.counter(list), PIXEL_BYTES));
    }
}
