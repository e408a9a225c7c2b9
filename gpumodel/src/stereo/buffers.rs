//! Where the G-buffer and the lists of two eyes lie in memory: behind the buffers of the acceleration structure.

use crate::config::GBufferFields;
use crate::layout::PIXEL_BYTES;

/// Bytes of what the row test needs of a pixel: its column in the right image, and its inverse depth.
pub(super) const SPAN_BYTES: u64 = 8;
/// Bytes of a pixel in a list: its number, and by how many columns its source is shifted.
pub(super) const ENTRY_BYTES: u64 = 4;
/// Where buffers may begin: a multiple of any line.
const ALIGNMENT: u64 = 4096;

/// Addresses in bytes, of an image with so many pixels. Without a G-buffer in memory there are neither its planes nor lists.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    /// Of each field: where its plane begins, and the bytes of a pixel.
    planes: [(u64, u32); 4],
    spans: u64,
    list: u64,
    counters: u64,
    /// Behind the last of them.
    pub(super) end: u64,
    /// Bytes of all.
    pub(super) bytes: u64,
}

/// The field of the G-buffer that reprojection reads.
pub(super) const POSITION: usize = 3;

impl Buffers {
    pub(super) fn new(base: u64, pixels: u64, fields: &GBufferFields, in_memory: bool) -> Self {
        let start = base.next_multiple_of(ALIGNMENT);
        let mut next = start;
        let mut place = |bytes: u64| {
            let at = next;
            next += bytes.next_multiple_of(ALIGNMENT);
            at
        };
        let of_memory = |bytes: u64| if in_memory { pixels * bytes } else { 0 };
        let planes = fields.all().map(|bytes| (place(of_memory(u64::from(bytes))), bytes));
        let spans = place(pixels * SPAN_BYTES);
        let list = place(of_memory(ENTRY_BYTES));
        let counters = place(if in_memory { 2 * PIXEL_BYTES } else { 0 });
        Self { planes, spans, list, counters, end: next, bytes: next - start }
    }

    /// Where a pixel is in each field.
    pub(super) fn gbuffer(&self, pixel: u32) -> [u64; 4] {
        self.planes.map(|(base, bytes)| base + u64::from(pixel) * u64::from(bytes))
    }

    pub(super) fn span(&self, pixel: u32) -> u64 {
        self.spans + u64::from(pixel) * SPAN_BYTES
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
