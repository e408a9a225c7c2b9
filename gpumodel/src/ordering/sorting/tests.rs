use super::*;
use crate::ordering::arrival_order;
use proptest::prelude::*;
use std::num::NonZero;

fn sort(buckets: u32, warp_width: usize) -> BucketSort {
    BucketSort { buckets, warp_width, consumer: 3, strategy: AtomicStrategy::Subgroup }
}

#[test]
fn misses_come_into_the_first_bucket() {
    assert_eq!([None, Some(0), Some(6), Some(u32::MAX)].map(bucket_of), [0, 1, 7, u32::MAX]);
}

#[test]
fn buckets_lie_as_they_took_their_stretches_and_elements_as_their_warps_copied() {
    let sorted = sort(3, 2).run(&[2, 0, 2, 2, 0], &[2, 1, 0], &[1, 2, 0]).expect("it is sound");
    assert_eq!(sorted.order, [2, 3, 0, 4, 1]);
    let bucket =
        |start, size, warps| Bucket { start, size, end: start + size, warps, dispatch: size.div_ceil(3) };
    assert_eq!(sorted.buckets, [bucket(3, 2, 2), bucket(3, 0, 0), bucket(0, 3, 2)]);
    assert_eq!(sorted.atomics, AtomicTally { instructions: 4, counters: 4, atomics: 4, joined: 4 });
}

#[test]
fn nothing_is_sorted_into_empty_buckets() {
    let sorted = sort(2, 4).run(&[], &[1, 0], &[]).expect("it is sound");
    assert_eq!(sorted, Sorted { buckets: vec![Bucket::default(); 2], ..Sorted::default() });
}

#[test]
fn what_cannot_be_sorted_is_refused() {
    let message = |sort: BucketSort, elements: &[u32], offsets: &[usize], copies: &[usize]| {
        sort.run(elements, offsets, copies).expect_err("it is refused").to_string()
    };
    assert!(message(sort(2, 4), &[2], &[0, 1], &[0]).contains("bucket 2, expected one below 2"));
    assert!(message(sort(2, 4), &[1], &[0, 0], &[0]).contains("each of 2 buckets once"));
    assert!(message(sort(2, 4), &[1], &[0, 1], &[]).contains("each of 1 warps once"));
    assert!(message(sort(2, 0), &[1], &[0, 1], &[0]).contains("warps have 0 lanes"));
    assert!(message(BucketSort { consumer: 0, ..sort(2, 4) }, &[1], &[0, 1], &[0]).contains("workgroups 0"));
}

proptest! {
    #[test]
    fn every_bucket_has_its_stretch_and_every_element_its_place(
        elements in prop::collection::vec(0_u32..9, 0..300), durations in prop::collection::vec(0_u64..50, 300),
        warp_width in 1_usize..20, slots in 1_usize..6, consumer in 1_u32..70,
        strategy in prop::sample::select(AtomicStrategy::ALL.to_vec()),
    ) {
        let sort = BucketSort { consumer, strategy, ..sort(9, warp_width) };
        let slots = NonZero::new(slots).expect("not zero");
        let offsets = arrival_order(&durations[..9], slots);
        let copies = arrival_order(&durations[..sort.warps(elements.len())], slots);
        let Sorted { order, buckets, atomics } = sort.run(&elements, &offsets, &copies).expect("it is sound");

        let mut found = order.clone();
        found.sort_unstable();
        prop_assert!(found.into_iter().eq(0..elements.len()), "a permutation");

        let mut end = 0;
        for &number in &offsets {
            let Bucket { start, size, end: last, warps, dispatch } = buckets[number];
            prop_assert_eq!((start, last), (end, start + size), "stretches lie end to end");
            end = last;
            let stretch = &order[start as usize..last as usize];
            prop_assert!(stretch.iter().all(|&element| elements[element] as usize == number));
            prop_assert_eq!(dispatch, size.div_ceil(consumer));
            let of_bucket = |warp: &&[u32]| warp.contains(&(number as u32));
            prop_assert_eq!(warps as usize, elements.chunks(warp_width).filter(of_bucket).count());
            // Warps as they copied, lanes in order.
            let turn = |element: usize| copies.iter().position(|&warp| warp == element / warp_width);
            prop_assert!(stretch.is_sorted_by_key(|&element| (turn(element), element)));
        }
        prop_assert_eq!(end as usize, elements.len(), "sizes add up");
        let all_warps: u32 = buckets.iter().map(|bucket| bucket.warps).sum();
        prop_assert_eq!(atomics.counters, u64::from(all_warps));
    }

    #[test]
    fn all_strategies_sort_alike(elements in prop::collection::vec(0_u32..5, 0..200), warp_width in 1_usize..20) {
        let sorted = AtomicStrategy::ALL.map(|strategy| {
            let sort = BucketSort { strategy, ..sort(5, warp_width) };
            let copies: Vec<usize> = (0..sort.warps(elements.len())).rev().collect();
            sort.run(&elements, &[4, 0, 3, 1, 2], &copies).expect("it is sound")
        });
        for other in &sorted[1..] {
            prop_assert_eq!(&sorted[0].order, &other.order);
            prop_assert_eq!(&sorted[0].buckets, &other.buckets);
        }
    }
}
