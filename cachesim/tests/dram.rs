//! Is the time of DRAM what the closed formulas say? Expected figures come from the standards by hand, or from
//! the formula in the test's name.

use cachesim::{DRAM_STANDARDS, Done, Dram, DramConfig, DramStandard, DramTimings, RowTally};

/// A channel of each standard at a data rate whose clock is a round number.
const RATES: [(&str, f64); 3] =
    [("lpddr4x", 12_800.0 / 3.0), ("lpddr5", 6400.0), ("lpddr5x", 25_600.0 / 3.0)];

fn config(name: &str, mbps: f64, channels: u32, queue: u32) -> DramConfig {
    let standard = DramStandard::builtin(name).unwrap();
    DramConfig { standard, channels, bytes_per_second: mbps * 2e6 * f64::from(channels), queue }
}

fn one_channel(name: &str) -> DramConfig {
    let (_, mbps) = RATES.into_iter().find(|(rate, _)| *rate == name).unwrap();
    config(name, mbps, 1, 32)
}

/// An address of one channel by bank and row.
fn address(standard: &DramStandard, bank: u64, row: u64, line: u64) -> u64 {
    let (banks, groups) = standard.banks_and_groups();
    let (banks, groups) = (u64::from(banks), u64::from(groups));
    if groups == 1 {
        (row * banks + bank) * standard.row_bytes() + line * 64
    } else {
        let above = (row * (banks / groups) + bank / groups) * (standard.row_bytes() / 64) + line;
        (above * groups + bank % groups) * 64
    }
}

#[derive(Clone, Copy)]
struct Request {
    at: u64,
    address: u64,
    bytes: u32,
    write: bool,
}

fn read(at: u64, address: u64, bytes: u32) -> Request {
    Request { at, address, bytes, write: false }
}

/// Finishing times by request, and the memory afterwards.
fn run(config: &DramConfig, requests: &[Request]) -> (Vec<u64>, Dram) {
    let mut dram = Dram::new(config).unwrap();
    let mut done = Vec::new();
    for (tag, request) in (0..).zip(requests) {
        dram.submit(request.at, request.address, request.bytes, request.write, tag);
    }
    while let Some(at) = dram.next_event() {
        dram.advance(at, &mut done);
    }
    assert!(done.is_sorted_by_key(|done: &Done| done.at_ps));
    let mut ends = vec![None; requests.len()];
    for Done { at_ps, tag } in done {
        assert_eq!(ends[tag as usize].replace(at_ps), None, "request {tag} finished twice");
    }
    (ends.into_iter().map(|end| end.expect("every request finishes")).collect(), dram)
}

fn timings(config: &DramConfig) -> DramTimings {
    config.timings().unwrap()
}

/// Measured against expected, both sides.
fn assert_within(measured: f64, expected: f64, tolerance: f64, what: &str) {
    let off = measured / expected - 1.0;
    assert!(off.abs() <= tolerance, "{what}: {measured}, expected {expected}, off by {:.3} %", off * 100.0);
}

#[test]
fn a_read_of_an_idle_bank_takes_activate_latency_and_burst() {
    // Clocks by hand: LPDDR4X 39 + 36 + 8 of 468.75 ps, LPDDR5 15 + 17 + 2 of 1250 ps, LPDDR5X 20 + 23 + 2 of 937.5.
    for (name, expected) in [("lpddr4x", 38_906), ("lpddr5", 42_500), ("lpddr5x", 42_188)] {
        let config = one_channel(name);
        let (ends, dram) = run(&config, &[read(1000, 0, 32)]);
        assert_eq!(ends, [1000 + expected], "{name}");
        assert_eq!(timings(&config).row_miss(), expected, "{name}");
        assert_eq!((dram.stats().rows.misses, dram.stats().read_latency_ps), (1, expected));
    }
}

