use super::*;
use crate::ordering::arrival_order;
use proptest::prelude::*;
use std::num::NonZero;

fn compaction(binning: &str, lanes: usize, warp_width: usize) -> Compaction {
    Compaction {
        binning: Binning::from_name(binning).expect(binning),
        workgroup: Workgroup::new(lanes, warp_width, Counters::Words).expect("a size"),
        strategy: AtomicStrategy::Subgroup,
        consumer: 4,
    }
}

fn order(compaction: &Compaction, lanes: &[Option<u32>], arrivals: &[usize]) -> Vec<usize> {
    compaction.run(lanes, arrivals).expect("it is sound").order
}

#[test]
fn warps_are_appended_as_they_arrive() {
    let lanes = [Some(0), None, Some(0), Some(0), None, None, Some(0)];
    let unbinned = compaction("none", 4, 2);
    assert_eq!(unbinned.units(lanes.len()), 4);
    let compacted = unbinned.run(&lanes, &[3, 1, 2, 0]).expect("it is sound");
    assert_eq!(compacted.order, [6, 2, 3, 0]);
    assert_eq!(compacted.dispatch, 1);
    assert_eq!(compacted.shared, AtomicTally::default());
    // An idle warp adds nothing.
    assert_eq!(compacted.global, AtomicTally { instructions: 3, counters: 3, atomics: 3, joined: 3 });
}

#[test]
fn a_workgroup_lies_by_bins_and_workgroups_as_they_arrive() {
    let lanes = [Some(7), Some(1), Some(7), Some(0), Some(1), None, Some(3), Some(1)];
    let binned = compaction("sign", 4, 2);
    let compacted = binned.run(&lanes, &[1, 0]).expect("it is sound");
    assert_eq!(compacted.order, [4, 7, 6, 3, 1, 0, 2]);
    assert_eq!(compacted.dispatch, 2);
    assert_eq!(compacted.global, AtomicTally { instructions: 2, counters: 2, atomics: 2, joined: 2 });
    // Warps 7 1 | 7 0 | 1 - | 3 1.
    assert_eq!(compacted.shared, AtomicTally { instructions: 7, counters: 7, atomics: 7, joined: 7 });
}

#[test]
fn brute_force_appends_with_an_atomic_per_lane_unless_the_compiler_joins_them() {
    let brute = Compaction { strategy: AtomicStrategy::BruteForce, ..compaction("none", 8, 4) };
    let compacted = brute.run(&[Some(0); 8], &[0, 1]).expect("it is sound");
    assert_eq!(compacted.global, AtomicTally { instructions: 2, counters: 2, atomics: 8, joined: 2 });
}

#[test]
fn groups_that_are_empty_full_of_one_bin_or_full_of_all_bins_leave_no_holes() {
    let mut lanes = vec![None; 8];
    lanes.extend([Some(5); 8]);
    lanes.extend((0..8).rev().map(Some));
    let expected: Vec<usize> = (16..24).rev().chain(8..16).collect();
    assert_eq!(order(&compaction("sign", 8, 4), &lanes, &[2, 0, 1]), expected);
    let nothing = compaction("sign", 8, 4).run(&[None; 24], &[0, 1, 2]).expect("it is sound");
    assert_eq!((nothing.order.len(), nothing.dispatch, nothing.global.atomics), (0, 0, 3));
    assert_eq!(compaction("sign", 8, 4).run(&[], &[]).expect("it is sound"), Compacted::default());
}

