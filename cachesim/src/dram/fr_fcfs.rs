//! One channel under first-ready, first-come-first-served (Rixner et al. 2000): the command that can be
//! issued first is issued first, a row hit before a row command, then the oldest.
//!
//! Only the oldest `queue` waiting entries are seen. Reads go before writes, which wait until they fill a
//! share of the queue and are then drained to a lower share, or until no read is seen. An entry that has
//! been seen for longer than the age cap is the next that its bank serves, and the oldest such entry sets the
//! direction; so none starves. Rows stay open until another row of the bank is wanted (open page).
//!
//! Each step issues one command at the earliest time that all constraints allow, so there is no stepping
//! through clocks. The command bus is not modelled. Refreshes ([`super::refresh`]) are commands like all others; those
//! that fall due while the channel has nothing to do are issued when it next has.

use std::collections::VecDeque;

use super::address_map::Segment;
use super::bank::{Action, Bank, Candidate, Direction, Entry, RowNeed, SHUT};
use super::command::{Best, Command, bits};
use super::ledger::Ledger;
use super::refresh::{Rounds, Target};
use super::standard::DramStandard;
use super::timings::DramTimings;
use super::{DramConfig, RowCounts};

/// What one channel has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ChannelStats {
    pub(super) rows: RowCounts,
    pub(super) busy: u64,
    pub(super) read_bursts: u64,
    pub(super) write_bursts: u64,
}

/// Of a bank without entries.
const NO_CANDIDATE: Candidate =
    Candidate { ready: u64::MAX, order: u64::MAX, entry: 0, action: Action::Column };

/// A channel, its controller and its banks.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    timings: DramTimings,
    limits: Limits,
    /// By bank.
    group: Vec<u8>,
    /// No command is issued before.
    now: u64,
    next: Option<Command>,
    /// Something changed since `next` was found.
    stale: bool,
    waiting: VecDeque<Entry>,
    banks: Vec<Bank>,
    /// By direction and action, the banks with entries that want it, a bit each.
    active: [[u64; 4]; 2],
    /// By direction, what each of those banks would do.
    candidates: [Vec<Candidate>; 2],
    /// No entry was seen earlier.
    oldest_seen: u64,
    /// Entries seen, by direction.
    seen: [u32; 2],
    draining: bool,
    /// Earliest column command by direction, in any bank group.
    column: [u64; 2],
    /// Earliest column command by bank group and direction.
    group_column: Vec<[u64; 2]>,
    /// Earliest activate or refresh after the last of either.
    activate: u64,
    /// Times of the last four activates or refreshes, the oldest at `oldest_activate`.
    activates: [u64; 4],
    oldest_activate: usize,
    any_activates: u8,
    refresh: Rounds,
    orders: u64,
    stats: ChannelStats,
    /// What was issued, for [`super::protocol`].
    #[cfg(test)]
    pub(super) log: Vec<super::protocol::Issued>,
}

#[derive(Clone, Copy, Debug)]
struct Limits {
    queue: u32,
    drain_from: u32,
    drain_to: u32,
    age_cap: u64,
}

impl Channel {
    pub(super) fn new(config: &DramConfig, timings: DramTimings) -> Self {
        let DramStandard { organisation, controller, .. } = &config.standard;
        let share = |part: f64| (f64::from(config.queue) * part).round() as u32;
        let drain_from = share(controller.write_high).max(1);
        let limits = Limits {
            queue: config.queue,
            drain_from,
            drain_to: share(controller.write_low).min(drain_from - 1),
            age_cap: (controller.age_cap_ns * 1e3).round() as u64,
        };
        Self {
            timings,
            limits,
            group: (0..organisation.banks).map(|bank| (bank % organisation.bank_groups) as u8).collect(),
            now: 0,
            next: None,
            stale: false,
            waiting: VecDeque::new(),
            banks: vec![Bank::new(); organisation.banks as usize],
            active: [[0; 4]; 2],
            candidates: [
                vec![NO_CANDIDATE; organisation.banks as usize],
                vec![NO_CANDIDATE; organisation.banks as usize],
            ],
            oldest_seen: u64::MAX,
            seen: [0; 2],
            draining: false,
            column: [0; 2],
            group_column: vec![[0; 2]; organisation.bank_groups as usize],
            activate: 0,
            activates: [0; 4],
            oldest_activate: 0,
            any_activates: 0,
            refresh: Rounds::new(config, &timings),
            orders: 0,
            stats: ChannelStats::default(),
            #[cfg(test)]
            log: Vec::new(),
        }
    }

