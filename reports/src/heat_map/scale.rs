//! The scale of heat maps: from 0 to a value, or to a percentile of all values.

use super::{NO_VALUE, ScaleEnd};

/// Range of a scale and of the values on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Value of the last colour; at least 1.
    pub(crate) end: u32,
    /// Part of the values above `end`.
    pub(crate) clamped: f64,
}

impl Scale {
    /// The scale of all maps together.
    pub(crate) fn of(maps: &[&[u32]], end: ScaleEnd) -> Self {
        let mut values: Vec<u32> = maps.iter().flat_map(|map| there(map)).collect();
        let count = values.len();
        if count == 0 {
            return Self { end: 1, clamped: 0.0 };
        }
        let end = match end {
            ScaleEnd::Percentile(percentile) => {
                let rank = ((count as f64 * percentile / 100.0).ceil() as usize).clamp(1, count) - 1;
                *values.select_nth_unstable(rank).1
            }
            ScaleEnd::Value(value) => value,
        };
        let end = end.max(1);
        let clamped = values.iter().filter(|&&value| value > end).count() as f64 / count as f64;
        Self { end, clamped }
    }
}

/// The values of a map that there are.
pub(crate) fn there(values: &[u32]) -> impl Iterator<Item = u32> {
    values.iter().copied().filter(|&value| value != NO_VALUE)
}

/// Mean and largest of the values of one map, where it has any.
pub(crate) fn mean_and_max(values: &[u32]) -> Option<(f64, u32)> {
    let (mut sum, mut count) = (0, 0_u64);
    there(values).for_each(|value| {
        sum += u64::from(value);
        count += 1;
    });
    Some((sum as f64 / count as f64, there(values).max()?))
}

#[cfg(test)]
mod tests {
    use super::ScaleEnd::Percentile;
    use super::*;

    #[test]
    fn the_scale_ends_at_the_percentile_and_counts_what_lies_above() {
        let values: Vec<u32> = (1..=1000).collect();
        assert_eq!(Scale::of(&[&values], Percentile(99.0)), Scale { end: 990, clamped: 0.01 });
        assert_eq!(Scale::of(&[&values], Percentile(100.0)).clamped, 0.0);
        assert_eq!(mean_and_max(&values), Some((500.5, 1000)));
    }

    #[test]
    fn values_equal_to_the_end_are_not_above_it() {
        assert_eq!(Scale::of(&[&[5, 5, 5, 9]], Percentile(50.0)), Scale { end: 5, clamped: 0.25 });
    }

    #[test]
    fn a_black_map_still_has_a_scale() {
        assert_eq!(Scale::of(&[&[0, 0]], Percentile(99.5)), Scale { end: 1, clamped: 0.0 });
    }

    #[test]
    fn several_maps_are_ranked_as_one() {
        let (low, high): (Vec<u32>, Vec<u32>) = ((1..=500).collect(), (501..=1000).collect());
        let both: Vec<u32> = (1..=1000).collect();
        assert_eq!(Scale::of(&[&high, &low], Percentile(75.0)), Scale::of(&[&both], Percentile(75.0)));
    }

    #[test]
    fn pixels_without_a_value_count_nowhere() {
        let values = [NO_VALUE, 2, NO_VALUE, 4];
        assert_eq!(mean_and_max(&values), Some((3.0, 4)));
        assert_eq!(Scale::of(&[&values], Percentile(100.0)), Scale { end: 4, clamped: 0.0 });
        assert_eq!(Scale::of(&[&values], ScaleEnd::Value(3)), Scale { end: 3, clamped: 0.5 });
        assert_eq!(mean_and_max(&[NO_VALUE]), None);
        assert_eq!(Scale::of(&[&[NO_VALUE]], Percentile(99.0)), Scale { end: 1, clamped: 0.0 });
    }
}