#[test]
fn what_does_not_fit_is_refused() {
    for (lanes, counters, expected) in [
        (0, Counters::Words, "1 to 1024"),
        (1025, Counters::Words, "1 to 1024"),
        (256, Counters::Packed, "1 to 255"),
    ] {
        let message = Workgroup::new(lanes, 32, counters).expect_err("no size").to_string();
        assert!(message.contains(expected), "{message}");
    }
    assert!(
        Workgroup::new(1024, 32, Counters::Words).is_ok()
            && Workgroup::new(255, 32, Counters::Packed).is_ok()
    );
    assert!(Workgroup::new(64, 0, Counters::Words).is_err());
    let message = |lanes: &[Option<u32>], arrivals: &[usize], compaction: Compaction| {
        compaction.run(lanes, arrivals).expect_err("it is refused").to_string()
    };
    let sign = compaction("sign", 4, 2);
    assert!(message(&[Some(8)], &[0], sign).contains("bin 8"));
    for arrivals in [&[0, 0][..], &[0], &[0, 2], &[0, 1, 1]] {
        assert!(message(&[Some(0); 8], arrivals, sign).contains("do not name each of 2 workgroups once"));
    }
    let crowded = Compaction { binning: Binning::Position { bits: 4 }, ..sign };
    assert!(message(&[Some(0)], &[0], crowded).contains("4096 bins"));
    assert!(message(&[Some(0)], &[0], Compaction { consumer: 0, ..sign }).contains("0 lanes"));
}

#[test]
fn packed_counters_take_a_quarter_of_the_words() {
    assert_eq!([8, 9, 1].map(|bins| Counters::Packed.words(bins)), [2, 3, 1]);
    assert_eq!(Counters::Words.words(9), 9);
}

/// Rays by lane, durations by unit.
fn pass() -> impl Strategy<Value = (Vec<Option<u32>>, Vec<u64>)> {
    let bins = prop_oneof![
        Just(8_u32).prop_flat_map(|bins| prop::collection::vec(prop::option::of(0..bins), 0..200)),
        (0_u32..8, 0_usize..200).prop_map(|(bin, count)| vec![Some(bin); count]),
    ];
    (bins, prop::collection::vec(0_u64..50, 200))
}

proptest! {
    #[test]
    fn every_ray_is_there_once(
        (lanes, durations) in pass(), lanes_of_group in 1_usize..40, warp_width in 1_usize..9, slots in 1_usize..5,
        strategy in prop::sample::select(AtomicStrategy::ALL.to_vec()), consumer in 1_u32..70,
    ) {
        let rays: Vec<usize> = (0..lanes.len()).filter(|&ray| lanes[ray].is_some()).collect();
        for binning in ["none", "sign"] {
            let lanes: Vec<Option<u32>> = match binning {
                "none" => lanes.iter().map(|bin| bin.map(|_| 0)).collect(),
                _ => lanes.clone(),
            };
            let compaction = Compaction { strategy, consumer, ..compaction(binning, lanes_of_group, warp_width) };
            let units = compaction.units(lanes.len());
            let slots = NonZero::new(slots).expect("not zero");
            let arrivals = arrival_order(&durations[..units], slots);
            let compacted = compaction.run(&lanes, &arrivals).expect("it is sound");
            let mut found = compacted.order.clone();
            found.sort_unstable();
            prop_assert_eq!(&found, &rays);
            prop_assert_eq!(compacted.dispatch as usize, rays.len().div_ceil(consumer as usize));

            // Units one after the other, within one bins ascending, within a bin lanes.
            let unit_lanes = if binning == "none" { warp_width } else { lanes_of_group };
            let mut expected = Vec::new();
            for unit in arrivals {
                let mut rays: Vec<usize> =
                    rays.iter().copied().filter(|ray| ray / unit_lanes == unit).collect();
                rays.sort_by_key(|&ray| (lanes[ray], ray));
                expected.append(&mut rays);
            }
            prop_assert_eq!(compacted.order, expected);
        }
    }

    #[test]
    fn a_single_bin_is_the_order_of_workgroups((lanes, durations) in pass(), groups in 1_usize..40) {
        let lanes: Vec<Option<u32>> = lanes.iter().map(|bin| bin.map(|_| 0)).collect();
        // A warp as wide as the workgroup arrives as the workgroup does.
        let (unbinned, binned) = (compaction("none", groups, groups), compaction("octahedral-1x1", groups, 4));
        let arrivals = arrival_order(&durations[..binned.units(lanes.len())], NonZero::new(3).expect("not zero"));
        prop_assert_eq!(order(&unbinned, &lanes, &arrivals), order(&binned, &lanes, &arrivals));
    }
}
