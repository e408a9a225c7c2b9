//! Misses by cache size.

/// The misses of an LRU cache of every size that was empty at the start, of one stream of accesses. It
/// never rises with the size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissCurve {
    /// By size in lines, from 0: misses of a fully associative cache. The last are the cold ones.
    misses: Vec<u64>,
}

impl MissCurve {
    pub(crate) fn new(misses: Vec<u64>) -> Self {
        debug_assert!(misses.is_sorted_by(|fewer_lines, more_lines| fewer_lines >= more_lines));
        Self { misses }
    }

    /// All accesses.
    #[must_use]
    pub fn accesses(&self) -> u64 {
        self.misses[0]
    }

    /// The misses of a cache without limit: first touches, as many as distinct lines.
    #[must_use]
    pub fn cold_misses(&self) -> u64 {
        self.misses[self.misses.len() - 1]
    }

    /// The misses of a fully associative cache that holds `lines` lines.
    #[must_use]
    pub fn misses(&self, lines: u64) -> u64 {
        let last = self.misses.len() - 1;
        self.misses[usize::try_from(lines).unwrap_or(last).min(last)]
    }

    /// Every size in lines, from 1, at which there are fewer misses than with one line less, and the
    /// misses there.
    pub fn points(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        let steps = (1..).zip(self.misses.windows(2));
        steps.filter(|(_, step)| step[1] < step[0]).map(|(lines, step)| (lines, step[1]))
    }

    /// An estimate of the misses of a cache of `sets` sets of `ways` lines each, if lines fall into sets
    /// at random (Smith 1978; Hill and Smith 1989): of the `d` distinct other lines touched since the last
    /// touch of a line, the number in its set is binomial (`d`, 1 / `sets`), and `ways` of them evict it.
    /// With one set it is [`Self::misses`] of `ways`.
    ///
    /// Lines that lie in order fill the sets more evenly than at random and conflict less; strides that
    /// share a factor with `sets` fill few of them and conflict more than any curve can tell. A stream that
    /// stays among few lines keeps the conflicts that these happen to have.
    ///
    /// # Panics
    /// If `sets` or `ways` is 0.
    #[must_use]
    pub fn set_associative(&self, sets: u64, ways: u64) -> f64 {
        assert!(sets > 0 && ways > 0, "a cache has at least one set and one way");
        // How many other lines it takes until `ways` of them are in the set is negative binomial, and a
        // line is evicted as from a fully associative cache of that many lines. The probability is carried
        // as a logarithm while it is too small for an f64.
        const SMALLEST: f64 = -700.0;
        let share = 1.0 / sets as f64;
        let mut logarithm = ways as f64 * share.ln();
        let mut probability = logarithm.exp();
        let (mut expected, mut rest) = (0.0, 1.0_f64);
        for lines in ways..self.misses.len() as u64 {
            expected += probability * self.misses[lines as usize] as f64;
            rest -= probability;
            let step = lines as f64 / (lines + 1 - ways) as f64 * (1.0 - share);
            if logarithm < SMALLEST {
                logarithm += step.ln();
                probability = logarithm.exp();
            } else {
                probability *= step;
            }
        }
        expected + rest.max(0.0) * self.cold_misses() as f64
    }
}