    pub(super) fn stats(&self) -> &ChannelStats {
        &self.stats
    }

    pub(super) fn refreshes(&self) -> u64 {
        self.refresh.done()
    }

    /// Takes an entry at `now`, after all commands before `now`.
    pub(super) fn submit(
        &mut self,
        now: u64,
        segment: Segment,
        request: u32,
        direction: Direction,
        ledger: &mut Ledger,
    ) {
        if now > self.now {
            self.run(now - 1, ledger);
            if self.seen == [0; 2] {
                self.rest(now, ledger);
            }
            self.now = now;
            // Entries may have come of age.
            self.stale = true;
        }
        let Segment { bank, row, bursts, .. } = segment;
        let (order, need) = (self.orders, RowNeed::Nothing);
        self.orders += 1;
        let entry = Entry { order, seen: now, row, request, bursts, bank, direction, need };
        if self.seen[0] + self.seen[1] < self.limits.queue {
            self.see(entry);
            self.weigh_writes();
        } else {
            self.waiting.push_back(entry);
        }
    }

    /// The earliest time of the next command, if nothing arrives before it.
    pub(super) fn next_at(&mut self) -> Option<u64> {
        self.command().map(|command| command.at)
    }

    /// Issues all commands up to and including `until`.
    pub(super) fn run(&mut self, until: u64, ledger: &mut Ledger) {
        while let Some(command) = self.command().filter(|command| command.at <= until) {
            self.issue(command, ledger);
        }
    }

    /// The refreshes before `until`, while nothing waits.
    fn rest(&mut self, until: u64, ledger: &mut Ledger) {
        self.refresh.accessed();
        self.refresh.skip(self.now, until);
        #[cfg(test)]
        self.log.push(super::protocol::Issued::Rest { at: self.now, refreshes: self.refresh.done() });
        while let Some(command) =
            self.refresh.target(0).map(|target| self.refresh_command(&target)).filter(|next| next.at < until)
        {
            self.issue(command, ledger);
            self.refresh.accessed();
        }
    }

    fn see(&mut self, entry: Entry) {
        self.seen[entry.direction as usize] += 1;
        self.oldest_seen = self.oldest_seen.min(entry.seen);
        self.banks[entry.bank as usize].push(entry);
        self.update(entry.bank);
    }

    /// After a change to a bank.
    fn update(&mut self, number: u32) {
        let bank = &self.banks[number as usize];
        for direction in [Direction::Read, Direction::Write] {
            let side = direction as usize;
            let active = &mut self.active[side];
            active.iter_mut().for_each(|banks| *banks &= !(1 << number));
            if let Some(candidate) = bank.candidate(direction) {
                self.candidates[side][number as usize] = candidate;
                active[candidate.action as usize] |= 1 << number;
            }
        }
        self.stale = true;
    }

    #[inline]
    fn command(&mut self) -> Option<Command> {
        if self.stale {
            self.next = self.plan();
            self.stale = false;
        }
        #[cfg(test)]
        assert!(self.plan() == self.next, "the kept plan is not the plan");
        self.next
    }

    fn plan(&mut self) -> Option<Command> {
        let direction = self.direction();
        let aged = self.aged();
        let first = match aged {
            None => self.plan_access(direction),
            Some(_) => self.plan_by_bank(direction, aged, None),
        }?;
        let used = first.at.saturating_add(self.timings.rcd);
        if used < self.refresh.due() {
            return Some(first);
        }
        match self.refresh.target(self.wanted()).filter(|target| used >= target.from) {
            None => Some(first),
            Some(target) if target.held_up && target.banks >> first.bank & 1 == 1 => {
                self.plan_by_bank(direction, aged, Some(&target))
            }
            Some(target) => Some(first.min(self.refresh_command(&target))),
        }
    }

    /// The banks with entries.
    fn wanted(&self) -> u64 {
        self.active.iter().flatten().fold(0, |all, banks| all | banks)
    }

