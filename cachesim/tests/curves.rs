//! Miss-ratio curves: are the exact ones those of replays, and how far are the quick answers from them?

use cachesim::synthetic::{Stream, lines};
use cachesim::{
    Aet, Bytes, Hierarchy, LevelConfig, Levels, LineId, LineSize, MissCurve, Policy, StackDistances, Ways,
};
use proptest::prelude::*;

const STREAMS: [Stream; 3] = [Stream::Bvh, Stream::Rnd, Stream::Seq];

fn exact(trace: &[LineId]) -> MissCurve {
    let mut distances = StackDistances::new();
    trace.iter().for_each(|&line| distances.touch(line));
    distances.curve()
}

fn aet(trace: &[LineId]) -> MissCurve {
    let mut aet = Aet::new();
    aet.extend(trace.iter().copied());
    aet.curve()
}

fn simulated(lines: u64, ways: Ways, trace: &[LineId]) -> u64 {
    let line = LineSize::new(64).expect("64 is a power of two");
    let level = LevelConfig::new("cache", Bytes(64 * lines), line, ways, Policy::Lru);
    let levels = Levels::new(vec![level]).expect("a plain level");
    let (mut hierarchy, path) = Hierarchy::chain(&levels).expect("a plain level");
    hierarchy.read(path, 0, trace);
    hierarchy.counts(0).misses
}

/// The largest difference in miss ratio among 16 sizes per doubling from `from` lines.
fn largest_error(aet: &MissCurve, exact: &MissCurve, from: u64) -> f64 {
    let sizes =
        (0..16 * 20).map(|step| (f64::from(step) / 16.0).exp2() as u64).filter(|&lines| lines >= from);
    let differences = sizes.map(|lines| aet.misses(lines).abs_diff(exact.misses(lines)));
    differences.max().expect("some sizes") as f64 / exact.accesses() as f64
}

#[test]
fn exact_curves_are_those_of_replays_of_fully_associative_caches() {
    for stream in STREAMS {
        let trace = lines(stream, 1_200_000);
        let curve = exact(&trace);
        for size in [1, 13, 64, 256, 1_024, 5_000, 65_536, 262_144] {
            assert_eq!(curve.misses(size), simulated(size, Ways::Full, &trace), "{stream:?}, {size} lines");
        }
    }
}

/// The largest error on random lines is at the last sizes, which hold nearly all lines: there the first
/// touches, which AET takes for lines that never return, weigh most.
#[test]
fn aet_is_as_near_as_published_on_bvh() {
    let bvh = lines(Stream::Bvh, 24_000_000);
    let (quick, exact_bvh) = (aet(&bvh), exact(&bvh));
    for (from, bound) in [(1, 0.0285), (64, 0.0206), (1024, 0.00095), (16_384, 0.0002)] {
        let error = largest_error(&quick, &exact_bvh, from);
        assert!(error <= bound && error > bound / 2.0, "{error} from {from} lines");
    }
    for (stream, bound) in [(Stream::Rnd, 0.042), (Stream::Seq, 1e-6)] {
        let trace = lines(stream, 4_000_000);
        let error = largest_error(&aet(&trace), &exact(&trace), 1);
        assert!(error <= bound, "{stream:?}: {error}");
    }
}

#[test]
fn aet_is_exact_where_all_lines_leave_after_the_same_time() {
    let rounds: Vec<LineId> = (0..50_000).map(|access| LineId::new(access % 1_000)).collect();
    let curve = aet(&rounds);
    assert_eq!([0, 1, 999, 1_000].map(|lines| curve.misses(lines)), [50_000, 50_000, 50_000, 1_000]);
}

#[test]
fn a_set_associative_estimate_is_nearer_to_a_simulation_than_a_fully_associative_cache() {
    let trace = lines(Stream::Bvh, 24_000_000);
    let (exact, aet) = (exact(&trace), aet(&trace));
    let share = |misses: f64| misses / trace.len() as f64;
    let (mut full_sum, mut exact_sum) = (0.0, 0.0);
    for kib in [4, 16, 64, 256, 1024] {
        for ways in [1, 2, 4, 8] {
            let lines = kib * 16;
            let simulated = simulated(lines, Ways::Count(ways), &trace) as f64;
            let error = |misses: f64| share(misses - simulated).abs();
            let (sets, ways) = (lines / u64::from(ways), u64::from(ways));
            let full = error(exact.misses(lines) as f64);
            let corrected = error(exact.set_associative(sets, ways));
            let quick = error(aet.set_associative(sets, ways));
            assert!(corrected < 0.006 && quick < 0.008, "{kib} KiB, {ways} ways: {corrected}, {quick}");
            assert!(ways > 4 || corrected < full / 2.0, "{kib} KiB, {ways} ways: {corrected}, {full}");
            full_sum += full;
            exact_sum += corrected;
        }
    }
    assert!(exact_sum < full_sum / 10.0, "{exact_sum} of {full_sum}");
}

