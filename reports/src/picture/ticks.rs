//! Round tick values.

/// Multiples of 1, 2 or 5 times a power of ten from `low` to `high`, `least` or more apart, and at most `most` of them;
/// none where `high` is not above `low`.
pub(crate) fn linear(low: f64, high: f64, most: usize, least: f64) -> Vec<f64> {
    let range = high - low;
    let begin = (range / most as f64).max(least);
    if !(range > 0.0 && begin.is_normal() && range.is_finite()) {
        return Vec::new();
    }
    let powers = begin.log10().floor() as i32..;
    // A hair of room for the rounding of the quotients.
    let place = |value: f64, step: f64| (value / step, (value / step).abs() * 1e-12);
    let multiples = |step: f64| {
        let ((first, below), (last, above)) = (place(low, step), place(high, step));
        ((first - below).ceil() as i64, (last + above).floor() as i64)
    };
    let fits = |power: i32, factor: f64| {
        // A division by ten to a whole power is exact where the power is.
        let multiple = |times: i64| {
            let ten = 10_f64.powi(power.abs());
            if power < 0 { times as f64 * factor / ten } else { times as f64 * factor * ten }
        };
        let step = multiple(1);
        let (first, last) = multiples(step);
        let fits = step >= least && last - first < most as i64;
        fits.then(|| (first..=last).map(multiple).collect())
    };
    powers
        .flat_map(|power| [1.0, 2.0, 5.0].map(|factor| (power, factor)))
        .find_map(|(power, factor)| fits(power, factor))
        .unwrap_or_default()
}

/// Ticks of a logarithmic scale from `low` to `high`, both above 0: powers of ten, with their 2- and 5-fold between them
/// where the scale is short, and only every n-th where it is long.
pub(crate) fn logarithmic(low: f64, high: f64, most: usize) -> Vec<f64> {
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let span = high.log10() - low.log10();
    let factors: &[u32] = if span * 3.0 <= most as f64 { &[1, 2, 5] } else { &[1] };
    let every = (span / most as f64).ceil().max(1.0) as i32;
    let tick = |power: i32, factor: u32| {
        // Reading decimals gives the double nearest to the tick.
        format!("{factor}e{power}").parse::<f64>().expect("a number")
    };
    let ticks = powers.filter(|power| power.rem_euclid(every) == 0);
    let ticks = ticks.flat_map(|power| factors.iter().map(move |&factor| tick(power, factor)));
    ticks.filter(|tick| (low..=high).contains(tick)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_ticks_are_round_and_few() {
        let ticks = |end: u32| linear(0.0, f64::from(end), 8, 1.0);
        assert_eq!(ticks(1), [0.0, 1.0]);
        assert_eq!(ticks(7), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(ticks(8), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(ticks(132), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0]);
        assert_eq!(ticks(400), [0.0, 100.0, 200.0, 300.0, 400.0]);
        for end in (1..5000).chain([u32::MAX - 1, u32::MAX]) {
            let ticks = ticks(end);
            assert!((2..=8).contains(&ticks.len()), "{end}: {ticks:?}");
        }
    }

    #[test]
    fn ticks_of_any_range_lie_within_it_and_are_two_or_more() {
        assert_eq!(linear(0.0, 0.3, 8, 0.0), [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]);
        assert_eq!(linear(-3.0, 3.0, 4, 0.0), [-2.0, 0.0, 2.0]);
        for (low, high) in [(0.0, 1e-9), (0.0, 1e12), (3.1, 3.2), (1e6, 1e6 + 1.0), (7.0, 9e15)] {
            let ticks = linear(low, high, 6, 0.0);
            assert!((2..=6).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
            assert!(ticks.iter().all(|tick| (low..=high).contains(tick)), "{low} to {high}: {ticks:?}");
        }
    }

    #[test]
    fn what_is_no_range_has_no_ticks() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            assert!(linear(low, high, 6, 0.0).is_empty(), "{low} to {high}");
        }
    }

    #[test]
    fn logarithmic_ticks_are_finer_on_short_scales() {
        assert_eq!(logarithmic(1.0, 100.0, 8), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(logarithmic(1e-3, 1e3, 8), [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3]);
        let long = logarithmic(1e-9, 1e12, 8);
        assert!((5..=8).contains(&long.len()), "{long:?}");
    }
}
