//! Set = line modulo number of sets, for any number of sets.

/// Maps a line to its set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetIndex {
    sets: u64,
}

impl SetIndex {
    pub(crate) fn new(sets: u64) -> Self {
        Self { sets: sets.max(1) }
    }

    #[inline(always)]
    pub(crate) fn set_of(self, line: u64) -> usize {
        if self.sets.is_power_of_two() {
            (line & (self.sets - 1)) as usize
        } else {
            (line % self.sets) as usize
        }
    }
}
