//! Least recently used.

use super::Replacement;
#[cfg(target_arch = "x86_64")]
use crate::queue::{MaskOrder, SetVector, up_to};
use crate::queue::{Order, Touch};
use crate::word::Word;

/// A queue by recency: a touched line moves to the front.
pub(crate) struct Lru;

impl Order for Lru {
    #[inline(always)]
    fn touch<W: Word>(set: &mut [W], word: W) -> Touch<W> {
        let line = word.without_flag();
        let mut carried = word;
        for way in set.iter_mut() {
            let here = std::mem::replace(way, carried);
            if here.without_flag() == line {
                set[0] = word.with_flag(here.flagged());
                return Touch::Hit;
            }
            carried = here;
        }
        Touch::Evicted(carried)
    }
}

#[cfg(target_arch = "x86_64")]
impl MaskOrder for Lru {
    #[inline(always)]
    unsafe fn read<V: SetVector>(set: V, line: V::Word, last: u32) -> (V, u32) {
        // SAFETY: passed on.
        unsafe { set.renewed(line, last) }
    }

    #[inline(always)]
    fn moved(hit: u32, last: u32) -> u32 {
        up_to(hit, last)
    }

    #[inline(always)]
    fn place(_hit: u32) -> u32 {
        1
    }
}

/// The time of each way's last access.
#[derive(Clone, Debug)]
pub(crate) struct LruStamps {
    stamps: Vec<u64>,
    ways: usize,
    clock: u64,
}

impl LruStamps {
    pub(crate) fn new(sets: usize, ways: usize) -> Self {
        Self { stamps: vec![0; sets * ways], ways, clock: 0 }
    }
}

impl Replacement for LruStamps {
    fn touched(&mut self, set: usize, way: usize) {
        self.clock += 1;
        self.stamps[set * self.ways + way] = self.clock;
    }

    fn filled(&mut self, set: usize, way: usize) {
        self.touched(set, way);
    }

    fn victim(&mut self, set: usize) -> usize {
        let stamps = &self.stamps[set * self.ways..][..self.ways];
        (0..self.ways).min_by_key(|&way| stamps[way]).unwrap_or(0)
    }
}
