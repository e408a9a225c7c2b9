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
    /// Derivatives, weighted, by mode.
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
        [&mut self.slopes, &mut self.scratch, &mut self.change]
            .into_iter()
            .for_each(|values| values.resize(n, 0.0));
        for i in 0..n {
            self.scratch[i] = equation.net_heat(temperatures, i) / self.weights[i];
        }
        self.eigen.modes_of(&self.scratch, &mut self.slopes);
    }

    /// What a figure of each mode is at the nodes, in K or K s, into [`Self::change`].
    fn at_nodes(&mut self, of_mode: impl Fn(&Self, usize) -> f64) {
        for k in 0..self.weights.len() {
            self.scratch[k] = of_mode(self, k);
        }
        self.eigen.of_modes(&self.scratch, &mut self.change);
        self.change.iter_mut().zip(&self.weights).for_each(|(change, weight)| *change /= weight);
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

        self.at_nodes(|this, k| {
            let [phi_1, _, phi_3, phi_4, _] = functions[k];
            h * (phi_1 * this.slopes[k] + (third * phi_3 + fourth * phi_4) * reach(this, k))
        });
        let values = out.values_mut();
        for (i, rise) in temperatures.iter().enumerate() {
            values[i] = rise + self.change[i];
        }

        // Integrals of the changes over the step: the next function of each.
        self.at_nodes(|this, k| {
            let [_, phi_2, _, phi_4, phi_5] = functions[k];
            h * h * (phi_2 * this.slopes[k] + (third * phi_4 + fourth * phi_5) * reach(this, k))
        });
        let leaked = equation.leakage.map_or(0.0, |leakage| {
            let d = leakage.node;
            h * leakage.watts(temperatures[d])
                + leakage.slope(temperatures[d]) * self.change[d]
                + h * (third / 6.0 + fourth / 24.0)
        });
        let nodes = equation.network.nodes().iter().enumerate();
        let to_air: f64 =
            nodes.map(|(i, node)| node.to_ambient * (h * temperatures[i] + self.change[i])).sum();
        values[n] = state.heat_in() + h * equation.power.iter().sum::<f64>() + leaked;
        values[n + 1] = state.heat_out() + to_air;

        self.at_nodes(|this, k| h * fourth * functions[k][3] * reach(this, k));
        largest(self.change.iter().copied())
    }
}
