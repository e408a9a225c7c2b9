//! Distinct keys in order of first appearance: what one load of a warp asks of the memory system.

/// Slots of the table: twice the lanes of the widest warp.
const SLOTS: usize = 128;

/// Tells keys that it has seen since the last [`Self::begin`] from new ones.
pub(crate) struct Distinct {
    /// Open addressing: epoch in the upper half, key in the lower; an older epoch is an empty slot.
    table: [u64; SLOTS],
    epoch: u64,
}

impl Distinct {
    pub(crate) fn new() -> Self {
        Self { table: [0; SLOTS], epoch: 0 }
    }

    /// Writes the distinct ones of at most 64 `keys` to `out`, in order of first appearance; returns how many.
    #[inline(always)]
    pub(crate) fn filter(&mut self, keys: impl Iterator<Item = u32>, out: &mut [u32; 64]) -> usize {
        // 2^32 epochs in the upper half: a wrap would need as many loads within one tile's replay.
        self.epoch += 1 << 32;
        let mut found = 0;
        let mut last = None;
        for key in keys {
            if last == Some(key) {
                continue;
            }
            last = Some(key);
            let tagged = self.epoch | u64::from(key);
            let mut slot = (key.wrapping_mul(0x9E37_79B1) >> 25) as usize;
            loop {
                let entry = self.table[slot % SLOTS];
                if entry == tagged {
                    break;
                }
                if entry >> 32 != self.epoch >> 32 {
                    self.table[slot % SLOTS] = tagged;
                    out[found] = key;
                    found += 1;
                    break;
                }
                slot += 1;
            }
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
