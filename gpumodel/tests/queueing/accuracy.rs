//! The estimate against exact solutions and simulation.

use crate::Row;
use crate::exact::{convolution, mva};
use crate::random::{NAMES, Random, small_network};
use crate::simulation::simulate;
use gpumodel::queueing::{Network, Station, solve};

/// Relative errors of throughput, collected.
struct Errors {
    lowest: f64,
    highest: f64,
    sum: f64,
    count: f64,
}

impl Errors {
    fn of(networks: impl Iterator<Item = (Network, f64)>) -> Self {
        let mut errors = Self { lowest: 0.0, highest: 0.0, sum: 0.0, count: 0.0 };
        for (network, truth) in networks {
            let error = solve(&network).expect("the network is valid").throughput / truth - 1.0;
            errors.lowest = errors.lowest.min(error);
            errors.highest = errors.highest.max(error);
            errors.sum += error.abs();
            errors.count += 1.0;
        }
        errors
    }

    /// Mean, lowest and highest error, each with its limit.
    fn rows(&self, what: &str, mean: f64, lowest: f64, highest: f64) -> [Row; 3] {
        let row =
            |figure, measured, range| Row { what: format!("error to {what}: {figure}"), measured, range };
        [
            row("mean", self.sum / self.count, (0.0, mean)),
            row("lowest", self.lowest, (lowest, 0.0)),
            row("highest", self.highest, (0.0, highest)),
        ]
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let mut random = Random(3);
    let single = Errors::of((0..10_000).map(|_| {
        let network = small_network(&mut random);
        let truth = mva(&network);
        (network, truth)
    }));
    let multiple = Errors::of((0..10_000).map(|_| {
        let mut network = small_network(&mut random);
        for station in &mut network.stations {
            station.servers = random.pick(&[1, 2, 4, 8, 16]);
            station.demand *= random.pick(&[1.0, f64::from(station.servers)]);
        }
        let truth = convolution(&network);
        (network, truth)
    }));
    let mut simulations = |stations, servers: &[u32], bursts: &[f64]| {
        Errors::of((0..60).map(|_| simulated(&mut random, stations, servers, bursts)))
    };
    let constant = simulations(1, &[1], &[1.0]);
    let line = simulations(3, &[1], &[1.0]);
    let servers = simulations(1, &[2, 4, 8], &[1.0]);
    let bursts = simulations(1, &[2, 4, 8], &[4.0, 8.0]);
    [
        single.rows("exact, single servers", 0.012, -0.07, 1e-12),
        multiple.rows("exact, 1 to 16 servers", 0.012, -0.08, 1e-12),
        constant.rows("simulation, a constant station", 0.03, -0.08, 0.01),
        line.rows("simulation, three constant in a row", 0.06, -0.18, 0.01),
        servers.rows("simulation, constant with 2 to 8 servers", 0.012, -0.08, 0.015),
        bursts.rows("simulation, constant in bursts of 4 and 8", 0.05, -0.22, 0.01),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A network with a random delay before stations of constant service, and its simulated throughput.
fn simulated(random: &mut Random, count: usize, servers: &[u32], bursts: &[f64]) -> (Network, f64) {
    let stations: Vec<Station> = (0..count)
        .map(|place| {
            let servers = random.pick(servers);
            let demand = f64::from(servers) * random.log_uniform(0.2, 1.0);
            Station {
                servers,
                variability: 0.0,
                burst: random.pick(bursts),
                ..Station::single(NAMES[place], demand)
            }
        })
        .collect();
    let customers = random.pick(&[2.0, 4.0, 8.0, 16.0, 32.0]);
    let network = Network { customers, think_time: customers * random.log_uniform(0.1, 3.0), stations };
    let throughput = simulate(&network, random);
    (network, throughput)
}

#[test]
fn the_two_exact_recursions_agree() {
    let mut random = Random(5);
    for _ in 0..1000 {
        let network = small_network(&mut random);
        let (recursed, convolved) = (mva(&network), convolution(&network));
        assert!((recursed / convolved - 1.0).abs() < 1e-10, "{network:?}: {recursed} and {convolved}");
    }
}

#[test]
fn the_simulation_agrees_with_the_exact_solution_where_there_is_one() {
    let mut random = Random(6);
    for _ in 0..20 {
        let (mut network, _) = simulated(&mut random, 2, &[1, 2, 4], &[1.0]);
        for station in &mut network.stations {
            station.variability = 1.0;
        }
        let (simulated, exact) = (simulate(&network, &mut random), convolution(&network));
        assert!((simulated / exact - 1.0).abs() < 0.02, "{network:?}: {simulated} and {exact}");
    }
}

#[test]
fn balanced_job_bounds_hold() {
    let mut random = Random(8);
    for _ in 0..10_000 {
        let network = small_network(&mut random);
        let demands = network.stations.iter().map(|station| station.demand);
        let (total, longest) = (demands.clone().sum::<f64>(), demands.fold(0.0, f64::max));
        let mean = total / network.stations.len() as f64;
        let (customers, think) = (network.customers, network.think_time);
        // Zahorjan et al. 1982, for terminals.
        let least =
            customers / (think + total + (customers - 1.0) * longest / (1.0 + think / (customers * total)));
        let most = customers / (think + total + (customers - 1.0) * mean / (1.0 + think / total));
        let throughput = solve(&network).expect("the network is valid").throughput;
        let range = least * (1.0 - 1e-12)..=most.min(1.0 / longest) * (1.0 + 1e-12);
        assert!(range.contains(&throughput), "{network:?}: {throughput} is not in {range:?}");
    }
}
