//! What travels between levels and lies in tag arrays: a line number with one flag bit.
//!
//! In a request the flag means "write", in a tag "dirty". A hierarchy works with 32-bit words until a
//! line number needs more, and then with 64-bit words.

use crate::queue::Vectorised;

/// A line number below [`Word::EMPTY`] and, in the top bit, a flag.
pub(crate) trait Word: Vectorised + Copy + Eq + Send + Sync + std::fmt::Debug + 'static {
    /// The flag alone.
    const FLAG: Self;
    /// The tag of a way that holds nothing: a number that no line has.
    const EMPTY: Self;
    /// All line numbers up to here can be held.
    const MAX_ID: u64;

    fn from_id(id: u64) -> Self;
    /// The low bits of a number that may be too large.
    fn truncated(id: u64) -> Self;
    fn id(self) -> u64;
    fn flagged(self) -> bool;
    fn with_flag(self, flag: bool) -> Self;
    fn without_flag(self) -> Self;
    fn shifted_right(self, by: u32) -> Self;
}

macro_rules! word {
    ($t:ty) => {
        impl Word for $t {
            const FLAG: Self = 1 << (<$t>::BITS - 1);
            const EMPTY: Self = <$t>::MAX >> 1;
            const MAX_ID: u64 = (<$t>::MAX >> 1) as u64 - 1;

            #[inline(always)]
            fn from_id(id: u64) -> Self {
                debug_assert!(id <= Self::MAX_ID);
                id as $t
            }
            #[inline(always)]
            fn truncated(id: u64) -> Self {
                (id & Self::EMPTY as u64) as $t
            }
            #[inline(always)]
            fn id(self) -> u64 {
                (self & Self::EMPTY) as u64
            }
            #[inline(always)]
            fn flagged(self) -> bool {
                self & Self::FLAG != 0
            }
            #[inline(always)]
            fn with_flag(self, flag: bool) -> Self {
                self | (flag as $t) << (<$t>::BITS - 1)
            }
            #[inline(always)]
            fn without_flag(self) -> Self {
                self & Self::EMPTY
            }
            #[inline(always)]
            fn shifted_right(self, by: u32) -> Self {
                (self & Self::FLAG) | (self & Self::EMPTY) >> by
            }
        }
    };
}
word!(u32);
word!(u64);
