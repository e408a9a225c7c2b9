//! When the warps of cores can issue their next turns, searched for the first.

/// Searches that go side by side, so that no comparison waits for the one before.
const SEARCHES: usize = 4;

/// By place, `core * slots + slot`, the time at which its warp can issue; infinite without one.
///
/// Times are kept as the bits of numbers that are not negative, whose order is that of the numbers. The lowest bits, far below what times mean,
/// hold the slot: the least of the keys is the first slot of those that are ready first.
pub(super) struct ReadyTimes {
    keys: Vec<u64>,
    times: Vec<f64>,
    slots: usize,
    /// Bits of a key that hold the slot.
    slot_bits: u64,
}

impl ReadyTimes {
    /// No warps in `slots` slots of each core.
    pub(super) fn new(cores: usize, slots: usize) -> Self {
        let slot_bits = slots.next_power_of_two() as u64 - 1;
        let never = f64::INFINITY.to_bits();
        let keys = (0..cores).flat_map(|_| (0..slots as u64).map(|slot| never | slot)).collect();
        Self { keys, times: vec![f64::INFINITY; cores * slots], slots, slot_bits }
    }

    /// Cycles; not negative.
    #[inline]
    pub(super) fn set(&mut self, place: usize, cycles: f64) {
        debug_assert!(cycles >= 0.0);
        self.times[place] = cycles;
        let key = &mut self.keys[place];
        *key = cycles.to_bits() & !self.slot_bits | *key & self.slot_bits;
    }

    #[inline]
    pub(super) fn at(&self, place: usize) -> f64 {
        self.times[place]
    }

    /// The place of a core that is ready first, the first of them if there are several: if none lies within a part in 10^12 of it.
    #[inline]
    pub(super) fn first(&self, core: usize) -> usize {
        let start = core * self.slots;
        let (rows, rest) = self.keys[start..start + self.slots].as_chunks::<SEARCHES>();
        let mut leasts = [u64::MAX; SEARCHES];
        for row in rows {
            for (least, &key) in leasts.iter_mut().zip(row) {
                *least = key.min(*least);
            }
        }
        let least = leasts.iter().chain(rest).fold(u64::MAX, |least, &key| key.min(least));
        start + (least & self.slot_bits) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_first_of_the_least_is_found_in_every_core(
            (slots, times) in (1_usize..140).prop_flat_map(|slots| {
                let time = prop_oneof![4 => 0.0_f64..1e12, 1 => Just(7.0), 1 => Just(f64::INFINITY)];
                (Just(slots), prop::collection::vec(time, 3 * slots))
            })
        ) {
            let mut ready = ReadyTimes::new(3, slots);
            (0..).zip(&times).for_each(|(place, &time)| ready.set(place, time));
            for (core, of_core) in times.chunks(slots).enumerate() {
                let least = of_core.iter().copied().fold(f64::INFINITY, f64::min);
                let expected = core * slots + of_core.iter().position(|&time| time == least).expect("it is there");
                let found = ready.first(core);
                let near = (ready.at(found) - least).abs() <= least * 1e-12;
                prop_assert!(found == expected || (ready.at(found) != least && near), "{} for {}", found, expected);
            }
        }
    }
}
