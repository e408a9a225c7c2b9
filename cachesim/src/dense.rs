//! Numbers lines in order of first touch, so that what is kept per line lies in plain arrays.

use crate::address::LineId;

/// Lines that share one entry of the hash table.
const PAGE: u64 = 16;
const NONE: u32 = u32::MAX;
const NO_PAGE: u64 = u64::MAX;

/// A map from lines to 0, 1, 2, ... It grows with the number of distinct lines, by 5 bytes each if they
/// are neighbours and at most 100 if they are strewn about.
#[derive(Clone, Debug)]
pub(crate) struct DenseIds {
    /// Open addressing with linear probing, at most half full: page number and index in `pages`.
    table: Vec<(u64, u32)>,
    pages: Vec<[u32; PAGE as usize]>,
    len: u32,
}

impl DenseIds {
    pub(crate) fn new() -> Self {
        Self { table: vec![(NO_PAGE, 0); 64], pages: Vec::new(), len: 0 }
    }

    /// The line's number; a new line gets the next one.
    ///
    /// # Panics
    /// After 2^32 - 1 distinct lines.
    #[inline(always)]
    pub(crate) fn number(&mut self, line: LineId) -> u32 {
        let key = line.get() / PAGE;
        let mask = self.table.len() - 1;
        let mut slot = spread(key) as usize & mask;
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
        let number = &mut self.pages[page as usize][(line.get() % PAGE) as usize];
        if *number == NONE {
            assert!(self.len < NONE, "more than 2^32 - 1 distinct lines");
            *number = self.len;
            self.len += 1;
        }
        *number
    }

    #[cold]
    fn add_page(&mut self, key: u64, slot: usize) -> u32 {
        let page = self.pages.len() as u32;
        self.pages.push([NONE; PAGE as usize]);
        self.table[slot] = (key, page);
        if self.pages.len() * 2 > self.table.len() {
            let mask = self.table.len() * 2 - 1;
            let old = std::mem::replace(&mut self.table, vec![(NO_PAGE, 0); mask + 1]);
            for entry in old.into_iter().filter(|entry| entry.0 != NO_PAGE) {
                let mut slot = spread(entry.0) as usize & mask;
                while self.table[slot].0 != NO_PAGE {
                    slot = (slot + 1) & mask;
                }
                self.table[slot] = entry;
            }
        }
        page
    }
}

/// Mixes all bits of a page number into the low ones.
#[inline(always)]
fn spread(key: u64) -> u64 {
    let product = u128::from(key ^ 0x9E37_79B9_7F4A_7C15) * 0xD6E8_FEB8_6659_FD93;
    (product >> 64) as u64 ^ product as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_in_order_of_first_touch_and_keep_their_numbers() {
        let mut ids = DenseIds::new();
        let lines: Vec<LineId> =
            (0..5_000_u64).map(|i| LineId::new(i.wrapping_mul(0x9E37_79B9_7F4A_7C15))).collect();
        for round in 0..2 {
            for (expected, &line) in lines.iter().enumerate() {
                assert_eq!(ids.number(line), expected as u32, "round {round}");
            }
        }
        assert_eq!(ids.number(LineId::MAX), lines.len() as u32);
    }
}