#[test]
fn a_row_conflict_takes_a_precharge_more_and_a_row_hit_an_activate_less() {
    // Precharge by hand: 39 x 468.75, 15 x 1250, 20 x 937.5 ps.
    for (name, precharge, hit) in
        [("lpddr4x", 18_281, 20_625), ("lpddr5", 18_750, 23_750), ("lpddr5x", 18_750, 23_438)]
    {
        let config = one_channel(name);
        let miss = timings(&config).row_miss();
        let at = |row, line| address(&config.standard, 3, row, line);
        let requests = [read(0, at(0, 0), 32), read(200_000, at(0, 1), 32), read(400_000, at(1, 0), 32)];
        let (ends, dram) = run(&config, &requests);
        assert_eq!(ends, [miss, 200_000 + hit, 400_000 + precharge + miss], "{name}");
        let rows = dram.stats().rows;
        assert_eq!((rows.misses, rows.hits, rows.conflicts), (1, 1, 1), "{name}");
    }
}

#[test]
fn a_line_of_two_bursts_takes_one_burst_more_or_a_gap_more_within_a_bank_group() {
    for (name, second) in [("lpddr4x", 3750), ("lpddr5", 5000), ("lpddr5x", 3750)] {
        let config = one_channel(name);
        let (ends, _) = run(&config, &[read(0, 0, 64)]);
        assert_eq!(ends, [timings(&config).row_miss() + second], "{name}");
    }
}

#[test]
fn a_stream_of_lines_reaches_the_peak_beside_refresh() {
    for (name, mbps) in RATES {
        for channels in [1, 3, 4] {
            let config = config(name, mbps, channels, 32);
            let lines = 40_000 * u64::from(channels);
            let requests: Vec<_> = (0..lines).map(|line| read(0, line * 64, 64)).collect();
            let (ends, dram) = run(&config, &requests);
            let seconds = *ends.iter().max().unwrap() as f64 * 1e-12;
            let reached = (lines * 64) as f64 / seconds;
            assert!(dram.stats().refreshes > 0);
            let expected = config.bytes_per_second;
            assert_within(reached, expected, 0.01, &format!("{name}, {channels} channels"));
        }
    }
}

#[test]
fn rows_of_one_bank_follow_each_other_by_the_row_cycle() {
    for (name, _) in RATES {
        let config = one_channel(name);
        // Few enough to end before the first refresh.
        let requests: Vec<_> = (0..8).map(|row| read(0, address(&config.standard, 5, row, 0), 32)).collect();
        let (ends, dram) = run(&config, &requests);
        let expected: Vec<_> =
            (0..8).map(|row| timings(&config).row_miss() + row * timings(&config).rc).collect();
        assert_eq!(ends, expected, "{name}");
        assert_eq!(dram.stats().rows.conflicts, 7, "{name}");
    }
}

#[test]
fn one_bank_loses_the_time_of_its_refreshes() {
    for (name, _) in RATES {
        let config = one_channel(name);
        let standard = &config.standard;
        let time = timings(&config);
        let DramTimings { rc, rfc, refi, ccd_l, .. } = time;
        let count = 60_000;
        // All of one row: precharge, refresh and activate per interval. A row each: between two rows' cycles.
        let hits = (count * 2 * ccd_l) as f64 / (1.0 - time.refresh_share());
        let rows = (count * rc) as f64 / (1.0 - rfc as f64 / refi as f64);
        for (expected, place) in [(hits, (|at| (0, at % 32)) as fn(u64) -> (u64, u64)), (rows, |at| (at, 0))]
        {
            let requests: Vec<_> = (0..count)
                .map(place)
                .map(|(row, line)| read(0, address(standard, 5, row, line), 64))
                .collect();
            let took = *run(&config, &requests).0.iter().max().unwrap();
            assert_within(took as f64, expected, 0.01, name);
        }
    }
}

#[test]
fn a_new_row_per_access_over_all_banks_is_bound_by_activates_or_the_bus() {
    for (name, mbps) in RATES {
        for (bytes, slower) in [(32, 1.0), (64, 1.0), (32, 0.25)] {
            let config = config(name, mbps * slower, 1, 32);
            let DramTimings { rrd, faw, burst, rc, rfc, pbr2act, refi, .. } = timings(&config);
            let banks = u64::from(config.standard.banks_and_groups().0);
            let count = 20_000;
            let requests: Vec<_> = (0..count)
                .map(|number| read(0, address(&config.standard, number % banks, number / banks, 0), bytes))
                .collect();
            let (ends, _) = run(&config, &requests);
            let bus = burst * u64::from(bytes / 32);
            // Refresh takes its time from the banks, and the place of activates, but nothing from the bus.
            let refi = refi as f64;
            let by_banks = rc as f64 / banks as f64 / (1.0 - rfc as f64 / refi);
            let by_activates = rrd.max(faw / 4) as f64 / (1.0 - 8.0 * pbr2act as f64 / refi);
            let expected = count as f64 * by_banks.max(by_activates).max(bus as f64);
            let took = *ends.iter().max().unwrap() as f64;
            assert_within(took, expected, 0.01, &format!("{name} x {slower}, {bytes} bytes"));
        }
    }
}

