//! How a record is read: by which loads.

use super::VEC4_BYTES;
use cachesim::LineSize;

/// Records that are read in loads of 16 bytes, or of whole lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reads {
    /// Loads of one lane.
    pub(crate) loads: u32,
    /// From load to load, in 16 bytes.
    step: u32,
    /// The last 16 bytes of the record.
    last: u32,
    /// All loads of a record lie in one line, wherever the record is.
    pub(crate) one_line: bool,
}

impl Reads {
    pub(super) fn new(bytes: u32, stride_bytes: u32, line: LineSize) -> Self {
        let aligned = bytes <= stride_bytes && line.bytes().is_multiple_of(u64::from(stride_bytes));
        let loads = bytes / VEC4_BYTES as u32;
        Self { loads, step: 1, last: loads - 1, one_line: aligned }
    }

    /// A load for each line that a record may touch.
    pub(super) fn of_lines(bytes: u32, stride_bytes: u32, line: LineSize) -> Self {
        let step = (line.bytes() / VEC4_BYTES) as u32;
        let last = bytes / VEC4_BYTES as u32 - 1;
        let one_line = Self::new(bytes, stride_bytes, line).one_line;
        let whole_lines = u64::from(stride_bytes).is_multiple_of(line.bytes());
        let loads = if one_line || whole_lines { last / step + 1 } else { last.div_ceil(step) + 1 };
        Self { loads, step, last, one_line }
    }

    /// Bytes of a record that are read.
    pub(crate) fn bytes(self) -> u32 {
        (self.last + 1) * VEC4_BYTES as u32
    }

    /// Where load `index` begins, in 16 bytes from the record's first.
    #[inline(always)]
    pub(crate) fn offset(self, index: u32) -> u32 {
        (index * self.step).min(self.last)
    }
}
