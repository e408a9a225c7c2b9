//! Least recently used.

use crate::queue::{Order, Touch};
use crate::word::Word;

/// A queue by recency: a touched line moves to the front.
pub(crate) struct Lru;

impl Order for Lru {
    #[inline(always)]
    fn touch<W: Word>(set: &mut [W], word: W) -> Touch<W> {
        let line = word.without_flag();
        let mut carried = word;
        let mut dirty = false;
        for way in set.iter_mut() {
            let here = std::mem::replace(way, carried);
            if here.without_flag() == line {
                dirty = here.flagged();
                carried = line;
                break;
            }
            carried = here;
        }
        if carried != line {
            return Touch::Evicted(carried);
        }
        set[0] = set[0].with_flag(dirty);
        Touch::Hit
    }
}
