//! The functions that exponential integrators are made of: `phi_k(x) = (phi_(k-1)(x) - 1/(k-1)!) / x` with `phi_0 = exp`
//! (Hochbruck and Ostermann 2010).

/// 1/k! for k from 0 on.
const INVERSE_FACTORIALS: [f64; 6] = [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0];

/// Below this magnitude the recurrence loses digits, and the series of `phi_5` has few terms.
const SMALL: f64 = 2.0;

/// `phi_1(x)` to `phi_5(x)`.
///
/// Away from 0 by the recurrence from `expm1`; near 0 by the series of the last and the recurrence downwards, in which nothing cancels.
pub(crate) fn phi(x: f64) -> [f64; 5] {
    let mut all = [0.0; 5];
    if x.abs() < SMALL {
        let mut term = INVERSE_FACTORIALS[5];
        let mut j = 5.0;
        while term.abs() > 0.1 * f64::EPSILON * all[4] {
            all[4] += term;
            j += 1.0;
            term *= x / j;
        }
        for k in (0..4).rev() {
            all[k] = x.mul_add(all[k + 1], INVERSE_FACTORIALS[k + 1]);
        }
    } else {
        all[0] = x.exp_m1() / x;
        for k in 1..5 {
            all[k] = (all[k - 1] - INVERSE_FACTORIALS[k]) / x;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kummer's transformation, `phi_k(x) = e^x / (k-1)! sum |x|^j / (j! (k + j))` for x <= 0, whose terms are all positive; and for x > 0
    /// the series of `phi_k` itself.
    fn reference(k: u32, x: f64) -> f64 {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        let (mut sum, mut term) = (0.0, 1.0);
        for j in 0..2000 {
            let (j, k) = (f64::from(j), f64::from(k));
            if x <= 0.0 {
                sum += term / (k + j);
                term *= -x / (j + 1.0);
            } else {
                sum += term;
                term *= x / (k + j + 1.0);
            }
        }
        if x <= 0.0 { x.exp() * sum / factorial(k - 1) } else { sum / factorial(k) }
    }

    #[test]
    fn no_digits_are_lost_near_zero_nor_far_from_it() {
        let magnitudes = (-160..=22).map(|step| 10_f64.powf(0.1 * f64::from(step)));
        for magnitude in magnitudes.chain([0.0, SMALL, SMALL.next_down()]) {
            for x in [magnitude, -magnitude] {
                for (k, found) in (1..).zip(phi(x)) {
                    let expected = reference(k, x);
                    assert!((found / expected - 1.0).abs() < 4e-14, "phi_{k}({x}) = {found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn what_has_decayed_is_finite() {
        for (k, found) in (1..).zip(phi(-1e300)) {
            let expected = 1e-300 / (1..k).map(f64::from).product::<f64>();
            assert!((found / expected - 1.0).abs() < 1e-12, "phi_{k}");
        }
        assert_eq!(phi(0.0), [1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0]);
    }
}
