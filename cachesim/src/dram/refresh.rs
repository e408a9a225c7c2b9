//! Refresh by bank (REFpb): which banks are next, and since when.
//!
//! One command refreshes a bank, or the pair of banks of LPDDR5, while all others go on. The commands of a round refresh
//! every bank once, in any order, as LPDDR4 devices demand (DRAMSys, `CheckerLPDDR4`); a round lasts tREFI, and its commands fall due at equal
//! intervals. Banks for which nothing waits go first. Where there are none, the command is postponed, until the
//! standard allows it no longer. Then the next banks of the round take no more commands until they are refreshed; so
//! do those of which a row was shut for it. (DRAMSys does the same in its `RefreshManagerPerBank`.)
//!
//! While requests wait, at least one column command is issued between two refreshes. At bandwidths so small that
//! commands last longer than the interval, those that would be later than allowed by another round are counted, but
//! not timed.

use super::DramConfig;
use super::timings::DramTimings;

/// Banks to refresh next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// A bit each.
    pub(super) banks: u64,
    /// Not before.
    pub(super) from: u64,
    /// From then on these banks get no command but those of the refresh, whatever waits for them.
    pub(super) held_up: bool,
}

/// The rounds of one channel.
#[derive(Clone, Debug)]
pub(super) struct Rounds {
    /// From one command to the next, on average.
    interval: u64,
    /// Commands of a round.
    commands: u64,
    /// Commands that may be owed.
    postponed: u64,
    /// The banks that name a command, a bit each; the other of a pair is `partner` banks further.
    named: u64,
    partner: u32,
    /// Banks not yet refreshed in this round.
    remaining: u64,
    /// The bank that names the next command, once a row was shut for it.
    chosen: Option<u32>,
    /// Commands so far; number n falls due at n intervals.
    done: u64,
    /// No command before.
    gate: u64,
    /// A column command was issued since the last, or nothing waits.
    accessed: bool,
}

impl Rounds {
    pub(super) fn new(config: &DramConfig, timings: &DramTimings) -> Self {
        let organisation = &config.standard.organisation;
        let commands = u64::from(organisation.banks / organisation.refresh_banks);
        let partner = organisation.refresh_partner();
        let names = |bank: &u32| partner == 0 || (bank / partner).is_multiple_of(2);
        let named = (0..organisation.banks).filter(names).fold(0, |set, bank| set | 1 << bank);
        Self {
            interval: (timings.refi / commands).max(1),
            commands,
            postponed: commands * u64::from(config.standard.controller.refresh_postponed),
            named,
            partner,
            remaining: named | named << partner,
            chosen: None,
            done: 0,
            gate: 0,
            accessed: true,
        }
    }

    pub(super) fn done(&self) -> u64 {
        self.done
    }

    /// When the next command falls due; it may lie in the past.
    #[inline]
    pub(super) fn due(&self) -> u64 {
        (self.done + 1).saturating_mul(self.interval)
    }

    /// The banks to refresh next, where requests wait for those of `busy`.
    pub(super) fn target(&self, busy: u64) -> Option<Target> {
        if let Some(first) = self.chosen {
            let from = self.due().max(self.gate);
            return Some(Target { banks: self.banks(first), from, held_up: true });
        }
        if !self.accessed {
            return None;
        }
        let idle = self.remaining & !busy;
        let idle = self.named & idle & (idle >> self.partner);
        let held_up = idle == 0;
        let first = if held_up { self.remaining & self.named } else { idle };
        let from = match held_up {
            true => (self.done + 1 + self.postponed).saturating_mul(self.interval),
            false => self.due(),
        };
        Some(Target { banks: self.banks(first.trailing_zeros()), from: from.max(self.gate), held_up })
    }

    /// Those that are refreshed with bank `first`, a bit each.
    pub(super) fn banks(&self, first: u32) -> u64 {
        1 << first | 1 << (first + self.partner)
    }

    /// A column command was issued, or nothing waits.
    #[inline]
    pub(super) fn accessed(&mut self) {
        self.accessed = true;
    }

    /// The row of this bank was shut for its refresh.
    pub(super) fn choose(&mut self, bank: u32) {
        self.chosen = Some(if self.named >> bank & 1 == 1 { bank } else { bank - self.partner });
    }

    /// A command was issued.
    pub(super) fn refreshed(&mut self, at: u64, banks: u64, timings: &DramTimings) {
        self.accessed = false;
        self.chosen = None;
        self.gate = at.saturating_add(timings.pbr2pbr);
        self.done += 1;
        self.remaining &= !banks;
        if self.remaining & self.named == 0 {
            self.remaining = self.named | self.named << self.partner;
        }
        let owed = (at / self.interval).saturating_sub(self.done);
        let too_late = owed.saturating_sub(self.postponed + self.commands) / self.commands;
        self.done += too_late * self.commands;
    }

    /// Nothing waits from `since` to `until`: rounds that are certain to be over then, except the last two.
    pub(super) fn skip(&mut self, since: u64, until: u64) {
        let to_catch_up = (self.postponed + 2 * self.commands).saturating_mul(self.interval);
        if until - since > to_catch_up {
            let rounds = (until / self.interval).saturating_sub(self.done) / self.commands;
            self.done += rounds.saturating_sub(2) * self.commands;
        }
    }
}
