//! Replacement policies, one per file.
//!
//! LRU and FIFO over few ways are the order of a queue ([`crate::queue`]); all others choose among fixed
//! ways ([`crate::assoc`]).

pub(crate) mod fifo;
pub(crate) mod lru;
pub(crate) mod plru;
pub(crate) mod random;
pub(crate) mod srrip;

/// Chooses the way of a full set that makes room. Way numbers are within the set.
pub(crate) trait Replacement {
    /// A line in the cache is accessed.
    fn touched(&mut self, set: usize, way: usize);
    /// A new line takes this way.
    fn filled(&mut self, set: usize, way: usize);
    /// The way to take; all hold lines. [`Self::filled`] follows.
    fn victim(&mut self, set: usize) -> usize;
}
