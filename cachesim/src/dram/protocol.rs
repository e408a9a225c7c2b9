//! The slow and obvious twin of the scheduler's bookkeeping: checks every command that a channel issued
//! against those before it, constraint by constraint as the standards list them, over random requests.

use proptest::prelude::*;

use super::bank::Direction::{self, Read, Write};
use super::bank::{Action, Bank, Entry};
use super::command::Command;
use super::{DRAM_STANDARDS, Done, Dram, DramConfig, DramStandard, DramTimings};

/// A command on a channel, at its time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Issued {
    Column {
        at: u64,
        bank: u32,
        row: u64,
        direction: Direction,
    },
    Activate {
        at: u64,
        bank: u32,
        row: u64,
    },
    Precharge {
        at: u64,
        bank: u32,
    },
    /// Of these banks, a bit each; the last of so many.
    Refresh {
        at: u64,
        banks: u64,
        number: u64,
    },
    /// Nothing waits from then on for so long that all refreshes up to this number are over, in whole rounds.
    Rest {
        at: u64,
        refreshes: u64,
    },
}

use Issued::{Activate, Column, Precharge, Refresh, Rest};

/// Appends a command that is about to be issued; refreshes log themselves.
pub(super) fn log(log: &mut Vec<Issued>, command: &Command, banks: &[Bank], timings: &DramTimings) {
    let Command { at, action, bank, entry, .. } = *command;
    let entry = banks[bank as usize].entries.get(entry as usize).copied();
    match (action, entry) {
        (Action::Column, Some(Entry { direction, row, bursts, .. })) => {
            let count = if timings.ccd_l == timings.ccd_s { bursts } else { 1 };
            let commands = (0..u64::from(count)).map(|number| at + number * timings.burst);
            log.extend(commands.map(|at| Column { at, bank, row, direction }));
        }
        (Action::Activate, Some(Entry { row, .. })) => log.push(Activate { at, bank, row }),
        (Action::Precharge, _) => log.push(Precharge { at, bank }),
        _ => {}
    }
}

fn at(command: &Issued) -> u64 {
    match *command {
        Column { at, .. }
        | Activate { at, .. }
        | Precharge { at, .. }
        | Refresh { at, .. }
        | Rest { at, .. } => at,
    }
}

/// What a channel is checked against.
struct Rules {
    timings: DramTimings,
    banks: u32,
    groups: u32,
    /// Refresh commands that refresh every bank once.
    round: u64,
    /// Of which so many may be owed.
    postponed: u64,
}

impl Rules {
    fn new(config: &DramConfig) -> Self {
        let organisation = &config.standard.organisation;
        let round = u64::from(organisation.banks / organisation.refresh_banks);
        Self {
            timings: config.timings().unwrap(),
            banks: organisation.banks,
            groups: organisation.bank_groups,
            round,
            postponed: round * u64::from(config.standard.controller.refresh_postponed),
        }
    }

