//! One bank: its open row, when it may take which command, and the requests for it that the scheduler sees.

use super::timings::DramTimings;

/// The row of a bank whose rows are all shut; no address lies in it.
pub(super) const SHUT: u64 = u64::MAX;

/// Direction of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Read,
    Write,
}

/// What opening its row took a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowNeed {
    Nothing,
    Activate,
    PrechargeAndActivate,
}

/// Bursts of one row that wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Order of arrival at the channel.
    pub(super) order: u64,
    /// When the scheduler first saw it.
    pub(super) seen: u64,
    pub(super) row: u64,
    pub(super) request: u32,
    pub(super) bursts: u32,
    pub(super) bank: u32,
    pub(super) direction: Direction,
    pub(super) need: RowNeed,
}

/// The kinds of command, in the order in which simultaneous ones go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Action {
    Column,
    Precharge,
    Refresh,
    Activate,
}

/// What a bank would do next for one direction of data, as far as the bank alone decides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Not before.
    pub(super) ready: u64,
    /// Of the entry that it serves.
    pub(super) order: u64,
    /// Index of that entry.
    pub(super) entry: u32,
    pub(super) action: Action,
}

/// State of a bank.
#[derive(Clone, Debug)]
pub(super) struct Bank {
    pub(super) open: u64,
    pub(super) may_activate: u64,
    pub(super) may_precharge: u64,
    pub(super) may_access: u64,
    /// Oldest first.
    pub(super) entries: Vec<Entry>,
    /// Per direction the entry that first-ready takes next: the oldest of the open row, else the oldest.
    choice: [Option<u32>; 2],
}

impl Bank {
    pub(super) fn new() -> Self {
        Self {
            open: SHUT,
            may_activate: 0,
            may_precharge: 0,
            may_access: 0,
            entries: Vec::new(),
            choice: [None; 2],
        }
    }

    /// For the entry to serve next in a direction, by row hits first, then age.
    #[inline]
    pub(super) fn candidate(&self, direction: Direction) -> Option<Candidate> {
        self.choice[direction as usize].map(|index| self.candidate_for(index))
    }

    /// For the entry at `index`.
    #[inline]
    pub(super) fn candidate_for(&self, index: u32) -> Candidate {
        let entry = &self.entries[index as usize];
        let (action, ready) = if self.open == entry.row {
            (Action::Column, self.may_access)
        } else if self.open == SHUT {
            (Action::Activate, self.may_activate)
        } else {
            (Action::Precharge, self.may_precharge)
        };
        Candidate { ready, order: entry.order, entry: index, action }
    }

    pub(super) fn push(&mut self, entry: Entry) {
        let index = self.entries.len() as u32;
        self.entries.push(entry);
        let choice = &mut self.choice[entry.direction as usize];
        let better = match *choice {
            None => true,
            Some(old) => entry.row == self.open && self.entries[old as usize].row != self.open,
        };
        if better {
            *choice = Some(index);
        }
    }

    pub(super) fn remove(&mut self, index: usize) -> Entry {
        let entry = self.entries.remove(index);
        self.choose();
        entry
    }

    pub(super) fn precharge(&mut self, at: u64, timings: &DramTimings) {
        self.open = SHUT;
        self.may_activate = self.may_activate.max(at.saturating_add(timings.rp));
        self.choose();
    }

    pub(super) fn activate(&mut self, at: u64, row: u64, timings: &DramTimings) {
        self.open = row;
        self.may_access = at.saturating_add(timings.rcd);
        self.may_precharge = at.saturating_add(timings.ras);
        self.may_activate = at.saturating_add(timings.rc);
        self.choose();
    }

    /// A column command, the last of its kind at `last`.
    pub(super) fn access(&mut self, last: u64, direction: Direction, timings: &DramTimings) {
        let recovery = match direction {
            Direction::Read => timings.rtp,
            Direction::Write => {
                timings.write_latency.saturating_add(timings.burst).saturating_add(timings.wr)
            }
        };
        self.may_precharge = self.may_precharge.max(last.saturating_add(recovery));
    }

    /// Nothing is possible before `end`.
    pub(super) fn refresh(&mut self, end: u64) {
        self.may_activate = self.may_activate.max(end);
    }

    fn choose(&mut self) {
        self.choice = [None; 2];
        let mut hit = [false; 2];
        for (index, entry) in (0..).zip(&self.entries) {
            let direction = entry.direction as usize;
            if !hit[direction] {
                hit[direction] = entry.row == self.open;
                if hit[direction] || self.choice[direction].is_none() {
                    self.choice[direction] = Some(index);
                }
                if hit == [true; 2] {
                    return;
                }
            }
        }
    }
}
