//! What is refused, and what the parts of an answer mean.

use gpumodel::queueing::{Deciding, Network, NetworkError, Part, Share, Station, solve};

fn network() -> Network {
    Network {
        customers: 8.0,
        think_time: 1.0,
        stations: vec![Station::single("l2", 0.5), Station::single("dram", 2.0)],
    }
}

fn refusal(change: impl Fn(&mut Network)) -> String {
    let mut network = network();
    change(&mut network);
    solve(&network).expect_err("the network is invalid").to_string()
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    for bad in [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e61, 1e-61] {
        assert!(refusal(|network| network.think_time = bad).starts_with("think_time = "), "{bad}");
        let message = refusal(|network| network.stations[1].demand = bad);
        assert!(message.starts_with("station 'dram': demand = "), "{message}");
    }
    for bad in [0.0, -1.0, 1.0 - 1e-15, f64::NAN, f64::INFINITY, 1.1e15] {
        assert!(refusal(|network| network.customers = bad).starts_with("customers = "), "{bad}");
        let message = refusal(|network| network.stations[0].burst = bad);
        assert!(message.starts_with("station 'l2': burst = "), "{message}");
    }
    for bad in [-1e-300, f64::NAN, f64::INFINITY] {
        let message = refusal(|network| network.stations[0].variability = bad);
        assert!(message.starts_with("station 'l2': variability = "), "{message}");
    }
    assert!(refusal(|network| network.stations[0].servers = 0).contains("servers = 0"));
    assert!(refusal(|network| network.stations[0].sharers = 0).contains("sharers = 0"));
}

#[test]
fn numbers_at_the_ends_of_their_ranges_are_answered() {
    for time in [0.0, Network::SHORTEST_TIME, Network::LONGEST_TIME] {
        for other in [Network::SHORTEST_TIME, 1.0, Network::LONGEST_TIME] {
            for customers in [1.0, Network::MOST_CUSTOMERS] {
                for servers in [1, u32::MAX] {
                    for (variability, burst) in [(0.0, 1.0), (1e60, 1.0), (0.0, 1e15), (1e60, 1e15)] {
                        let station =
                            Station { name: "edge", demand: time, servers, variability, burst, sharers: 1 };
                        let network = Network {
                            customers,
                            think_time: time,
                            stations: vec![station, Station { demand: other, ..station }, station],
                        };
                        let found = solve(&network).expect("the network is valid");
                        assert!(found.residual <= 1e-9, "{network:?}: {found:?}");
                        assert!(
                            found.throughput > 0.0 && found.throughput.is_finite(),
                            "{network:?}: {found:?}"
                        );
                        assert!(found.stations.iter().all(|load| load.queueing.is_finite()), "{found:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_cycle_that_takes_no_time_is_refused_and_one_that_only_thinks_is_not() {
    let mut idle = network();
    idle.stations.iter_mut().for_each(|station| station.demand = 0.0);
    let found = solve(&idle).expect("it thinks");
    assert_eq!((found.throughput, found.cycle_time, found.deciding), (8.0, 1.0, Deciding::Latency));
    assert!(found.stations.iter().all(|station| station.utilisation == 0.0 && station.headroom == 1.0));
    idle.think_time = 0.0;
    assert_eq!(solve(&idle), Err(NetworkError::NoTime));
    idle.stations.clear();
    assert_eq!(solve(&idle), Err(NetworkError::NoTime));
}

#[test]
fn the_stack_lists_thinking_then_service_and_queueing_of_each_station() {
    let found = solve(&network()).expect("the network is valid");
    let stack = found.stack();
    let parts: Vec<Part> = stack.iter().map(|share| share.part).collect();
    assert_eq!(
        parts,
        [Part::Think, Part::Service(0), Part::Queueing(0), Part::Service(1), Part::Queueing(1)]
    );
    assert_eq!(stack[0], Share { part: Part::Think, seconds: 1.0 });
    assert_eq!(stack.iter().map(|share| share.seconds).sum::<f64>(), found.cycle_time);
    let largest =
        stack.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds)).expect("the stack is not empty");
    assert_eq!(largest.part, Part::Queueing(1), "eight customers mostly wait for the slow station");
}

#[test]
fn latency_decides_until_the_busiest_station_could_be_kept_busy() {
    let deciding =
        |customers| solve(&Network { customers, ..network() }).expect("the network is valid").deciding;
    // A cycle takes 3.5 s without queueing, of which 2 s are at the busiest station.
    assert_eq!(deciding(1.749), Deciding::Latency);
    assert_eq!(deciding(1.75), Deciding::Station(1));
}

#[test]
fn the_order_of_stations_and_stations_without_demand_do_not_matter() {
    let mut other = network();
    other.stations.reverse();
    other.stations.insert(1, Station { servers: 64, ..Station::single("idle", 0.0) });
    let (found, reordered) = (solve(&network()).expect("valid"), solve(&other).expect("valid"));
    assert_eq!(found.throughput, reordered.throughput);
    assert_eq!((found.deciding, reordered.deciding), (Deciding::Station(1), Deciding::Station(0)));
}