    /// The next command, but for refresh and the age cap.
    fn plan_access(&self, direction: Direction) -> Option<Command> {
        let side = direction as usize;
        let [columns, precharges, _, activates] = self.active[side];
        let mut best = Best(None);
        for bank in bits(columns) {
            let candidate = &self.candidates[side][bank as usize];
            best.offer(self.column_at(candidate.ready, bank, side), bank, candidate);
        }
        if best.later_than(self.now) {
            for bank in bits(precharges) {
                let candidate = &self.candidates[side][bank as usize];
                best.offer(candidate.ready.max(self.now), bank, candidate);
            }
        }
        let gate = self.activate_gate();
        if best.later_than(gate) {
            for bank in bits(activates) {
                let candidate = &self.candidates[side][bank as usize];
                best.offer(candidate.ready.max(gate), bank, candidate);
            }
        }
        best.0
    }

    /// As [`Self::plan_access`], where the oldest entry of some bank is past the age cap `aged`, or the banks of a refresh
    /// are held up.
    #[cold]
    fn plan_by_bank(
        &self,
        direction: Direction,
        aged: Option<u64>,
        held_up: Option<&Target>,
    ) -> Option<Command> {
        let side = direction as usize;
        let mut best = Best(held_up.map(|target| self.refresh_command(target)));
        for (bank, held) in (0..).zip(&self.banks) {
            let candidate = match held.entries.first() {
                Some(head) if aged.is_some_and(|aged| head.seen <= aged) => {
                    (head.direction == direction).then(|| held.candidate_for(0))
                }
                _ => held.candidate(direction),
            };
            let Some(candidate) = candidate else { continue };
            let at = self.earliest(&candidate, bank, side);
            // A row that could not be used before the refresh is opened after it.
            let used = match candidate.action {
                Action::Activate => at.saturating_add(self.timings.rcd),
                _ => at,
            };
            if held_up.is_none_or(|target| target.banks >> bank & 1 == 0 || used < target.from) {
                best.offer(at, bank, &candidate);
            }
        }
        best.0
    }

    /// The refresh of these banks, or the precharge of one before it.
    fn refresh_command(&self, target: &Target) -> Command {
        let mut at = target.from.max(self.activate_gate());
        for bank in bits(target.banks) {
            let held = &self.banks[bank as usize];
            if held.open != SHUT {
                let at = held.may_precharge.max(target.from).max(self.now);
                return Command { at, action: Action::Precharge, order: 0, bank, entry: u32::MAX };
            }
            at = at.max(held.may_activate);
        }
        let bank = target.banks.trailing_zeros();
        Command { at, action: Action::Refresh, order: 0, bank, entry: u32::MAX }
    }

    /// When the channel as a whole allows it.
    #[inline]
    fn earliest(&self, candidate: &Candidate, bank: u32, side: usize) -> u64 {
        match candidate.action {
            Action::Column => self.column_at(candidate.ready, bank, side),
            Action::Activate | Action::Refresh => candidate.ready.max(self.activate_gate()),
            Action::Precharge => candidate.ready.max(self.now),
        }
    }

    #[inline]
    fn column_at(&self, ready: u64, bank: u32, side: usize) -> u64 {
        let group = &self.group_column[usize::from(self.group[bank as usize])];
        ready.max(self.column[side]).max(group[side]).max(self.now)
    }

    /// Before it no bank is activated or refreshed.
    #[inline]
    fn activate_gate(&self) -> u64 {
        let gate = self.activate.max(self.now);
        match self.any_activates {
            4 => gate.max(self.activates[self.oldest_activate].saturating_add(self.timings.faw)),
            _ => gate,
        }
    }

    /// Entries seen by this time are past the age cap; `None` if there is none.
    fn aged(&mut self) -> Option<u64> {
        let aged = self.now.checked_sub(self.limits.age_cap)?;
        if self.oldest_seen <= aged {
            let heads = self.banks.iter().filter_map(|bank| bank.entries.first());
            self.oldest_seen = heads.map(|entry| entry.seen).min().unwrap_or(u64::MAX);
        }
        (self.oldest_seen <= aged).then_some(aged)
    }

    fn direction(&mut self) -> Direction {
        match self.seen {
            [_, 0] => Direction::Read,
            [0, _] => Direction::Write,
            _ => {
                let by_share = if self.draining { Direction::Write } else { Direction::Read };
                self.oldest_aged().unwrap_or(by_share)
            }
        }
    }

    /// After a change to what is seen.
    fn weigh_writes(&mut self) {
        let writes = self.seen[Direction::Write as usize];
        self.draining =
            writes >= if self.draining { self.limits.drain_to + 1 } else { self.limits.drain_from };
    }

