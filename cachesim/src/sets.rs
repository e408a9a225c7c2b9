//! Set = line modulo number of sets, for any number of sets.

use crate::word::Word;

/// Maps lines to sets below a fixed number.
pub(crate) trait Index: Copy + Send + Sync + 'static {
    /// The line's set, below [`Self::sets`].
    fn of<W: Word>(self, line: W) -> usize;
    fn sets(self) -> usize;
}

/// A power of two sets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask(u64);

impl Index for Mask {
    #[inline(always)]
    fn of<W: Word>(self, line: W) -> usize {
        (line.id() & self.0) as usize
    }

    #[inline(always)]
    fn sets(self) -> usize {
        self.0 as usize + 1
    }
}

/// Any number of sets below 2^32. Numbers of 32 bits are reduced by two multiplications (Lemire et al. 2019).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Modulo {
    sets: u64,
    inverse: u64,
}

impl Index for Modulo {
    #[inline(always)]
    fn of<W: Word>(self, line: W) -> usize {
        if W::MAX_ID > u64::from(u32::MAX) {
            return (line.id() % self.sets) as usize;
        }
        let fraction = self.inverse.wrapping_mul(line.id());
        ((u128::from(fraction) * u128::from(self.sets)) >> 64) as usize
    }

    #[inline(always)]
    fn sets(self) -> usize {
        self.sets as usize
    }
}

/// Either, chosen by the number of sets.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SetIndex {
    Mask(Mask),
    Modulo(Modulo),
}

impl SetIndex {
    /// `sets` is at least 1 and below 2^32.
    pub(crate) fn new(sets: u64) -> Self {
        if sets.is_power_of_two() {
            Self::Mask(Mask(sets - 1))
        } else {
            Self::Modulo(Modulo { sets, inverse: u64::MAX / sets + 1 })
        }
    }
}

impl Index for SetIndex {
    #[inline(always)]
    fn of<W: Word>(self, line: W) -> usize {
        match self {
            Self::Mask(mask) => mask.of(line),
            Self::Modulo(modulo) => modulo.of(line),
        }
    }

    fn sets(self) -> usize {
        match self {
            Self::Mask(mask) => mask.sets(),
            Self::Modulo(modulo) => modulo.sets(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_multiplications_are_the_remainder() {
        let ends = |max: u64| (0..70).chain(max - 70..=max).chain((0..64).map(move |bit| (1 << bit) & max));
        for sets in (1..200).chain([1023, 1024, 1025, (1 << 26) - 1, 1 << 26]) {
            let index = SetIndex::new(sets);
            for line in ends(u32::MAX_ID) {
                assert_eq!(index.of(u32::from_id(line)) as u64, line % sets, "{line} mod {sets}");
            }
            for line in ends(u64::MAX_ID) {
                assert_eq!(index.of(u64::from_id(line)) as u64, line % sets, "{line} mod {sets}");
            }
        }
    }
}
