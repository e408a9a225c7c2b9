//! Heat capacities joined by conductances: an RC network.

use crate::error::Error;
use crate::lu::Lu;
use crate::symmetric::Eigen;

/// A part of a phone that has one temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its name.
    pub name: String,
    /// Heat that warms it by a kelvin, in J/K; above 0.
    pub heat_capacity: f64,
    /// Conductance to the surrounding air, in W/K; 0 where it does not touch it.
    pub to_ambient: f64,
}

/// A path of heat between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The nodes at its ends, by place in the network.
    pub between: [usize; 2],
    /// Conductance, in W/K; above 0.
    pub conductance: f64,
}

/// Nodes, the links between them, and air of a fixed temperature around them.
///
/// Temperatures are rises above that of the air, in kelvin, unless a name says otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    nodes: Vec<Node>,
    /// Row by row: off the diagonal minus the conductances of the links, on it the sums of all conductances of the node.
    conductances: Vec<f64>,
}

/// Networks are dense and small.
const MOST_NODES: usize = 64;

impl Network {
    /// Joins nodes by links; several links between the same nodes add up.
    ///
    /// # Errors
    /// When there is no node or more than 64, a figure is not positive and finite, a link leads nowhere, or heat cannot leave a node
    /// for the air.
    pub fn new(nodes: Vec<Node>, links: &[Link]) -> Result<Self, Error> {
        let n = nodes.len();
        if n == 0 || n > MOST_NODES {
            return Err(Error::input(
                "network",
                format!("{n} nodes, expected 1 to {MOST_NODES}"),
                "describe the phone by a few parts",
            ));
        }
        let mut conductances = vec![0.0; n * n];
        for (i, node) in nodes.iter().enumerate() {
            positive(&node.name, "heat capacity", node.heat_capacity)?;
            if !(node.to_ambient >= 0.0 && node.to_ambient.is_finite()) {
                let problem = format!("conductance to the air of {}, expected at least 0", node.to_ambient);
                return Err(Error::input(&node.name, problem, "correct it"));
            }
            conductances[i * n + i] = node.to_ambient;
        }
        for &Link { between: [a, b], conductance } in links {
            if a >= n || b >= n || a == b {
                let problem = format!("between nodes {a} and {b} of {n}");
                return Err(Error::input("link", problem, "join two different nodes of the network"));
            }
            positive("link", "conductance", conductance)?;
            conductances[a * n + b] -= conductance;
            conductances[b * n + a] -= conductance;
            conductances[a * n + a] += conductance;
            conductances[b * n + b] += conductance;
        }
        let network = Self { nodes, conductances };
        if let Some(node) = network.insulated() {
            return Err(Error::input(
                &network.nodes[node].name,
                "no path of heat leads from it to the air",
                "link it to a node that has one, or give it a conductance to the air",
            ));
        }
        Ok(network)
    }

    /// The nodes.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// How many nodes there are.
    pub fn size(&self) -> usize {
        self.nodes.len()
    }

