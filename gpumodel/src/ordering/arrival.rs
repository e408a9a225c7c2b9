//! In which order units of work get to their end.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::num::NonZero;

/// Units in the order in which they arrive: they start in the order of their numbers, as many at once as there are `slots`, each as soon as one
/// before it has arrived, and arrive when their duration has passed. Of those that arrive at the same time, the lower number is first.
///
/// `durations` are in any unit of time. One slot keeps the order, and so do equal durations.
pub fn arrival_order(durations: &[u64], slots: NonZero<usize>) -> Vec<usize> {
    let mut order = Vec::with_capacity(durations.len());
    let mut running = BinaryHeap::new();
    let mut now = 0_u64;
    for (unit, &duration) in durations.iter().enumerate() {
        if running.len() == slots.get()
            && let Some(Reverse((end, arrived))) = running.pop()
        {
            now = end;
            order.push(arrived);
        }
        running.push(Reverse((now.saturating_add(duration), unit)));
    }
    while let Some(Reverse((_, arrived))) = running.pop() {
        order.push(arrived);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn slots(count: usize) -> NonZero<usize> {
        NonZero::new(count).expect("not zero")
    }

    /// The same, clock tick by clock tick.
    fn tick_by_tick(durations: &[u64], slots: usize) -> Vec<usize> {
        let mut ends = vec![None; durations.len()];
        let mut order = Vec::new();
        for now in 0.. {
            // A unit that takes no time leaves its slot to the next one at once.
            loop {
                let arrived = (0..ends.len()).find(|&unit| ends[unit] == Some(now) && !order.contains(&unit));
                let running = ends.iter().flatten().count() - order.len();
                let next = ends.iter().position(Option::is_none);
                match (next, arrived) {
                    (Some(next), _) if running < slots => ends[next] = Some(now + durations[next]),
                    (_, Some(unit)) => order.push(unit),
                    _ => break,
                }
            }
            if order.len() == durations.len() {
                return order;
            }
        }
        unreachable!("time does not end")
    }

    #[test]
    fn short_units_overtake_long_ones() {
        assert_eq!(arrival_order(&[9, 2, 3, 1], slots(2)), [1, 2, 3, 0]);
        assert_eq!(arrival_order(&[9, 2, 3, 1], slots(1)), [0, 1, 2, 3]);
        assert_eq!(arrival_order(&[], slots(3)), [0_usize; 0]);
    }

    proptest! {
        #[test]
        fn it_is_what_a_clock_would_show(durations in prop::collection::vec(0_u64..6, 0..24), places in 1_usize..6) {
            prop_assert_eq!(arrival_order(&durations, slots(places)), tick_by_tick(&durations, places));
        }

        #[test]
        fn equal_durations_and_single_slots_keep_the_order(
            durations in prop::collection::vec(0..u64::MAX, 0..40), duration in 0_u64..9, places in 1_usize..9,
        ) {
            let kept: Vec<usize> = (0..durations.len()).collect();
            let equal = vec![duration; durations.len()];
            prop_assert_eq!(arrival_order(&equal, slots(places)), &kept[..]);
            prop_assert_eq!(arrival_order(&durations, slots(1)), kept);
        }

        #[test]
        fn no_unit_is_overtaken_by_more_than_arrive_while_it_runs(
            durations in prop::collection::vec(1_u64..100, 1..60), places in 1_usize..9,
        ) {
            // All that started before a unit have arrived when it does, but for those that occupy the other slots.
            let order = arrival_order(&durations, slots(places));
            for (place, &unit) in order.iter().enumerate() {
                let overtaken = (0..unit).filter(|before| !order[..place].contains(before)).count();
                prop_assert!(overtaken < places);
            }
        }
    }
}
