//! Ways to follow the heat equation in time.

use crate::dormand_prince::DormandPrince;
use crate::equation::{HeatEquation, State};
use crate::exponential::Exponential;
use crate::rosenbrock::Rosenbrock;

/// A one-step method with an estimate of its own error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Runge-Kutta of order 5 with an embedded order 4 (Dormand and Prince 1980). Explicit: its steps cannot be much longer than the
    /// fastest time constant.
    Explicit,
    /// Rosenbrock method of order 4 with an embedded order 3, RODAS (Hairer and Wanner 1996): implicit, L-stable.
    #[default]
    Implicit,
    /// Exponential Rosenbrock method of order 4 with an embedded order 3 (Hochbruck, Ostermann and Schweitzer 2009): exact for
    /// constant power without leakage, over any step.
    Exponential,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Explicit, Self::Implicit, Self::Exponential];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit => "explicit",
            Self::Implicit => "implicit",
            Self::Exponential => "exponential",
        }
    }

    /// Order of the error estimate in the length of a step.
    pub(crate) fn error_order(self) -> f64 {
        match self {
            Self::Explicit => 5.0,
            Self::Implicit | Self::Exponential => 4.0,
        }
    }
}

/// What a method needs from step to step.
#[derive(Clone, Debug)]
pub(crate) enum Stepper {
    Explicit(DormandPrince),
    Implicit(Rosenbrock),
    Exponential(Exponential),
}

impl Stepper {
    pub(crate) fn new(method: Method) -> Self {
        match method {
            Method::Explicit => Self::Explicit(DormandPrince::default()),
            Method::Implicit => Self::Implicit(Rosenbrock::default()),
            Method::Exponential => Self::Exponential(Exponential::default()),
        }
    }

    /// Makes ready for steps from `state`, of any length.
    pub(crate) fn start(&mut self, equation: &HeatEquation<'_>, state: &State) {
        match self {
            Self::Explicit(method) => method.start(equation, state),
            Self::Implicit(method) => method.start(equation, state),
            Self::Exponential(method) => method.start(equation, state),
        }
    }

    /// A step from the state of the last [`Self::start`]; answers the estimated error of the temperatures in K: the largest, `NaN` or infinite
    /// where the step went beyond all numbers.
    pub(crate) fn step(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        seconds: f64,
        out: &mut State,
    ) -> f64 {
        match self {
            Self::Explicit(method) => method.step(equation, state, seconds, out),
            Self::Implicit(method) => method.step(equation, state, seconds, out),
            Self::Exponential(method) => method.step(equation, state, seconds, out),
        }
    }
}

/// The largest magnitude; `NaN` if one is.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values
        .map(f64::abs)
        .fold(0.0, |largest, value| if value <= largest || largest.is_nan() { largest } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_that_is_no_number_is_the_largest() {
        assert_eq!(largest([1.0, -3.0, 2.0].into_iter()), 3.0);
        assert!(largest([1.0, f64::NAN, 2.0].into_iter()).is_nan());
    }
}
