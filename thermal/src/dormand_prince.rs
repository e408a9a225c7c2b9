//! The explicit Runge-Kutta method of Dormand and Prince (1980), order 5 with an embedded order 4.

use crate::equation::{HeatEquation, State};
use crate::method::largest;

const STAGES: usize = 7;

#[rustfmt::skip]
const A: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Weights of the fifth order less those of the fourth.
#[rustfmt::skip]
const ERROR: [f64; STAGES] = [
    71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0,
];

#[derive(Clone, Debug, Default)]
pub(crate) struct DormandPrince {
    /// Derivatives at the stages; the first holds until the next start.
    slopes: [Vec<f64>; STAGES],
    point: Vec<f64>,
}

impl DormandPrince {
    pub(crate) fn start(&mut self, equation: &HeatEquation<'_>, state: &State) {
        let size = state.values().len();
        self.slopes.iter_mut().chain([&mut self.point]).for_each(|slope| slope.resize(size, 0.0));
        equation.derivative(state.values(), &mut self.slopes[0]);
    }

    pub(crate) fn step(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        seconds: f64,
        out: &mut State,
    ) -> f64 {
        for (stage, weights) in A.iter().enumerate().skip(1) {
            for (i, value) in state.values().iter().enumerate() {
                let slope: f64 = (0..stage).map(|j| weights[j] * self.slopes[j][i]).sum();
                self.point[i] = seconds.mul_add(slope, *value);
            }
            equation.derivative(&self.point, &mut self.slopes[stage]);
        }
        // The last stage stands at the end of the step.
        out.values_mut().copy_from_slice(&self.point);
        let error = |i: usize| seconds * (0..STAGES).map(|j| ERROR[j] * self.slopes[j][i]).sum::<f64>();
        largest((0..equation.network.size()).map(error))
    }
}
