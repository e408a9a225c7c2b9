//! First in, first out.

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
