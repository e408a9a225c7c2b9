//! The exponential Rosenbrock method `exprb43` (Hochbruck, Ostermann and Schweitzer 2009), with exact matrix functions.
//!
//! Weighted by the roots of the heat capacities, the Jacobian of the heat equation is symmetric: conductances are, and leakage adds to its diagonal alone.
//! So its eigenvectors turn every function of it into one of numbers. What is left beside the linearised equation is one number per stage, the leakage above its
//! tangent, and that acts on one node.

use crate::equation::{HeatEquation, State};
use crate::method::largest;
use crate::phi::phi;
use crate::symmetric::Eigen;

#[derive(Clone, Debug, Default)]
pub(crate) struct Exponential {
    eigen: Eigen,
    matrix: Vec<f64>,
    /// Roots of the heat capacities.
    weights: Vec<f64>,
    /// State and slope, weighted, by mode.
    modes: Vec<f64>,
    slopes: Vec<f64>,
    scratch: Vec<f64>,
    change: Vec<f64>,
}

/// Coefficients of `phi_3` and `phi_4` in the step, from what the stages at its middle and end found above the tangent; those of `phi_4` are the difference to the embedded order 3.
fn remainders(middle: f64, end: f64) -> (f64, f64) {
    (16.0 * middle - 2.0 * end, 12.0 * end - 48.0 * middle)
}

impl Exponential {
    pub(crate) fn start(&mut self, equation: &HeatEquation<'_>, state: &State) {
        let network = equation.network;
        let n = network.size();
        let temperatures = state.temperatures();
        self.weights.clear();
        self.weights.extend(network.nodes().iter().map(|node| node.heat_capacity.sqrt()));
        self.matrix.resize(n * n, 0.0);
        for i in 0..n {
            for j in 0..n {
                self.matrix[i * n + j] = -network.row(i)[j] / (self.weights[i] * self.weights[j]);
            }
        }
        if let Some(leakage) = equation.leakage {
            let d = leakage.node;
            self.matrix[d * n + d] += leakage.slope(temperatures[d]) / (self.weights[d] * self.weights[d]);
        }
        self.eigen.of(&mut self.matrix, n);
        [&mut self.modes, &mut self.slopes, &mut self.scratch, &mut self.change]
            .into_iter()
            .for_each(|values| values.resize(n, 0.0));
        for i in 0..n {
            self.scratch[i] = self.weights[i] * temperatures[i];
        }
        self.eigen.into_modes(&self.scratch, &mut self.modes);
        for i in 0..n {
            self.scratch[i] = equation.net_heat(temperatures, i) / self.weights[i];
        }
        self.eigen.into_modes(&self.scratch, &mut self.slopes);
    }

    pub(crate) fn step(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        seconds: f64,
        out: &mut State,
    ) -> f64 {
        let n = self.weights.len();
        let h = seconds;
        let temperatures = state.temperatures();
        // Of each mode: how much of a remainder reaches it, in weighted units.
        let reach = |this: &Self, k: usize| {
            equation
                .leakage
                .map_or(0.0, |leakage| this.eigen.row(leakage.node)[k] / this.weights[leakage.node])
        };
        let functions: Vec<[f64; 5]> = self.eigen.values.iter().map(|value| phi(h * value)).collect();
        let (middle, end) = equation.leakage.map_or((0.0, 0.0), |leakage| {
            let d = leakage.node;
            let at_node = |change: &dyn Fn(usize) -> f64| {
                let row = self.eigen.row(d);
                (0..n).map(|k| row[k] * change(k)).sum::<f64>() / self.weights[d]
            };
            let half = 0.5 * h;
            let to_middle = at_node(&|k| half * phi(half * self.eigen.values[k])[0] * self.slopes[k]);
            let middle = leakage.above_tangent(temperatures[d], to_middle);
            let to_end = at_node(&|k| h * functions[k][0] * (self.slopes[k] + middle * reach(self, k)));
            (middle, leakage.above_tangent(temperatures[d], to_end))
        });
        let (third, fourth) = remainders(middle, end);

        for k in 0..n {
            let [phi_1, _, phi_3, phi_4, _] = functions[k];
            self.scratch[k] =
                h * (phi_1 * self.slopes[k] + (third * phi_3 + fourth * phi_4) * reach(self, k));
        }
        self.eigen.from_modes(&self.scratch, &mut self.change);
        let values = out.values_mut();
        for i in 0..n {
            values[i] = temperatures[i] + self.change[i] / self.weights[i];
        }

        // Integrals of the temperatures over the step: the next function of each.
        for k in 0..n {
            let [_, phi_2, _, phi_4, phi_5] = functions[k];
            self.scratch[k] =
                h * h * (phi_2 * self.slopes[k] + (third * phi_4 + fourth * phi_5) * reach(self, k));
        }
        self.eigen.from_modes(&self.scratch, &mut self.change);
        let beyond = |i: usize| self.change[i] / self.weights[i];
        let leaked = equation.leakage.map_or(0.0, |leakage| {
            let d = leakage.node;
            h * leakage.watts(temperatures[d])
                + leakage.slope(temperatures[d]) * beyond(d)
                + h * (third / 6.0 + fourth / 24.0)
        });
        let to_air = |(i, node): (usize, &crate::Node)| node.to_ambient * (h * temperatures[i] + beyond(i));
        values[n] = state.heat_in() + h * equation.power.iter().sum::<f64>() + leaked;
        values[n + 1] =
            state.heat_out() + equation.network.nodes().iter().enumerate().map(to_air).sum::<f64>();

        for k in 0..n {
            self.scratch[k] = h * fourth * functions[k][3] * reach(self, k);
        }
        self.eigen.from_modes(&self.scratch, &mut self.change);
        largest((0..n).map(|i| self.change[i] / self.weights[i]))
    }
}