/// The first million accesses stay in a corner of the world, where the same few lines meet in the same sets.
#[test]
fn a_set_associative_estimate_misses_conflicts_that_stay() {
    let trace = lines(Stream::Bvh, 1_000_000);
    let curve = exact(&trace);
    let simulated = simulated(256, Ways::Count(4), &trace) as f64;
    let conflicts = simulated - curve.misses(256) as f64;
    let explained = (curve.set_associative(64, 4) - curve.misses(256) as f64) / conflicts;
    assert!((0.40..0.45).contains(&explained), "{explained}");
}

/// A curve knows no addresses: it cannot tell that all lines fall into one set, nor that they fill all sets alike.
#[test]
fn a_set_associative_estimate_takes_strides_for_random() {
    let (sets, ways) = (64, 4);
    let every = |stride: u64, lines: u64| -> Vec<LineId> {
        (0..100 * lines).map(|access| LineId::new(access % lines * stride)).collect()
    };
    let one_set = every(64, 16);
    assert_eq!(simulated(sets * 4, Ways::Count(4), &one_set), 1_600);
    assert!(exact(&one_set).set_associative(sets, ways) < 20.0);
    let all_sets = every(1, 256);
    assert_eq!(simulated(sets * 4, Ways::Count(4), &all_sets), 256);
    assert!(exact(&all_sets).set_associative(sets, ways) > 12_000.0);
}

/// Of `d` other lines, `ways` or more in one of `sets` sets, by the sum over the binomial distribution.
fn evicted(d: u64, sets: u64, ways: u64) -> f64 {
    let share = 1.0 / sets as f64;
    let mut in_set = vec![0.0; d as usize + 1];
    in_set[0] = 1.0;
    for _ in 0..d {
        for k in (0..in_set.len()).rev() {
            let before = if k == 0 { 0.0 } else { in_set[k - 1] };
            in_set[k] = in_set[k] * (1.0 - share) + before * share;
        }
    }
    in_set.iter().skip(ways as usize).sum()
}

#[test]
fn distances_are_spread_over_sets_by_the_binomial_distribution() {
    for (distance, sets, ways) in [(1, 2, 1), (40, 7, 4), (300, 64, 4), (2_000, 3, 700), (3_000, 1_000, 2)] {
        let round: Vec<LineId> = (0..=distance).map(LineId::new).collect();
        let curve = exact(&[&round[..], &round[..]].concat());
        let expected = (distance + 1) as f64 * (1.0 + evicted(distance, sets, ways));
        let found = curve.set_associative(sets, ways);
        assert!((found / expected - 1.0).abs() < 1e-11, "{found}, expected {expected}");
    }
}

#[test]
fn many_ways_whose_probabilities_an_f64_does_not_hold_are_summed_all_the_same() {
    let round: Vec<LineId> = (0..1_100_000).map(LineId::new).collect();
    let curve = exact(&[&round[..], &round[..]].concat());
    // 1.1e6 (2 - P), where P is the chance of at most 1023 of 1,099,999 lines in one of a thousand sets,
    // summed by the logarithm of the gamma function.
    let misses = curve.set_associative(1_000, 1_024);
    assert!((misses - 2_189_110.545_7).abs() < 1e-3, "{misses}");
}

proptest! {
    #[test]
    fn curves_fall_from_all_accesses_to_the_distinct_lines(
        trace in prop::collection::vec(0..200_u64, 0..600),
        spread in prop::sample::select(vec![1, 1 << 30, u64::MAX / 200 - 1]),
        (sets, ways) in (1..40_u64, 1..40_u64),
    ) {
        let trace: Vec<LineId> = trace.iter().map(|line| LineId::new(line * spread)).collect();
        let distinct = trace.iter().collect::<std::collections::HashSet<_>>().len() as u64;
        for curve in [exact(&trace), aet(&trace)] {
            prop_assert_eq!(curve.accesses(), trace.len() as u64);
            prop_assert_eq!(curve.misses(0), curve.accesses());
            prop_assert_eq!(curve.cold_misses(), distinct);
            prop_assert_eq!(curve.misses(distinct), distinct);
            prop_assert_eq!(curve.misses(u64::MAX), distinct);
            let sizes: Vec<u64> = (0..=distinct).map(|lines| curve.misses(lines)).collect();
            prop_assert!(sizes.is_sorted_by(|fewer_lines, more_lines| fewer_lines >= more_lines));
            prop_assert_eq!(curve.set_associative(1, ways), curve.misses(ways) as f64);
            let estimate = curve.set_associative(sets, ways);
            prop_assert!(estimate >= curve.set_associative(sets, ways + 1) - 1e-9);
            prop_assert!(estimate >= distinct as f64 - 1e-9 && estimate <= curve.misses(ways) as f64 + 1e-9);
        }
        prop_assert_eq!(aet(&trace).misses(1), exact(&trace).misses(1));
    }

    #[test]
    fn exact_curves_are_those_of_replays_of_any_stream(
        trace in prop::collection::vec((0..24_u64).prop_map(|bits| 1 << bits), 1..500),
        lines in 1..30_u64,
    ) {
        let trace: Vec<LineId> = trace.into_iter().map(LineId::new).collect();
        prop_assert_eq!(exact(&trace).misses(lines), simulated(lines, Ways::Full, &trace));
    }
}