    /// The direction of the oldest entry seen, if it is past the age cap.
    fn oldest_aged(&mut self) -> Option<Direction> {
        self.aged()?;
        let heads = self.banks.iter().filter_map(|bank| bank.entries.first());
        heads.min_by_key(|entry| entry.order).map(|entry| entry.direction)
    }

    fn issue(&mut self, command: Command, ledger: &mut Ledger) {
        let Command { at, action, bank, entry, .. } = command;
        self.now = at;
        #[cfg(test)]
        super::protocol::log(&mut self.log, &command, &self.banks, &self.timings);
        let index = entry as usize;
        let held = &mut self.banks[bank as usize];
        match action {
            Action::Column => self.access(at, bank, index, ledger),
            Action::Precharge => {
                match held.entries.get_mut(index) {
                    Some(entry) => entry.need = RowNeed::PrechargeAndActivate,
                    None => self.refresh.choose(bank),
                }
                held.precharge(at, &self.timings);
                self.update(bank);
            }
            Action::Activate => {
                let entry = &mut held.entries[index];
                if entry.need == RowNeed::Nothing {
                    entry.need = RowNeed::Activate;
                }
                let row = entry.row;
                held.activate(at, row, &self.timings);
                self.activated(at, self.timings.rrd);
                self.update(bank);
            }
            Action::Refresh => self.refresh(at, bank),
        }
    }

    /// One column command, or all of the entry's where nothing could use the bus between them.
    fn access(&mut self, at: u64, number: u32, index: usize, ledger: &mut Ledger) {
        let DramTimings { burst, ccd_s, ccd_l, .. } = self.timings;
        let bank = &mut self.banks[number as usize];
        let entry = &mut bank.entries[index];
        let direction = entry.direction;
        let bursts = if ccd_l == ccd_s { entry.bursts } else { 1 };
        entry.bursts -= bursts;
        let rest = entry.bursts;
        let last = at.saturating_add(burst.saturating_mul(u64::from(bursts - 1)));
        bank.access(last, direction, &self.timings);

        let group = &mut self.group_column[usize::from(self.group[number as usize])];
        let (same, other) = (direction as usize, 1 - direction as usize);
        let later = |wait: u64| last.saturating_add(wait);
        let (turn, turn_same_group, latency) = match direction {
            Direction::Read => {
                (self.timings.read_to_write, self.timings.read_to_write, self.timings.read_latency)
            }
            Direction::Write => {
                (self.timings.write_to_read_s, self.timings.write_to_read_l, self.timings.write_latency)
            }
        };
        self.column[same] = later(ccd_s);
        self.column[other] = self.column[other].max(later(turn));
        group[same] = later(ccd_l);
        group[other] = group[other].max(later(turn_same_group));

        self.refresh.accessed();
        self.stats.busy = self.stats.busy.saturating_add(burst.saturating_mul(u64::from(bursts)));
        match direction {
            Direction::Read => self.stats.read_bursts += u64::from(bursts),
            Direction::Write => self.stats.write_bursts += u64::from(bursts),
        }
        let served = (rest == 0).then(|| bank.remove(index));
        self.update(number);
        if let Some(entry) = served {
            self.seen[same] -= 1;
            self.stats.rows.count(entry.need);
            ledger.served(entry.request, later(latency.saturating_add(burst)));
            if let Some(waiting) = self.waiting.pop_front() {
                self.see(Entry { seen: at, ..waiting });
            }
            self.weigh_writes();
        }
    }

    /// A bank was activated or refreshed, and `wait` keeps others from either.
    fn activated(&mut self, at: u64, wait: u64) {
        self.activate = at.saturating_add(wait);
        self.activates[self.oldest_activate] = at;
        self.oldest_activate = (self.oldest_activate + 1) % 4;
        self.any_activates = (self.any_activates + 1).min(4);
    }

    /// Of the banks that `first` stands for.
    fn refresh(&mut self, at: u64, first: u32) {
        let banks = self.refresh.banks(first);
        self.refresh.refreshed(at, banks, &self.timings);
        for bank in bits(banks) {
            self.banks[bank as usize].refresh(at.saturating_add(self.timings.rfc));
            self.update(bank);
        }
        self.activated(at, self.timings.pbr2act);
        #[cfg(test)]
        self.log.push(super::protocol::Issued::Refresh { at, banks, number: self.refresh.done() });
    }
}
