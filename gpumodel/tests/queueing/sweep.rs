//! Ten thousand random and extreme networks: answers, bounds and directions.

use crate::Row;
use crate::random::{Random, extreme_network};
use gpumodel::queueing::{Network, Solution, Station, solve};

const NETWORKS: u32 = 10_000;

pub(crate) fn rows() -> Vec<Row> {
    let mut random = Random(20_260_101);
    let (mut residual, mut evaluations, mut beyond, mut slower, mut least_headroom) =
        (0.0f64, 0, 0.0f64, 0.0f64, 1.0f64);
    for _ in 0..NETWORKS {
        let network = extreme_network(&mut random);
        let solution = solve(&network).expect("the network is valid");
        assert_sound(&network, &solution);
        residual = residual.max(solution.residual);
        evaluations = evaluations.max(solution.evaluations);
        beyond = beyond.max(solution.throughput / upper_bound(&network) - 1.0);
        for larger in with_more_capacity(&network) {
            let faster = solve(&larger).expect("the network is valid");
            slower = slower.max(1.0 - faster.throughput / solution.throughput);
        }
        let crowded = Network { customers: network.customers * 1.5, ..network.clone() };
        let crowded = solve(&crowded).expect("the network is valid");
        slower = slower.max(1.0 - crowded.cycle_time / solution.cycle_time);
        let headrooms = solution.stations.iter().map(|station| station.headroom);
        least_headroom = headrooms.filter(|headroom| *headroom > 0.0).fold(least_headroom, f64::min);
    }
    vec![
        Row { what: "residual of the balance, worst".to_owned(), measured: residual, range: (0.0, 1e-9) },
        Row {
            what: "evaluations of the balance, worst".to_owned(),
            measured: f64::from(evaluations),
            range: (1.0, 96.0),
        },
        Row {
            what: "throughput over the asymptotic bound - 1, worst".to_owned(),
            measured: beyond,
            range: (-1.0, 1e-14),
        },
        Row {
            what: "throughput lost to more capacity, relative, worst".to_owned(),
            measured: slower,
            range: (-1.0, 1e-12),
        },
        Row { what: "headroom above 0, least met".to_owned(), measured: least_headroom, range: (0.0, 1e-12) },
    ]
}

/// Finite numbers with the signs and sums they should have.
fn assert_sound(network: &Network, solution: &Solution) {
    let about = format!("{network:?} gives {solution:?}");
    assert!(solution.throughput.is_finite() && solution.throughput > 0.0, "{about}");
    assert!(solution.cycle_time.is_finite() && solution.cycle_time > 0.0, "{about}");
    assert_eq!(
        solution.stack().iter().map(|share| share.seconds).sum::<f64>(),
        solution.cycle_time,
        "{about}"
    );
    for (station, load) in network.stations.iter().zip(&solution.stations) {
        assert!(load.service >= 0.0 && load.service <= station.demand * (1.0 + 1e-14), "{about}");
        assert!((0.0..=1.0).contains(&load.utilisation) && (0.0..=1.0).contains(&load.headroom), "{about}");
        assert!((load.utilisation + load.headroom - 1.0).abs() <= 1e-15, "{about}");
        let (capacity, sharers) = (f64::from(station.servers), f64::from(station.sharers));
        let work = solution.throughput * station.demand * sharers / capacity;
        assert!((load.utilisation - work).abs() <= 1e-14 * work, "{about}");
        assert!((load.queue - solution.throughput * load.response()).abs() <= 1e-14 * load.queue, "{about}");
        let all_others = (network.customers * sharers - 1.0) * station.demand / capacity;
        assert!(load.queueing >= 0.0 && load.queueing <= all_others * (1.0 + 1e-14), "{about}");
    }
}

/// The asymptotic bounds: some station's capacity, and the cycle that waits for nobody.
fn upper_bound(network: &Network) -> f64 {
    let mut unqueued = network.think_time;
    let mut capacity = f64::INFINITY;
    for station in &network.stations {
        let servers = f64::from(station.servers);
        capacity = capacity.min(servers / (station.demand * f64::from(station.sharers)));
        unqueued += station.demand / station.burst * (1.0 + (station.burst - 1.0) / servers);
    }
    capacity.min(network.customers / unqueued)
}

/// The network with one thing at a time made better, by much and by hardly anything.
fn with_more_capacity(network: &Network) -> Vec<Network> {
    let mut larger = Vec::new();
    for scale in [0.5, 1.0 - 1e-6, 1.0 - 1e-12] {
        larger.push(Network { think_time: network.think_time * scale, ..network.clone() });
        larger.push(Network { customers: network.customers / scale, ..network.clone() });
    }
    larger.push(Network { customers: network.customers + 1.0, ..network.clone() });
    for (place, station) in network.stations.iter().enumerate() {
        let mut with = |station: Station| {
            let mut better = network.clone();
            better.stations[place] = station;
            larger.push(better);
        };
        for scale in [0.1, 1.0 - 1e-6, 1.0 - 1e-12] {
            with(Station { demand: station.demand * scale, ..*station });
        }
        with(Station { servers: station.servers + 1, ..*station });
        with(Station { servers: station.servers * 16, ..*station });
        with(Station { variability: station.variability * 0.5, ..*station });
        with(Station { sharers: station.sharers.div_ceil(2), ..*station });
    }
    larger
}
