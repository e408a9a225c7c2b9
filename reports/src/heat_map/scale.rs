//! The scale of heat maps: from 0 to a percentile of all values.

/// Range of a scale and of the values on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Value of the last colour; at least 1.
    pub(super) end: u32,
    /// Part of the values above `end`.
    pub(super) clamped: f64,
}

impl Scale {
    /// The scale of all maps together, which are not all empty.
    pub(super) fn of(maps: &[&[u32]], percentile: f64) -> Self {
        let mut sorted = maps.concat();
        let count = sorted.len();
        let rank = ((count as f64 * percentile / 100.0).ceil() as usize).clamp(1, count) - 1;
        let (_, &mut at_rank, above) = sorted.select_nth_unstable(rank);
        let end = at_rank.max(1);
        let clamped = above.iter().filter(|&&value| value > end).count() as f64 / count as f64;
        Self { end, clamped }
    }
}

/// Mean and largest of the values of one map, which is not empty.
pub(super) fn mean_and_max(values: &[u32]) -> (f64, u32) {
    let sum: u64 = values.iter().map(|&value| u64::from(value)).sum();
    (sum as f64 / values.len() as f64, values.iter().copied().max().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_at_the_percentile_and_counts_what_lies_above() {
        let values: Vec<u32> = (1..=1000).collect();
        assert_eq!(Scale::of(&[&values], 99.0), Scale { end: 990, clamped: 0.01 });
        assert_eq!(Scale::of(&[&values], 100.0).clamped, 0.0);
        assert_eq!(mean_and_max(&values), (500.5, 1000));
    }

    #[test]
    fn values_equal_to_the_end_are_not_above_it() {
        assert_eq!(Scale::of(&[&[5, 5, 5, 9]], 50.0), Scale { end: 5, clamped: 0.25 });
    }

    #[test]
    fn a_black_map_still_has_a_scale() {
        assert_eq!(Scale::of(&[&[0, 0]], 99.5), Scale { end: 1, clamped: 0.0 });
    }

    #[test]
    fn several_maps_are_ranked_as_one() {
        let (low, high): (Vec<u32>, Vec<u32>) = ((1..=500).collect(), (501..=1000).collect());
        let both: Vec<u32> = (1..=1000).collect();
        assert_eq!(Scale::of(&[&high, &low], 75.0), Scale::of(&[&both], 75.0));
    }
}
