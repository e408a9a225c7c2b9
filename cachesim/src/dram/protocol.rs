//! The slow and obvious twin of the scheduler's bookkeeping: checks every command that a channel issued
//! against the 200 before it, constraint by constraint as the standards list them, over random requests.

use proptest::prelude::*;

use super::bank::Direction::{self, Read, Write};
use super::bank::{Action, Bank, Entry};
use super::command::Command;
use super::{DRAM_STANDARDS, Done, Dram, DramConfig, DramStandard, DramTimings};

/// A command on a channel, at its time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Issued {
    Column { at: u64, bank: u32, row: u64, direction: Direction },
    Activate { at: u64, bank: u32, row: u64 },
    Precharge { at: u64, bank: u32 },
    Refresh { start: u64, end: u64 },
}

use Issued::{Activate, Column, Precharge, Refresh};

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
        Column { at, .. } | Activate { at, .. } | Precharge { at, .. } => at,
        Refresh { start, .. } => start,
    }
}

/// The least time from `first` to `second` that the standard allows.
fn spacing(first: &Issued, second: &Issued, groups: u32, t: &DramTimings) -> u64 {
    let written = t.write_latency + t.burst;
    match (*first, *second) {
        (Activate { bank, .. }, Activate { bank: other, .. }) if bank == other => t.rc,
        (Activate { .. }, Activate { .. }) => t.rrd,
        (Activate { bank, .. }, Precharge { bank: other, .. }) if bank == other => t.ras,
        (Activate { bank, .. }, Column { bank: other, .. }) if bank == other => t.rcd,
        (Activate { .. }, Refresh { .. }) => t.ras + t.rp_all.min(t.rp),
        (Precharge { bank, .. }, Activate { bank: other, .. }) if bank == other => t.rp,
        (Precharge { .. }, Refresh { .. }) => t.rp,
        (Column { bank, direction, .. }, Precharge { bank: other, .. }) if bank == other => match direction {
            Read => t.rtp,
            Write => written + t.wr,
        },
        (Column { direction, .. }, Refresh { .. }) => match direction {
            Read => t.rtp + t.rp_all.min(t.rp),
            Write => written + t.wr + t.rp_all.min(t.rp),
        },
        (Column { bank, direction, .. }, Column { bank: other, direction: next, .. }) => {
            let same_group = bank % groups == other % groups;
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

/// Panics at the first command that is too early, or touches a row that is not open.
fn check(log: &[Issued], groups: u32, banks: u32, t: &DramTimings) {
    let mut log = log.to_vec();
    // Columns of one request are logged together.
    log.sort_by_key(at);
    let mut open = vec![None; banks as usize];
    let mut activates = Vec::new();
    let mut data: Vec<(u64, u64)> = Vec::new();
    for (number, command) in log.iter().enumerate() {
        for earlier in &log[number.saturating_sub(200)..number] {
            let least = spacing(earlier, command, groups, t);
            assert!(at(command) >= at(earlier) + least, "{command:?} after {earlier:?}, least {least}");
            if let Refresh { end, .. } = *earlier {
                assert!(at(command) >= end, "{command:?} during {earlier:?}");
            }
        }
        match *command {
            Column { at, bank, row, direction } => {
                assert_eq!(open[bank as usize], Some(row), "{command:?}");
                let latency = if direction == Read { t.read_latency } else { t.write_latency };
                data.push((at + latency, at + latency + t.burst));
            }
            Activate { at, bank, row } => {
                assert_eq!(open[bank as usize].replace(row), None, "{command:?}");
                activates.push(at);
            }
            Precharge { bank, .. } => assert!(open[bank as usize].take().is_some(), "{command:?}"),
            Refresh { .. } => open.fill(None),
        }
    }
    assert!(activates.windows(5).all(|five| five[4] - five[0] >= t.faw), "five activates within tFAW");
    data.sort_unstable();
    assert!(data.windows(2).all(|two| two[0].1 <= two[1].0), "data overlaps on the bus");
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
    ) {
        let standard = DramStandard::builtin(DRAM_STANDARDS[standard].name).unwrap();
        let bytes_per_second = standard.fastest_channel() * f64::from(channels) * speed;
        let (banks, groups) = standard.banks_and_groups();
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
        for channel in &dram.channels {
            check(&channel.log, groups, banks, &timings);
        }
    }
}
