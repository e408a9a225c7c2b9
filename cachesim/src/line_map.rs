//! A number per line, for lines anywhere in the address space.

use crate::address::LineId;

const NO_PAGE: u64 = u64::MAX;

/// A `u32` for each line, found by hashing pages of `PAGE` neighbouring lines. It grows with the number
/// of distinct pages, by `4 * PAGE` bytes and at most 64 more each.
#[derive(Clone, Debug)]
pub(crate) struct LineMap<const PAGE: usize> {
    /// Open addressing with linear probing, at most half full: page number and index in `pages`.
    table: Vec<(u64, u32)>,
    /// 64 less the logarithm of the length of `table`.
    shift: u32,
    pages: Vec<[u32; PAGE]>,
}

impl<const PAGE: usize> Default for LineMap<PAGE> {
    fn default() -> Self {
        Self { table: vec![(NO_PAGE, 0); 64], shift: 58, pages: Vec::new() }
    }
}

impl<const PAGE: usize> LineMap<PAGE> {
    /// The value of a line that none was given.
    pub(crate) const UNSET: u32 = 0;

    /// The line's value.
    #[inline(always)]
    pub(crate) fn of(&mut self, line: LineId) -> &mut u32 {
        let key = line.get() / PAGE as u64;
        let mask = self.table.len() - 1;
        let mut slot = self.slot(key);
        let page = loop {
            let (found, page) = self.table[slot];
            if found == key {
                break page;
            }
            if found == NO_PAGE {
                break self.add_page(key, slot);
            }
            slot = (slot + 1) & mask;
        };
        &mut self.pages[page as usize][line.get() as usize % PAGE]
    }

    /// All lines of all pages, with their values.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (LineId, &mut u32)> {
        let mut keys = vec![0; self.pages.len()];
        for &(key, page) in self.table.iter().filter(|entry| entry.0 != NO_PAGE) {
            keys[page as usize] = key;
        }
        keys.into_iter()
            .zip(&mut self.pages)
            .flat_map(|(key, page)| (key * PAGE as u64..).map(LineId::new).zip(page))
    }

    /// The place where the search for a page begins: multiplicative hashing (Knuth 1973).
    #[inline(always)]
    fn slot(&self, key: u64) -> usize {
        (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> self.shift) as usize
    }

    #[cold]
    fn add_page(&mut self, key: u64, slot: usize) -> u32 {
        let page = self.pages.len() as u32;
        self.pages.push([Self::UNSET; PAGE]);
        self.table[slot] = (key, page);
        if self.pages.len() * 2 > self.table.len() {
            self.shift -= 1;
            let mask = self.table.len() * 2 - 1;
            let old = std::mem::replace(&mut self.table, vec![(NO_PAGE, 0); mask + 1]);
            for entry in old.into_iter().filter(|entry| entry.0 != NO_PAGE) {
                let mut slot = self.slot(entry.0);
                while self.table[slot].0 != NO_PAGE {
                    slot = (slot + 1) & mask;
                }
                self.table[slot] = entry;
            }
        }
        page
    }
}
