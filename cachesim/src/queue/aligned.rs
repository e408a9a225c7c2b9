//! Tags in rows aligned to the host's cache lines, so that no set in a register straddles two.

/// A vector of words whose start is aligned to 64 bytes and whose length is a multiple of 16.
#[derive(Clone, Debug)]
pub(super) struct Aligned<W> {
    rows: Vec<Row<W>>,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Row<W>([W; 16]);

impl<W: Copy> Aligned<W> {
    /// At least `len` copies of `word`.
    pub(super) fn new(word: W, len: usize) -> Self {
        const { assert!(size_of::<Row<W>>() == 16 * size_of::<W>(), "rows have no padding between them") };
        Self { rows: vec![Row([word; 16]); len.div_ceil(16)] }
    }

    #[inline(always)]
    pub(super) fn as_mut_slice(&mut self) -> &mut [W] {
        // SAFETY: rows are arrays of 16 words without padding, one after the other, and borrowed alone.
        unsafe { std::slice::from_raw_parts_mut(self.rows.as_mut_ptr().cast(), 16 * self.rows.len()) }
    }

    pub(super) fn map<V: Copy>(&self, f: impl Fn(W) -> V) -> Aligned<V> {
        Aligned { rows: self.rows.iter().map(|row| Row(row.0.map(&f))).collect() }
    }
}