#[test]
fn reads_and_writes_in_turn_cost_both_turnarounds() {
    for (name, _) in RATES {
        let config = DramConfig { queue: 1, ..one_channel(name) };
        let requests: Vec<_> = (0..40)
            .map(|number| Request {
                at: 0,
                address: address(&config.standard, 0, 0, 0),
                bytes: 32,
                write: number % 2 == 1,
            })
            .collect();
        let (ends, _) = run(&config, &requests);
        let timings = timings(&config);
        let pair = timings.read_to_write + timings.write_to_read_l;
        for (turn, ends) in (0..).zip(ends.chunks(2)) {
            let read = timings.row_miss() + turn * pair;
            let write_more = timings.read_to_write + timings.write_latency - timings.read_latency;
            assert_eq!(ends, [read, read + write_more], "{name}, pair {turn}");
        }
    }
    // By hand, LPDDR4X: 36 + 8 + 4 + 2 - 18 clocks to a write, 18 + 8 + 22 to a read.
    let timings = timings(&one_channel("lpddr4x"));
    assert_eq!((timings.read_to_write, timings.write_to_read_l), (15_000, 22_500));
}

#[test]
fn writes_are_drained_together_while_reads_wait_little() {
    let config = one_channel("lpddr4x");
    let requests: Vec<_> = (0..2000)
        .map(|number| Request { at: 0, address: number * 64, bytes: 64, write: number % 2 == 1 })
        .collect();
    let (ends, dram) = run(&config, &requests);
    let DramTimings { burst, read_to_write, write_to_read_l, .. } = timings(&config);
    let took = *ends.iter().max().unwrap();
    let bus = 4000 * burst;
    let alternating = 1000 * (read_to_write + write_to_read_l);
    assert!(took > bus && took < bus + alternating / 8, "{took}, bus {bus}, in turn {alternating}");
    assert_eq!((dram.stats().reads, dram.stats().writes), (1000, 1000));
}

#[test]
fn refreshes_come_once_per_interval_bank_and_channel() {
    for (name, mbps) in RATES {
        let config = config(name, mbps, 2, 32);
        let requests: Vec<_> = (0..20_000).map(|line| read(0, line * 64, 64)).collect();
        let (ends, dram) = run(&config, &requests);
        let last = *ends.iter().max().unwrap();
        // Eight banks, or pairs of banks.
        let due = 2 * (last / (dram.timings().refi / 8));
        let refreshes = dram.stats().refreshes;
        assert!(refreshes.abs_diff(due) <= 4, "{name}: {refreshes}, {due} due");
    }
}

#[test]
fn a_refresh_delays_a_read_of_its_bank_and_shuts_the_row() {
    let config = one_channel("lpddr4x");
    let DramTimings { refi, rfc, rp, pbr2act, .. } = timings(&config);
    let (hit, miss) = (timings(&config).row_hit(), timings(&config).row_miss());
    let of_bank = |at, bank| read(at, address(&config.standard, bank, 0, 0), 32);
    // Bank 0 is the first to be refreshed.
    let due = refi / 8;
    assert_eq!(run(&config, &[of_bank(due + 1, 0)]).0, [due + rfc + miss]);
    assert_eq!(run(&config, &[of_bank(due + 1, 1)]).0, [due + pbr2act + miss]);
    // With its row open, after a precharge.
    let second = |at| run(&config, &[of_bank(0, 0), of_bank(at, 0)]);
    assert_eq!(second(due + 1).0, [miss, due + rp + rfc + miss]);
    // Before, a row hit; a round later the row is shut whatever happens.
    assert_eq!(second(due - 1).0, [miss, due - 1 + hit]);
    let (ends, dram) = second(refi + due - 1);
    assert_eq!(ends, [miss, refi + due - 1 + miss]);
    assert_eq!((dram.stats().rows.hits, dram.stats().rows.misses), (0, 2));
}

