//! The rules that all kinds of cache share: what counts as what, and what goes below in which order.

use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::word::Word;

/// Where a pass counts and puts what has to go below.
pub(crate) struct Sink<'a, W> {
    out: Out<'a, W>,
    /// Accesses that have begun.
    begun: u32,
    pub(crate) tally: Tally,
}

impl<'a, W: Word> Sink<'a, W> {
    pub(crate) fn new(out: Out<'a, W>) -> Self {
        Self { out, begun: 0, tally: Tally::default() }
    }

    #[inline(always)]
    fn send(&mut self, word: W) {
        self.out.words[self.tally.sent] = word;
        self.out.causes[self.tally.sent] = self.begun - 1;
        self.tally.sent += 1;
    }

    /// First step of an access. `valid`: the sectors of its line that are here, if the line is; `sector`:
    /// the one accessed. Counts, and reads the data from below if need be. Answers whether the sector is
    /// to be in the cache from now on.
    #[inline(always)]
    pub(crate) fn serve(&mut self, word: W, valid: Option<u32>, sector: u32, rule: WriteRule) -> bool {
        let write = word.flagged();
        self.begun += 1;
        self.tally.writes += u64::from(write);
        if valid.is_some_and(|valid| valid & sector != 0) {
            return true;
        }
        self.out.missed[self.tally.misses as usize] = self.begun - 1;
        self.tally.misses += 1;
        self.tally.write_misses += u64::from(write);
        self.tally.sector_misses += u64::from(valid.is_some());
        if write && !rule.allocate {
            return false;
        }
        if !write || rule.fetch {
            self.tally.fills += 1;
            self.send(word.without_flag());
        }
        true
    }

    /// Second step, if a line had to leave: writes its dirty granules below.
    #[inline(always)]
    pub(crate) fn write_back(&mut self, dirty: impl Iterator<Item = u64>) {
        for granule in dirty {
            self.tally.writebacks += 1;
            self.send(W::from_id(granule).with_flag(true));
        }
    }

    /// Last step: passes on a write that does not end here. `kept`: the answer of [`Self::serve`].
    #[inline(always)]
    pub(crate) fn pass_on(&mut self, word: W, kept: bool, rule: WriteRule) {
        if word.flagged() && (rule.through || !kept) {
            self.send(word);
        }
    }
}
