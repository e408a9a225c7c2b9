//! Spearman's rank correlation: Pearson's correlation of ranks, where equal values share the mean of their ranks.

/// The correlation of pairs, from -1 to 1; 0 where one side does not vary, since then it orders nothing.
pub(super) fn spearman(xs: &[f64], ys: &[f64]) -> f64 {
    let (xs, ys) = (ranks(xs), ranks(ys));
    let count = xs.len() as f64;
    let mean = |ranks: &[f64]| ranks.iter().sum::<f64>() / count;
    let (x_mean, y_mean) = (mean(&xs), mean(&ys));
    let mut sums = [0.0; 3];
    for (x, y) in xs.iter().zip(&ys) {
        let (dx, dy) = (x - x_mean, y - y_mean);
        sums = [sums[0] + dx * dy, sums[1] + dx * dx, sums[2] + dy * dy];
    }
    let [both, x, y] = sums;
    if x > 0.0 && y > 0.0 { both / (x * y).sqrt() } else { 0.0 }
}

fn ranks(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .map(|value| {
            let below = values.iter().filter(|other| *other < value).count();
            let equal = values.iter().filter(|other| *other == value).count();
            below as f64 + (equal as f64 + 1.0) / 2.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_that_agree_correlate_fully_whatever_the_distances() {
        assert_eq!(spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 10.0, 11.0, 1e9]), 1.0);
        assert_eq!(spearman(&[1.0, 2.0, 3.0, 4.0], &[4.0, 3.0, 2.0, 1.0]), -1.0);
    }

    #[test]
    fn one_exchange_of_neighbours_among_four_costs_a_fifth() {
        // 1 - 6 * 2 / (4 * 15)
        assert!((spearman(&[1.0, 2.0, 3.0, 4.0], &[1.0, 3.0, 2.0, 4.0]) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn equal_values_share_their_ranks() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 9.0]), [2.5, 1.0, 2.5, 4.0]);
        assert!((spearman(&[1.0, 2.0, 2.0], &[1.0, 2.0, 3.0]) - 0.75_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_vary_correlates_with_nothing() {
        assert_eq!(spearman(&[1.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), 0.0);
    }
}