#[test]
fn banks_are_shut_in_pairs_by_refreshes_of_lpddr5() {
    let config = one_channel("lpddr5");
    let DramTimings { refi, rfc, .. } = timings(&config);
    let miss = timings(&config).row_miss();
    let due = refi / 8;
    for (bank, wait) in [(0, rfc), (2, rfc), (4, 0)] {
        let later = due + 20_000;
        let (ends, _) = run(&config, &[read(later, address(&config.standard, bank, 0, 0), 32)]);
        assert_eq!(ends, [(due + wait).max(later) + miss], "bank {bank}");
    }
}

#[test]
fn row_hits_go_first_and_beat_the_order_of_arrival() {
    for (name, _) in RATES {
        let seeing = one_channel(name);
        let blind = DramConfig { queue: 1, ..seeing.clone() };
        let requests: Vec<_> =
            (0..24).map(|number| read(0, address(&seeing.standard, 2, number % 2, number / 2), 32)).collect();
        let (seen, dram) = run(&seeing, &requests);
        let (in_turn, _) = run(&blind, &requests);
        let timings = timings(&seeing);
        // All of row 0, then all of row 1; against a row cycle per request.
        assert_eq!(dram.stats().rows.hits, 22, "{name}");
        let last = |ends: &[u64]| *ends.iter().max().unwrap();
        // Refreshes of other banks take the place of activates.
        let in_turn_at_best = timings.row_miss() + 23 * timings.rc;
        assert!(last(&in_turn) >= in_turn_at_best, "{name}");
        assert_within(last(&in_turn) as f64, in_turn_at_best as f64, 0.01, name);
        assert!(last(&seen) * 4 < last(&in_turn), "{name}: {} against {}", last(&seen), last(&in_turn));
    }
}

#[test]
fn a_request_for_another_row_is_served_at_the_age_cap() {
    let config = one_channel("lpddr4x");
    let at = |row, line| address(&config.standard, 0, row, line);
    let mut requests: Vec<_> = (0..8).map(|line| read(0, at(0, line), 32)).collect();
    requests.push(read(0, at(1, 0), 32));
    // A hit to row 0 every burst, so that it is never exhausted.
    let burst = timings(&config).burst;
    requests.extend((1..1000).map(|number| read(number * burst, at(0, number % 32), 32)));
    let (ends, _) = run(&config, &requests);
    let cap = 2_000_000;
    let least = cap;
    let most = cap + timings(&config).row_conflict() + timings(&config).rc;
    assert!((least..=most).contains(&ends[8]), "{}, expected {least} to {most}", ends[8]);
}

#[test]
fn large_requests_are_cut_and_finish_with_their_last_burst() {
    let config = config("lpddr5", 6400.0, 4, 32);
    let (whole, dram) = run(&config, &[read(0, 100, 10_000)]);
    let lines: Vec<_> = (1..158).map(|line| read(0, line * 64, 64)).collect();
    let (parts, _) = run(&config, &lines);
    assert_eq!(whole[0], *parts.iter().max().unwrap());
    // Bytes 96 to 10,112 in bursts of 32.
    assert_eq!((dram.stats().read_bytes, dram.stats().reads), (10_016, 1));
    let busy: u64 = dram.stats().busy_ps.iter().sum();
    assert_eq!(busy, 10_016 / 32 * dram.timings().burst);
}

#[test]
fn more_bandwidth_makes_no_stream_slower_but_for_the_phase_of_refreshes_from_1_byte_per_second_to_1e16() {
    for standard in DRAM_STANDARDS {
        let mut before = u64::MAX;
        for exponent in 0..=32 {
            let config = DramConfig {
                standard: DramStandard::builtin(standard.name).unwrap(),
                channels: 2,
                bytes_per_second: 10f64.powf(f64::from(exponent) / 2.0),
                queue: 16,
            };
            let requests: Vec<_> = (0..2000)
                .map(|line| Request { at: 0, address: line * 64, bytes: 64, write: line % 7 == 0 })
                .collect();
            let (ends, _) = run(&config, &requests);
            let took = *ends.iter().max().unwrap();
            let most = before.saturating_add(before / 100);
            assert!(took <= most, "{}: 10^({exponent}/2) B/s takes {took}, less {before}", standard.name);
            before = took;
        }
    }
}

