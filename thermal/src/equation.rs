//! What the temperatures follow while nothing is switched: `C dT/dt = -G T + P + leakage`.

use crate::leakage::Leakage;
use crate::network::Network;

/// The heat equation of a network under a constant power and, at one node, leakage that grows with its temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatEquation<'a> {
    /// What heat flows through.
    pub network: &'a Network,
    /// Constant power into each node, in W.
    pub power: Vec<f64>,
    /// Power that depends on a temperature.
    pub leakage: Option<Leakage>,
}

/// Temperatures and the heat that has flowed.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Rises of the nodes above the air, in K; then the heat that has come in and that has gone to the air, in J.
    values: Vec<f64>,
}

impl State {
    /// At these temperatures (rises above the air, in K), before any heat has flowed.
    pub fn at(temperatures: &[f64]) -> Self {
        let mut values = temperatures.to_vec();
        values.extend([0.0, 0.0]);
        Self { values }
    }

    /// Everything as warm as the air.
    pub fn cold(network: &Network) -> Self {
        Self { values: vec![0.0; network.size() + 2] }
    }

    /// Rises above the air, in K.
    pub fn temperatures(&self) -> &[f64] {
        &self.values[..self.values.len() - 2]
    }

    /// Heat that all power has brought in, in J.
    pub fn heat_in(&self) -> f64 {
        self.values[self.values.len() - 2]
    }

    /// Heat that has gone to the air, in J.
    pub fn heat_out(&self) -> f64 {
        self.values[self.values.len() - 1]
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(crate) fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }
}

impl HeatEquation<'_> {
    /// Heat into node `i` and on through it, in W: what is left warms it.
    pub(crate) fn net_heat(&self, temperatures: &[f64], i: usize) -> f64 {
        let away: f64 = self.network.row(i).iter().zip(temperatures).map(|(g, rise)| g * rise).sum();
        let leaked = self.leakage.filter(|leakage| leakage.node == i);
        self.power[i] - away + leaked.map_or(0.0, |leakage| leakage.watts(temperatures[i]))
    }

    /// The change of each value of a state per second.
    pub(crate) fn derivative(&self, values: &[f64], out: &mut [f64]) {
        let n = self.network.size();
        let temperatures = &values[..n];
        for (i, node) in self.network.nodes().iter().enumerate() {
            out[i] = self.net_heat(temperatures, i) / node.heat_capacity;
        }
        out[n] = self.power_in(temperatures);
        out[n + 1] = self.to_air(temperatures);
    }

    /// Derivatives of [`Self::derivative`] by the values, row by row.
    pub(crate) fn jacobian(&self, values: &[f64], out: &mut [f64]) {
        let n = self.network.size();
        let stride = n + 2;
        out.fill(0.0);
        for (i, node) in self.network.nodes().iter().enumerate() {
            for (j, g) in self.network.row(i).iter().enumerate() {
                out[i * stride + j] = -g / node.heat_capacity;
            }
            out[(n + 1) * stride + i] = node.to_ambient;
        }
        if let Some(leakage) = self.leakage {
            let d = leakage.node;
            let slope = leakage.slope(values[d]);
            out[d * stride + d] += slope / self.network.nodes()[d].heat_capacity;
            out[n * stride + d] = slope;
        }
    }

    /// All power that comes in at these temperatures, in W.
    pub fn power_in(&self, temperatures: &[f64]) -> f64 {
        let leaked = self.leakage.map_or(0.0, |leakage| leakage.watts(temperatures[leakage.node]));
        self.power.iter().sum::<f64>() + leaked
    }

    /// Heat that goes to the air at these temperatures, in W.
    pub fn to_air(&self, temperatures: &[f64]) -> f64 {
        let nodes = self.network.nodes().iter();
        nodes.zip(temperatures).map(|(node, rise)| node.to_ambient * rise).sum()
    }
}
