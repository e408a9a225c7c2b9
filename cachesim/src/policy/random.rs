//! A pseudorandom way, the same sequence in every run.

use super::Replacement;
use crate::splitmix::SplitMix64;

/// Draws a way for every eviction.
#[derive(Clone, Debug)]
pub(crate) struct Random {
    sequence: SplitMix64,
    ways: usize,
}

impl Random {
    pub(crate) fn new(ways: usize, seed: u64) -> Self {
        Self { sequence: SplitMix64::new(seed), ways }
    }
}

impl Replacement for Random {
    fn touched(&mut self, _set: usize, _way: usize) {}

    fn filled(&mut self, _set: usize, _way: usize) {}

    fn victim(&mut self, _set: usize) -> usize {
        ((u128::from(self.sequence.draw()) * self.ways as u128) >> 64) as usize
    }
}
