//! Static re-reference interval prediction with hit priority, 2 bits per way (Jaleel et al. 2010).

use super::Replacement;

/// The prediction "in the distant future": the way to take.
const DISTANT: u8 = 3;
/// The prediction for a new line.
const LONG: u8 = 2;

/// Re-reference predictions, 0 (near) to 3 (distant).
#[derive(Clone, Debug)]
pub(crate) struct Srrip {
    predictions: Vec<u8>,
    ways: usize,
}

impl Srrip {
    pub(crate) fn new(sets: usize, ways: usize) -> Self {
        Self { predictions: vec![DISTANT; sets * ways], ways }
    }
}

impl Replacement for Srrip {
    fn touched(&mut self, set: usize, way: usize) {
        self.predictions[set * self.ways + way] = 0;
    }

    fn filled(&mut self, set: usize, way: usize) {
        self.predictions[set * self.ways + way] = LONG;
    }

    /// The first way predicted distant, after ageing all alike until there is one.
    fn victim(&mut self, set: usize) -> usize {
        let predictions = &mut self.predictions[set * self.ways..][..self.ways];
        let age = DISTANT - predictions.iter().copied().max().unwrap_or(DISTANT);
        predictions.iter_mut().for_each(|prediction| *prediction += age);
        predictions.iter().position(|&prediction| prediction == DISTANT).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_hit_once_outlives_lines_never_hit() {
        let mut srrip = Srrip::new(1, 4);
        for way in 0..4 {
            srrip.filled(0, way);
        }
        srrip.touched(0, 0);
        assert_eq!(srrip.predictions, [0, 2, 2, 2]);
        assert_eq!(srrip.victim(0), 1);
        assert_eq!(srrip.predictions, [1, 3, 3, 3], "all aged by one");
        srrip.filled(0, 1);
        assert_eq!(srrip.predictions, [1, 2, 3, 3]);
        assert_eq!(srrip.victim(0), 2, "no ageing while a way is distant");
        srrip.filled(0, 2);
        assert_eq!(srrip.victim(0), 3);
        srrip.filled(0, 3);
        assert_eq!(srrip.victim(0), 1, "way 0 was aged to 2 at last");
        assert_eq!(srrip.predictions, [2, 3, 3, 3]);
    }
}
