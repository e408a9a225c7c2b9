//! The Rosenbrock method RODAS of Hairer and Wanner (Solving Ordinary Differential Equations II, 1996): order 4 with an embedded order 3,
//! stiffly accurate and L-stable. Each stage is a linear system; there is no iteration that could fail.

use crate::equation::{HeatEquation, State};
use crate::lu::Lu;
use crate::method::largest;

const STAGES: usize = 6;
const GAMMA: f64 = 0.25;

#[rustfmt::skip]
const A: [[f64; 4]; 4] = [
    [1.544, 0.0, 0.0, 0.0],
    [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0],
    [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895],
];

#[rustfmt::skip]
const C: [[f64; 5]; 5] = [
    [-5.6688, 0.0, 0.0, 0.0, 0.0],
    [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0],
    [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0],
    [7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6, 0.0],
    [8.083_246_795_921_522, -7.981_132_988_064_893, -31.521_594_328_743_71, 16.319_305_431_231_36, -6.058_818_238_834_054],
];

#[derive(Clone, Debug, Default)]
pub(crate) struct Rosenbrock {
    jacobian: Vec<f64>,
    slope: Vec<f64>,
    lu: Lu,
    stages: [Vec<f64>; STAGES],
    point: Vec<f64>,
}

impl Rosenbrock {
    pub(crate) fn start(&mut self, equation: &HeatEquation<'_>, state: &State) {
        let size = state.values().len();
        self.jacobian.resize(size * size, 0.0);
        equation.jacobian(state.values(), &mut self.jacobian);
        self.stages
            .iter_mut()
            .chain([&mut self.slope, &mut self.point])
            .for_each(|values| values.resize(size, 0.0));
        equation.derivative(state.values(), &mut self.slope);
    }

    pub(crate) fn step(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        seconds: f64,
        out: &mut State,
    ) -> f64 {
        let (n, size) = (equation.network.size(), state.values().len());
        let matrix = self.lu.clear(n);
        for i in 0..n {
            (0..n).for_each(|j| matrix[i * n + j] = -self.jacobian[i * size + j]);
            matrix[i * n + i] += 1.0 / (GAMMA * seconds);
        }
        if !self.lu.factor(n) {
            return f64::INFINITY;
        }
        self.point.copy_from_slice(state.values());
        for stage in 0..STAGES {
            match stage {
                0 => {}
                1..=4 => {
                    for (i, value) in state.values().iter().enumerate() {
                        let sum: f64 = (0..stage).map(|j| A[stage - 1][j] * self.stages[j][i]).sum();
                        self.point[i] = value + sum;
                    }
                }
                _ => add(&mut self.point, &self.stages[4]),
            }
            let (before, rest) = self.stages.split_at_mut(stage);
            let current = &mut rest[0];
            if stage == 0 {
                current.copy_from_slice(&self.slope);
            } else {
                equation.derivative(&self.point, current);
                for (j, earlier) in before.iter().enumerate() {
                    let factor = C[stage - 1][j] / seconds;
                    current.iter_mut().zip(earlier).for_each(|(value, earlier)| *value += factor * earlier);
                }
            }
            // Heat that has flowed follows the temperatures, and nothing follows it.
            let (temperatures, heat) = current.split_at_mut(n);
            self.lu.solve(temperatures);
            for (row, heat) in (n..size).zip(heat) {
                let slopes = &self.jacobian[row * size..row * size + n];
                let follows: f64 =
                    slopes.iter().zip(&*temperatures).map(|(slope, change)| slope * change).sum();
                *heat = GAMMA * seconds * (*heat + follows);
            }
        }
        // The last stage is the error of the embedded order 3.
        add(&mut self.point, &self.stages[5]);
        out.values_mut().copy_from_slice(&self.point);
        largest(self.stages[5][..n].iter().copied())
    }
}

fn add(to: &mut [f64], what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += what);
}
