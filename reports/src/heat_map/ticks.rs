//! Round tick values for a scale that starts at 0.

/// Multiples of 1, 2 or 5 times a power of ten from 0 to `end`: at least 2 and at most 8 of them.
pub(super) fn ticks(end: u32) -> Vec<u32> {
    const MOST: u64 = 7;
    let end = u64::from(end.max(1));
    let steps = (0..).flat_map(|power| [1, 2, 5].map(|factor| factor * 10_u64.pow(power)));
    let step = steps.into_iter().find(|step| end / step <= MOST).unwrap_or(end);
    (0..=end / step).map(|index| (index * step) as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(1), [0, 1]);
        assert_eq!(ticks(7), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(ticks(8), [0, 2, 4, 6, 8]);
        assert_eq!(ticks(132), [0, 20, 40, 60, 80, 100, 120]);
        assert_eq!(ticks(399), [0, 50, 100, 150, 200, 250, 300, 350]);
        assert_eq!(ticks(400), [0, 100, 200, 300, 400]);
        for end in (1..5000).chain([u32::MAX - 1, u32::MAX]) {
            let ticks = ticks(end);
            assert!((2..=8).contains(&ticks.len()), "{end}: {ticks:?}");
        }
    }
}
