//! Distinct keys in order of first appearance: what one load of a warp asks of the memory system.

/// Slots of the table: so many more than lanes of the widest warp that two keys rarely want the same one.
const SLOTS: usize = 1024;

/// So many keys are compared with each other sooner than looked up.
const FEW: usize = 5;

/// Tells keys that a load has named before from new ones.
pub(crate) struct Distinct {
    /// Open addressing: epoch in the upper half, key in the lower; an older epoch is an empty slot.
    table: Box<[u64; SLOTS]>,
    epoch: u64,
}

impl Distinct {
    pub(crate) fn new() -> Self {
        Self { table: Box::new([0; SLOTS]), epoch: 0 }
    }

    /// Writes the distinct ones of at most 64 `keys` to `out`, in order of first appearance; returns how many.
    #[inline(always)]
    pub(crate) fn filter(&mut self, keys: impl Iterator<Item = u32> + Clone, out: &mut [u32; 64]) -> usize {
        let mut found = 0;
        if keys.size_hint().1.is_some_and(|most| most <= FEW) {
            for (index, key) in keys.clone().enumerate() {
                let known = keys.clone().take(index).fold(false, |known, other| known | (other == key));
                out[found % 64] = key;
                found += usize::from(!known);
            }
            return found;
        }
        self.epoch += 1 << 32;
        if self.epoch == 0 {
            self.table.fill(0);
            self.epoch = 1 << 32;
        }
        // Whether a key is new is hard to predict: it moves `found` without a branch.
        for key in keys {
            let tagged = self.epoch | u64::from(key);
            let mut slot = (key.wrapping_mul(0x9E37_79B1) >> 22) as usize;
            let mut difference = self.table[slot % SLOTS] ^ tagged;
            while difference != 0 && difference >> 32 == 0 {
                slot += 1;
                difference = self.table[slot % SLOTS] ^ tagged;
            }
            self.table[slot % SLOTS] = tagged;
            out[found % 64] = key;
            found += usize::from(difference != 0);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn keys_come_out_once_in_order_of_first_appearance(
            loads in prop::collection::vec(prop::collection::vec(0_u32..90, 0..=64), 1..8)
        ) {
            let mut distinct = Distinct::new();
            for keys in loads {
                let mut out = [0; 64];
                let found = distinct.filter(keys.iter().copied(), &mut out);
                let mut expected: Vec<u32> = Vec::new();
                for key in keys {
                    if !expected.contains(&key) {
                        expected.push(key);
                    }
                }
                prop_assert_eq!(&out[..found], &expected[..]);
            }
        }
    }
}
