//! Numbers lines in order of first touch, so that what is kept per line lies in plain arrays.

use crate::address::LineId;
use crate::line_map::LineMap;

/// Lines that share one entry of the hash table.
const PAGE: usize = 16;

/// A map from lines to 0, 1, 2, ... It grows with the number of distinct lines, by 5 bytes each if they
/// are neighbours and at most 130 if they are strewn about.
#[derive(Clone, Debug)]
pub(crate) struct DenseIds {
    /// Counted from 1.
    numbers: LineMap<PAGE>,
    len: u32,
}

impl DenseIds {
    pub(crate) fn new() -> Self {
        Self { numbers: LineMap::default(), len: 0 }
    }

    /// The line's number; a new line gets the next one.
    ///
    /// # Panics
    /// After 2^32 - 1 distinct lines.
    #[inline(always)]
    pub(crate) fn number(&mut self, line: LineId) -> u32 {
        let number = self.numbers.of(line);
        if *number == LineMap::<PAGE>::UNSET {
            self.len = self.len.checked_add(1).expect("at most 2^32 - 1 distinct lines");
            *number = self.len;
        }
        *number - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_in_order_of_first_touch_and_keep_their_numbers() {
        let mut ids = DenseIds::new();
        let lines: Vec<LineId> =
            (0..5_000_u64).map(|i| LineId::new(i.wrapping_mul(0x9E37_79B9_7F4A_7C15))).collect();
        for round in 0..2 {
            for (expected, &line) in lines.iter().enumerate() {
                assert_eq!(ids.number(line), expected as u32, "round {round}");
            }
        }
        assert_eq!(ids.number(LineId::MAX), lines.len() as u32);
    }
}
