//! Temperatures in the long run, or that there are none.

use crate::equation::HeatEquation;

/// Where a network ends up under constant power.
#[derive(Clone, Debug, PartialEq)]
pub enum LongRun {
    /// At these temperatures, in K above the air: the lower of the two balances, which is the stable one.
    Settles(Vec<f64>),
    /// Nowhere: each kelvin brings in more leakage than the network carries away, so it warms without end.
    RunsAway,
}

/// Halvings after which an interval of length 1 is one float wide, wherever the root lies.
const MOST_HALVINGS: u32 = 1200;

/// Where the temperatures go.
///
/// Leakage at one node makes this one equation. With `T` its rise without leakage, `R` its resistance to the air and
/// `u = per_kelvin (rise - T)`, the balance is `u = a e^u` with `a = R per_kelvin watts(T)`. Its lower root is in `[0, 1]` where
/// `a <= 1/e`, and there is none above (`u = -W(-a)` with Lambert's W); so that root is bracketed, or does not exist.
pub fn long_run(equation: &HeatEquation<'_>) -> LongRun {
    let network = equation.network;
    let without = network.settled(&equation.power);
    let Some(leakage) = equation.leakage.filter(|leakage| leakage.at_reference > 0.0) else {
        return LongRun::Settles(without);
    };
    let mut unit = vec![0.0; network.size()];
    unit[leakage.node] = 1.0;
    let response = network.settled(&unit);
    let a = response[leakage.node] * leakage.slope(without[leakage.node]);
    let has_a_root = a * 1.0_f64.exp() <= 1.0;
    if !has_a_root {
        return LongRun::RunsAway;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..MOST_HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if middle < a * f64::exp(middle) { low = middle } else { high = middle }
    }
    let watts = leakage.watts(without[leakage.node] + 0.5 * (low + high) / leakage.per_kelvin);
    LongRun::Settles(without.iter().zip(&response).map(|(rise, per_watt)| rise + per_watt * watts).collect())
}