    /// The least time from `first` to `second` that the standard allows.
    fn spacing(&self, first: &Issued, second: &Issued) -> u64 {
        let t = &self.timings;
        let written = t.write_latency + t.burst;
        match (*first, *second) {
            (Activate { bank, .. }, Activate { bank: other, .. }) if bank == other => t.rc,
            (Activate { .. }, Activate { .. }) => t.rrd,
            (Activate { bank, .. }, Precharge { bank: other, .. }) if bank == other => t.ras,
            (Activate { bank, .. }, Column { bank: other, .. }) if bank == other => t.rcd,
            (Activate { bank, .. }, Refresh { banks, .. }) if has(banks, bank) => t.rc,
            (Activate { .. }, Refresh { .. }) => t.rrd,
            (Precharge { bank, .. }, Activate { bank: other, .. }) if bank == other => t.rp,
            (Precharge { bank, .. }, Refresh { banks, .. }) if has(banks, bank) => t.rp,
            (Refresh { banks, .. }, Activate { bank, .. }) if has(banks, bank) => t.rfc,
            (Refresh { .. }, Activate { .. }) => t.pbr2act,
            (Refresh { banks, .. }, Refresh { banks: others, .. }) if banks & others != 0 => {
                t.rfc.max(t.pbr2pbr)
            }
            (Refresh { .. }, Refresh { .. }) => t.pbr2pbr,
            (Column { bank, direction, .. }, Precharge { bank: other, .. }) if bank == other => {
                match direction {
                    Read => t.rtp,
                    Write => written + t.wr,
                }
            }
            (Column { bank, direction, .. }, Column { bank: other, direction: next, .. }) => {
                let same_group = bank % self.groups == other % self.groups;
                match (direction, next, same_group) {
                    (Read, Read, true) | (Write, Write, true) => t.ccd_l,
                    (Read, Read, false) | (Write, Write, false) => t.burst,
                    (Read, Write, _) => t.read_to_write,
                    (Write, Read, true) => t.write_to_read_l,
                    (Write, Read, false) => t.write_to_read_s,
                }
            }
            _ => 0,
        }
    }

    /// How late a refresh may be beyond what may be owed, longer than any spacing: the rows of its banks have to be
    /// shut first, and a column command has to be issued since the last refresh.
    fn grace(&self) -> u64 {
        let t = &self.timings;
        let shut = t.ras.max(t.write_latency + t.burst + t.wr) + t.rp;
        let column = t.rfc + t.rcd + t.read_to_write.max(t.write_to_read_l);
        2 * (shut + column + t.faw.max(t.pbr2pbr))
    }

    /// Complains of the first command that is too early or too late, or touches a row that is not open.
    fn check(&self, log: &[Issued]) -> Result<(), String> {
        let t = &self.timings;
        let mut log = log.to_vec();
        // Columns of one request are logged together.
        log.sort_by_key(at);
        let mut open = vec![None; self.banks as usize];
        let mut activates = Vec::new();
        let mut data: Vec<(u64, u64)> = Vec::new();
        let (interval, grace) = (t.refi / self.round, self.grace());
        // Where refreshes cannot keep pace, they are not demanded in time.
        let deadlines = grace / 2 < interval;
        let (mut refreshes, mut in_round) = (0, 0_u64);
        for (index, command) in log.iter().enumerate() {
            let ensure = |holds: bool, problem: &str| {
                if holds { Ok(()) } else { Err(format!("{command:?}: {problem}")) }
            };
            for earlier in log[..index].iter().rev().take_while(|earlier| at(earlier) + grace > at(command)) {
                let least = self.spacing(earlier, command);
                if at(command) < at(earlier) + least {
                    return Err(format!("{command:?} less than {least} after {earlier:?}"));
                }
            }
            let owed = (at(command).saturating_sub(grace) / interval).saturating_sub(refreshes);
            ensure(!deadlines || owed <= self.postponed, "a refresh is overdue")?;
            match *command {
                Column { at, bank, row, direction } => {
                    ensure(open[bank as usize] == Some(row), "the row is not open")?;
                    let latency = if direction == Read { t.read_latency } else { t.write_latency };
                    data.push((at + latency, at + latency + t.burst));
                }
                Activate { at, bank, row } => {
                    ensure(open[bank as usize].replace(row).is_none(), "a row is open")?;
                    activates.push(at);
                }
                Precharge { bank, .. } => ensure(open[bank as usize].take().is_some(), "no row is open")?,
                Refresh { at, banks, number } => {
                    let shut = (0..self.banks).all(|bank| !has(banks, bank) || open[bank as usize].is_none());
                    ensure(shut, "a row is open")?;
                    ensure(at >= number * interval, "not due yet")?;
                    ensure(!deadlines || number == refreshes + 1, "refreshes are missing")?;
                    if (number - 1) % self.round == 0 {
                        in_round = 0;
                    }
                    ensure(in_round & banks == 0, "a bank twice in a round")?;
                    in_round |= banks;
                    refreshes = number;
                    activates.push(at);
                }
                Rest { refreshes: number, .. } => refreshes = number,
            }
        }
        if activates.windows(5).any(|five| five[4] - five[0] < t.faw) {
            return Err("five activates within tFAW".to_owned());
        }
        data.sort_unstable();
        if data.windows(2).any(|two| two[0].1 > two[1].0) {
            return Err("data overlaps on the bus".to_owned());
        }
        Ok(())
    }
}