    /// The place of the node called `name`.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.name == name)
    }

    /// The same network with all heat capacities `factor` times as large: everything takes `factor` times as long.
    ///
    /// # Errors
    /// When a capacity is then not positive and finite.
    pub fn slowed(&self, factor: f64) -> Result<Self, Error> {
        let mut network = self.clone();
        for node in &mut network.nodes {
            node.heat_capacity *= factor;
            positive(&node.name, "heat capacity", node.heat_capacity)?;
        }
        Ok(network)
    }

    /// The same network with another heat capacity of a node, in J/K.
    ///
    /// # Errors
    /// When the capacity is not positive and finite.
    pub fn with_capacity(&self, node: usize, heat_capacity: f64) -> Result<Self, Error> {
        positive(&self.nodes[node].name, "heat capacity", heat_capacity)?;
        let mut network = self.clone();
        network.nodes[node].heat_capacity = heat_capacity;
        Ok(network)
    }

    /// Conductances between node `i` and all, row by row of the matrix.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        let n = self.size();
        &self.conductances[i * n..(i + 1) * n]
    }

    /// Heat stored at these temperatures, in joules above that at the temperature of the air.
    pub fn stored(&self, temperatures: &[f64]) -> f64 {
        self.nodes.iter().zip(temperatures).map(|(node, rise)| node.heat_capacity * rise).sum()
    }

    /// Temperatures in the long run under a constant power at each node, in W, without leakage.
    pub fn settled(&self, power: &[f64]) -> Vec<f64> {
        let n = self.size();
        let mut lu = Lu::default();
        lu.clear(n).copy_from_slice(&self.conductances);
        let regular = lu.factor(n);
        debug_assert!(regular, "every node has a path to the air");
        let mut temperatures = power.to_vec();
        lu.solve(&mut temperatures);
        temperatures
    }

    /// The time constants, in seconds, the longest first: every temperature is a sum of decays with these, without leakage.
    pub fn time_constants(&self) -> Vec<f64> {
        let n = self.size();
        let weight = |i: usize| self.nodes[i].heat_capacity.sqrt();
        let entry = |k: usize| self.conductances[k] / (weight(k / n) * weight(k % n));
        let mut matrix: Vec<f64> = (0..n * n).map(entry).collect();
        let mut eigen = Eigen::default();
        eigen.of(&mut matrix, n);
        let mut constants: Vec<f64> = eigen.values.iter().map(|rate| 1.0 / rate).collect();
        constants.sort_by(|a, b| b.total_cmp(a));
        constants
    }

    /// A node from which no chain of links leads to one that touches the air.
    fn insulated(&self) -> Option<usize> {
        let n = self.size();
        let mut reached: Vec<bool> = self.nodes.iter().map(|node| node.to_ambient > 0.0).collect();
        for _ in 0..n {
            for i in 0..n {
                reached[i] |= (0..n).any(|j| i != j && self.row(i)[j] != 0.0 && reached[j]);
            }
        }
        reached.iter().position(|reached| !reached)
    }
}

fn positive(what: &str, figure: &str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::input(what, format!("{figure} of {value}, expected more than 0"), "correct it"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, heat_capacity: f64, to_ambient: f64) -> Node {
        Node { name: name.to_owned(), heat_capacity, to_ambient }
    }

    #[test]
    fn heat_flows_in_series_and_in_parallel() {
        let nodes = vec![node("die", 0.1, 0.0), node("case", 50.0, 0.25)];
        let links = [Link { between: [0, 1], conductance: 0.3 }, Link { between: [1, 0], conductance: 0.2 }];
        let network = Network::new(nodes, &links).expect("a network");
        let settled = network.settled(&[2.0, 1.0]);
        assert!((settled[1] - 3.0 / 0.25).abs() < 1e-12 && (settled[0] - (12.0 + 2.0 / 0.5)).abs() < 1e-12);
        assert!((network.stored(&[1.0, 2.0]) - 100.1).abs() < 1e-12);
    }

    #[test]
    fn time_constants_are_those_of_two_nodes_in_closed_form() {
        let nodes = vec![node("die", 1e-6, 0.0), node("case", 50.0, 0.25)];
        let network = Network::new(nodes, &[Link { between: [0, 1], conductance: 0.5 }]).expect("a network");
        // Rates are the roots of x^2 - (g/c + (g+a)/C) x + g a / (c C).
        let (sum, product): (f64, f64) = (0.5 / 1e-6 + 0.75 / 50.0, 0.5 * 0.25 / (1e-6 * 50.0));
        let fast = 0.5 * (sum + (sum * sum - 4.0 * product).sqrt());
        let found = network.time_constants();
        assert!(
            (found[1] * fast - 1.0).abs() < 1e-12 && (found[0] * product / fast - 1.0).abs() < 1e-12,
            "{found:?}"
        );
    }

    #[test]
    fn what_has_no_meaning_is_refused_and_named() {
        let refused = |nodes, links: &[Link]| Network::new(nodes, links).expect_err("refused").to_string();
        assert!(refused(vec![], &[]).contains("0 nodes"));
        assert!(refused(vec![node("die", 0.0, 1.0)], &[]).contains("die: heat capacity of 0"));
        assert!(refused(vec![node("die", f64::NAN, 1.0)], &[]).contains("NaN"));
        let two = || vec![node("die", 1.0, 0.0), node("case", 1.0, 1.0)];
        assert!(refused(two(), &[]).contains("die: no path of heat"));
        assert!(refused(two(), &[Link { between: [0, 2], conductance: 1.0 }]).contains("0 and 2"));
        assert!(refused(two(), &[Link { between: [0, 1], conductance: -1.0 }]).contains("-1"));
    }
}