#[test]
fn times_saturate_instead_of_overflowing_and_everything_finishes() {
    for channels in [1, 64] {
        let standard = DramStandard::builtin("lpddr4x").unwrap();
        let config = DramConfig { standard, channels, bytes_per_second: 1.0, queue: 4 };
        let requests: Vec<_> = (0..3000)
            .map(|number| Request {
                at: u64::MAX - 1_000_000_000_000_000,
                address: u64::MAX - number * 64,
                bytes: 256,
                write: number % 2 == 0,
            })
            .collect();
        let (ends, _) = run(&config, &requests);
        assert!(ends.contains(&u64::MAX));
    }
}

#[test]
fn the_same_requests_give_the_same_times_however_often_time_is_advanced() {
    let config = config("lpddr5x", 8533.0, 4, 24);
    let requests: Vec<_> = (0..3000u64)
        .map(|number| Request {
            at: number * 2000,
            address: number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32,
            bytes: 64,
            write: number % 5 == 0,
        })
        .collect();
    let (expected, once) = run(&config, &requests);
    let mut dram = Dram::new(&config).unwrap();
    let mut done = Vec::new();
    for (tag, request) in (0..).zip(&requests) {
        while let Some(at) = dram.next_event().filter(|at| *at < request.at) {
            dram.advance(at, &mut done);
        }
        dram.submit(request.at, request.address, request.bytes, request.write, tag);
    }
    dram.advance(u64::MAX, &mut done);
    let mut ends = vec![0; requests.len()];
    done.iter().for_each(|done| ends[done.tag as usize] = done.at_ps);
    assert_eq!(ends, expected);
    assert_eq!(dram.stats(), once.stats());
}

#[test]
fn the_tally_counts_rows_as_a_memory_that_serves_in_order() {
    for (name, _) in RATES {
        let config = DramConfig { queue: 1, ..one_channel(name) };
        let mut tally = RowTally::new(&config).unwrap();
        // Few enough to end before the first refresh.
        let requests: Vec<_> =
            (0..13u64).map(|number| read(0, number * number * 4096 % (1 << 18), 64)).collect();
        requests.iter().for_each(|request| tally.record(request.address, request.bytes));
        let (ends, dram) = run(&config, &requests);
        assert_eq!(tally.rows(), dram.stats().rows, "{name}");
        assert_eq!(tally.channel_bytes().sum::<u64>(), dram.stats().read_bytes);
        let banks: u64 = tally.bank_rows(0).map(|rows| rows.hits + rows.misses + rows.conflicts).sum();
        assert_eq!((banks, tally.bank_rows(1).count()), (13, 0));
        assert!(tally.service_ps() <= *ends.iter().max().unwrap());
    }
}

#[test]
fn the_bound_of_the_tally_is_tight_for_streams_rows_of_a_bank_and_rows_of_all_banks() {
    for (name, _) in RATES {
        let config = one_channel(name);
        let standard = &config.standard;
        let banks = u64::from(standard.banks_and_groups().0);
        let kinds: [(&str, Vec<u64>); 3] = [
            ("stream", (0..30_000).map(|line| line * 64).collect()),
            ("one bank", (0..3000).map(|row| address(standard, 1, row, 0)).collect()),
            ("all banks", (0..20_000).map(|at| address(standard, at % banks, at / banks, 0)).collect()),
        ];
        for (kind, addresses) in kinds {
            let mut tally = RowTally::new(&config).unwrap();
            addresses.iter().for_each(|address| tally.record(*address, 64));
            let requests: Vec<_> = addresses.iter().map(|address| read(0, *address, 64)).collect();
            let took = *run(&config, &requests).0.iter().max().unwrap();
            let bound = tally.service_ps();
            assert!(bound <= took, "{name}, {kind}: bound {bound}, took {took}");
            // Refresh of the bank is not in it.
            let DramTimings { rfc, refi, .. } = timings(&config);
            let refreshed = if kind == "stream" { 1.0 } else { 1.0 - rfc as f64 / refi as f64 };
            assert_within(bound as f64, took as f64 * refreshed, 0.03, &format!("{name}, {kind}"));
        }
    }
}
