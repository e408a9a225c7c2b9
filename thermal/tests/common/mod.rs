//! Networks that several tests use.

use thermal::{HeatEquation, Leakage, Link, Network, Node};

/// A chain from a die to the case, as of a phone; the die holds `die` J/K.
pub(crate) fn chain(die: f64) -> Network {
    let node =
        |name: &str, heat_capacity, to_ambient| Node { name: name.to_owned(), heat_capacity, to_ambient };
    let nodes = vec![
        node("die", die, 0.0),
        node("package", 0.6, 0.0),
        node("board", 14.0, 0.01),
        node("case", 80.0, 0.25),
    ];
    let link = |a, b, conductance| Link { between: [a, b], conductance };
    Network::new(nodes, &[link(0, 1, 0.2), link(1, 2, 0.2), link(2, 3, 0.4)]).expect("a network")
}

/// 3 W at the die and 1 W at the board.
pub(crate) fn heated(network: &Network, leakage: f64) -> HeatEquation<'_> {
    let leakage = Leakage { node: 0, at_reference: leakage, reference: 20.0, per_kelvin: 0.03 };
    HeatEquation {
        network,
        power: vec![3.0, 0.0, 1.0, 0.0],
        leakage: (leakage.at_reference > 0.0).then_some(leakage),
    }
}
