//! First in, first out.

use super::Replacement;
#[cfg(target_arch = "x86_64")]
use crate::queue::{MaskOrder, up_to};
use crate::queue::{Order, Touch};
use crate::word::Word;

/// A queue by age: a new line enters at the front, a touched one stays where it is.
pub(crate) struct Fifo;

impl Order for Fifo {
    #[inline(always)]
    fn touch<W: Word>(set: &mut [W], word: W) -> Touch<W> {
        let line = word.without_flag();
        if let Some(way) = set.iter_mut().find(|way| way.without_flag() == line) {
            *way = way.with_flag(word.flagged());
            return Touch::Hit;
        }
        set.rotate_right(1);
        Touch::Evicted(std::mem::replace(&mut set[0], word))
    }
}

#[cfg(target_arch = "x86_64")]
impl MaskOrder for Fifo {
    #[inline(always)]
    fn moved(hit: u32, last: u32) -> u32 {
        up_to(0, last) & u32::from(hit != 0).wrapping_sub(1)
    }

    #[inline(always)]
    fn place(hit: u32) -> u32 {
        hit | u32::from(hit == 0)
    }
}

/// The way after the newest: ways fill in order and so are the oldest in turn.
#[derive(Clone, Debug)]
pub(crate) struct FifoTurn {
    next: Vec<u32>,
    ways: u32,
}

impl FifoTurn {
    pub(crate) fn new(sets: usize, ways: usize) -> Self {
        Self { next: vec![0; sets], ways: ways as u32 }
    }
}

impl Replacement for FifoTurn {
    fn touched(&mut self, _set: usize, _way: usize) {}

    fn filled(&mut self, set: usize, way: usize) {
        self.next[set] = (way as u32 + 1) % self.ways;
    }

    fn victim(&mut self, set: usize) -> usize {
        self.next[set] as usize
    }
}
