//! The commands that a channel could issue, and the first of them.

use super::bank::{Action, Candidate};

/// The next command, if nothing arrives before it. Ordered by what goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Command {
    pub(super) at: u64,
    pub(super) action: Action,
    /// Of the entry that it serves.
    pub(super) order: u64,
    pub(super) bank: u32,
    /// Index of the entry in its bank; none of a refresh, nor of a precharge for it.
    pub(super) entry: u32,
}

/// The first of the commands offered.
pub(super) struct Best(pub(super) Option<Command>);

impl Best {
    #[inline]
    pub(super) fn offer(&mut self, at: u64, bank: u32, candidate: &Candidate) {
        let Candidate { action, order, entry, .. } = *candidate;
        let command = Command { at, action, order, bank, entry };
        if self.0.is_none_or(|best| at < best.at || at == best.at && command < best) {
            self.0 = Some(command);
        }
    }

    #[inline]
    pub(super) fn later_than(&self, at: u64) -> bool {
        self.0.is_none_or(|best| best.at > at)
    }
}

/// The numbers of the set bits, in order.
pub(super) fn bits(mut set: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = set.trailing_zeros();
        (set != 0).then(|| {
            set &= set - 1;
            bit
        })
    })
}