fn has(banks: u64, bank: u32) -> bool {
    banks >> bank & 1 == 1
}

#[derive(Clone, Copy, Debug)]
struct Request {
    after: u64,
    address: u64,
    bytes: u32,
    write: bool,
}

fn request() -> impl Strategy<Value = Request> {
    let after = prop_oneof![3 => Just(0), 3 => 0..20_000u64, 1 => 0..10_000_000u64];
    let address = prop_oneof![0..1u64 << 14, 0..1u64 << 22, any::<u64>()];
    let bytes = prop_oneof![5 => Just(64u32), 2 => 0..600u32];
    (after, address, bytes, prop::bool::weighted(0.3)).prop_map(|(after, address, bytes, write)| Request {
        after,
        address,
        bytes,
        write,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_request_finishes_in_time_by_legal_commands(
        standard in 0..DRAM_STANDARDS.len(),
        requests in prop::collection::vec(request(), 1..400),
        channels in 1..6u32,
        queue in prop_oneof![1..4u32, 4..80u32],
        speed in prop_oneof![Just(1.0), 0.01..1.5f64],
        postponed in prop_oneof![Just(8), 0..3u32],
    ) {
        let mut standard = DramStandard::builtin(DRAM_STANDARDS[standard].name).unwrap();
        standard.controller.refresh_postponed = postponed;
        let bytes_per_second = standard.fastest_channel() * f64::from(channels) * speed;
        let config = DramConfig { standard, channels, bytes_per_second, queue };
        let mut dram = Dram::new(&config).unwrap();
        let timings = *dram.timings();
        let (mut now, mut done, mut submitted) = (0, Vec::new(), Vec::new());
        for (tag, request) in (0..).zip(&requests) {
            now += request.after;
            submitted.push(now);
            dram.submit(now, request.address, request.bytes, request.write, tag);
            // Asking for the next event must change nothing, however often.
            if tag % 3 == 0 {
                let event = dram.next_event().unwrap();
                prop_assert_eq!(dram.next_event(), Some(event));
                dram.advance(now, &mut done);
            }
        }
        while let Some(event) = dram.next_event() {
            let before = done.len();
            dram.advance(event - 1, &mut done);
            prop_assert_eq!(done.len(), before, "something finished before the next event");
            dram.advance(event, &mut done);
        }
        prop_assert!(done.is_sorted_by_key(|done: &Done| done.at_ps));
        let mut tags: Vec<_> = done.iter().map(|done| done.tag).collect();
        tags.sort_unstable();
        prop_assert!(tags.into_iter().eq(0..requests.len() as u32));
        for Done { at_ps, tag } in done {
            let Request { write, .. } = requests[tag as usize];
            let latency = if write { timings.write_latency } else { timings.read_latency };
            prop_assert!(at_ps >= submitted[tag as usize] + latency + timings.burst);
        }
        let stats = dram.stats();
        let bursts = |request: &Request| {
            let last = request.address.saturating_add(u64::from(request.bytes.max(1)) - 1);
            last / 32 - request.address / 32 + 1
        };
        let moved: u64 = requests.iter().map(bursts).sum();
        prop_assert_eq!(stats.read_bytes + stats.written_bytes, moved * 32);
        prop_assert_eq!(stats.busy_ps.iter().sum::<u64>(), moved * timings.burst);
        let rules = Rules::new(&config);
        for channel in &dram.channels {
            prop_assert_eq!(rules.check(&channel.log), Ok(()));
        }
    }
}

/// Rules of each standard at its fastest.
fn rules() -> impl Iterator<Item = Rules> {
    DRAM_STANDARDS.iter().map(|standard| {
        let standard = DramStandard::builtin(standard.name).unwrap();
        let bytes_per_second = standard.fastest_channel();
        Rules::new(&DramConfig { standard, channels: 1, bytes_per_second, queue: 1 })
    })
}

/// The two commands are legal if `wait` lies between them, and not if it is a clock less.
#[track_caller]
fn assert_least(rules: &Rules, before: &[Issued], wait: u64, second: impl Fn(u64) -> Issued) {
    let last = at(before.last().unwrap());
    let legal = |time: u64| rules.check(&[before, &[second(time)]].concat());
    assert_eq!(legal(last + wait), Ok(()));
    assert!(legal(last + wait - rules.timings.clock).is_err(), "{before:?}, {wait}");
}

#[test]
fn a_refresh_keeps_its_banks_for_trfc_and_others_for_little() {
    for rules in rules() {
        let Rules { timings: t, round, .. } = rules;
        let due = t.refi / round;
        let pair = if round == 8 && rules.banks == 16 { 0b101 } else { 0b1 };
        let first = [Refresh { at: 2 * due, banks: pair, number: 1 }];
        for bank in (0..rules.banks).filter(|bank| has(pair, *bank)) {
            assert_least(&rules, &first, t.rfc, |at| Activate { at, bank, row: 0 });
        }
        assert_least(&rules, &first, t.pbr2act, |at| Activate { at, bank: 1, row: 0 });
        assert_least(&rules, &first, t.pbr2pbr, |at| Refresh { at, banks: pair << 1, number: 2 });
    }
}

#[test]
fn other_banks_are_used_while_one_is_refreshed() {
    for rules in rules() {
        let t = rules.timings;
        let refresh = Refresh { at: t.refi, banks: 1, number: 1 };
        let opened = Activate { at: t.refi + t.pbr2act, bank: 1, row: 7 };
        let used = t.refi + t.pbr2act + t.rcd;
        assert!(used < t.refi + t.rfc);
        let column = Column { at: used, bank: 1, row: 7, direction: Read };
        assert_eq!(rules.check(&[refresh, opened, column]), Ok(()));
    }
}

#[test]
fn a_refresh_waits_for_the_row_cycle_and_the_precharge_of_its_banks_and_for_activates_of_others() {
    for rules in rules() {
        let t = rules.timings;
        let refresh = |at| Refresh { at, banks: 1, number: 1 };
        let opened = |bank| Activate { at: t.refi, bank, row: 0 };
        let shut = |at| Precharge { at, bank: 0 };
        assert!(rules.check(&[opened(0), refresh(2 * t.refi)]).is_err(), "a row is open");
        assert_least(&rules, &[opened(0), shut(t.refi + t.rc)], t.rp, refresh);
        assert_least(&rules, &[opened(1)], t.rrd, refresh);
        assert_least(&rules, &[opened(0), shut(t.refi + t.rc - t.rp)], t.rp, refresh);
    }
}

#[test]
fn refreshes_are_due_overdue_and_once_per_bank_and_round() {
    for rules in rules() {
        let due = rules.timings.refi / rules.round;
        let refresh = |at, banks, number| Refresh { at, banks, number };
        assert_eq!(rules.check(&[refresh(due, 1, 1)]), Ok(()));
        assert!(rules.check(&[refresh(due - 1, 1, 1)]).is_err());
        let last = (rules.postponed + 1) * due + rules.grace();
        assert_eq!(rules.check(&[refresh(last - 1, 1, 1)]), Ok(()));
        assert!(rules.check(&[refresh(last, 1, 1)]).is_err());
        assert!(rules.check(&[refresh(due, 1, 1), refresh(2 * due, 1, 2)]).is_err());
        assert!(rules.check(&[refresh(due, 1, 1), refresh(3 * due, 2, 3)]).is_err());
    }
}
