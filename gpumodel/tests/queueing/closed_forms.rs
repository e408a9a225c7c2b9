//! Networks whose solution can be written down.

use gpumodel::queueing::{Network, Solution, Station, solve};

fn solved(customers: f64, think_time: f64, stations: Vec<Station>) -> Solution {
    solve(&Network { customers, think_time, stations }).expect("the network is valid")
}

fn assert_close(found: f64, expected: f64, relative: f64, about: &str) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{about}: {found:e}, expected {expected:e}"
    );
}

/// Root `u` of `a (1 - u) + (1 - u)/u = n`: headroom of M/M/1 under a balance of `n` customers with think time `a`.
fn headroom_of_mm1(n: f64, a: f64) -> f64 {
    let c = 1.0 + n - a;
    let d = (c * c + 4.0 * a).sqrt();
    if c >= 0.0 { 2.0 / (c + d) } else { (d - c) / (2.0 * a) }
}

#[test]
fn one_exponential_station_is_mm1_under_the_balance_of_the_others_to_twelve_digits() {
    assert_close(headroom_of_mm1(1e6, 1.0), 1e-6, 2e-12, "the closed form");
    for others in [1.0, 2.0, 10.0, 1e3, 1e6 - 1.0, 1e6] {
        for think in [0.0, 1e-9, 1e-3, 1.0, 10.0, 1e3, 1e6, 1e9] {
            let service = 3e-9;
            let found = solved(others + 1.0, think * service, vec![Station::single("dram", service)]);
            let stretch = service / found.stations[0].response();
            let expected = if think > 0.0 { headroom_of_mm1(others, think) } else { 1.0 / (1.0 + others) };
            assert_close(stretch, expected, 1e-12, &format!("N = {others} + 1, a = {think}"));
        }
    }
}

#[test]
fn one_station_of_constant_service_is_the_root_of_its_quadratic() {
    for customers in [1.0, 2.0, 8.0, 1e3, 1e6] {
        for think in [1e-3, 1.0, 1e3, 1e6, 1e9] {
            let station = Station { variability: 0.0, ..Station::single("dram", 1.0) };
            let found = solved(customers, think, vec![station]);
            // (N - (1 + a) ρ) (N - (N - 1/2) ρ) = (N - 1) ρ² / 2
            let a = (1.0 + think) * (customers - 0.5) - 0.5 * (customers - 1.0);
            let b = customers * (customers - 0.5) + customers * (1.0 + think);
            let root = 2.0 * customers * customers / (b + (b * b - 4.0 * a * customers * customers).sqrt());
            assert_close(found.throughput, root, 1e-9, &format!("N = {customers}, a = {think}"));
        }
    }
}

#[test]
fn many_customers_wait_as_in_open_queues() {
    for utilisation in [0.1, 0.5, 0.9] {
        // A burst of exponential requests is one service of Erlang's distribution.
        for (variability, burst, factor) in
            [(1.0, 1.0, 1.0), (0.0, 1.0, 0.5), (3.0, 1.0, 2.0), (1.0, 4.0, 0.625)]
        {
            let station = Station { variability, burst, ..Station::single("dram", 1.0) };
            let found = solved(1e9, 1e9 / utilisation, vec![station]);
            // Pollaczek and Khinchine.
            let expected = factor * utilisation / (1.0 - utilisation);
            assert_close(found.stations[0].queueing, expected, 1e-6, &format!("rho = {utilisation}"));
        }
    }
}

#[test]
fn many_servers_wait_about_as_erlang_says() {
    for servers in [2u32, 8, 32] {
        for utilisation in [0.5, 0.7, 0.9] {
            let station = Station { servers, ..Station::single("slots", 1.0) };
            let found = solved(1e9, 1e9 / (utilisation * f64::from(servers)), vec![station]);
            let load = utilisation * f64::from(servers);
            let blocked = (1..=servers).fold(1.0, |b, m| load * b / (f64::from(m) + load * b));
            let waits = blocked / (1.0 - utilisation * (1.0 - blocked));
            let expected = waits / (f64::from(servers) * (1.0 - utilisation));
            let error = (found.stations[0].queueing - expected).abs();
            // Of a service, which is 1.
            assert!(error <= 0.04, "{servers} servers at {utilisation}: off by {error} of a service");
        }
    }
}

#[test]
fn a_lone_customer_waits_for_nobody_and_its_headroom_keeps_its_digits() {
    for think in [1e-15, 1e-9, 1.0, 1e9] {
        let found = solved(1.0, think, vec![Station::single("issue", 1.0)]);
        assert_close(found.stations[0].headroom, think / (1.0 + think), 1e-14, &format!("a = {think}"));
        assert_eq!(found.stations[0].queueing, 0.0);
    }
}

#[test]
fn a_station_that_nothing_else_delays_is_saturated_exactly() {
    for customers in [1.0, 1.5, 64.0, 1e6] {
        for variability in [0.0, 1.0, 4.0] {
            let found = solved(customers, 0.0, vec![Station { variability, ..Station::single("dram", 2.0) }]);
            assert_eq!((found.throughput, found.stations[0].headroom), (0.5, 0.0));
            assert_close(found.cycle_time, 2.0 * customers, 1e-15, "everyone waits for everyone");
        }
    }
}

#[test]
fn headroom_far_below_the_rounding_of_utilisation_is_right() {
    let customers = 1e6;
    for ratio in [1e-4, 1e-6, 1e-9] {
        let stations = vec![Station::single("dram", 1.0), Station::single("l2", ratio)];
        let found = solved(customers, 0.0, stations);
        let seen = (customers - 1.0) / customers;
        let elsewhere = ratio / (1.0 - seen * ratio);
        let expected = elsewhere / (customers * (customers - seen * elsewhere));
        assert_eq!(found.stations[0].utilisation, 1.0);
        assert_close(found.stations[0].headroom, expected, 1e-12, &format!("ratio {ratio}"));
    }
}

#[test]
fn equal_stations_share_the_customers() {
    for (count, customers) in [(2u32, 3.0), (5, 64.0), (12, 1e6)] {
        let stations = vec![Station::single("bank", 1.0); count as usize];
        let found = solved(customers, 0.0, stations);
        assert_close(
            found.throughput,
            customers / (f64::from(count) + customers - 1.0),
            1e-14,
            "balanced network",
        );
    }
}

#[test]
fn as_many_servers_as_customers_make_a_delay_and_one_less_does_not() {
    let with = |servers| solved(16.0, 1.0, vec![Station { servers, ..Station::single("slots", 3.0) }]);
    assert_close(with(16).throughput, 4.0, 1e-15, "nobody waits");
    assert_eq!(with(16).stations[0].queueing, 0.0);
    assert!(with(15).stations[0].queueing > 0.0);
    assert!(with(15).throughput < 4.0 && with(15).throughput > 3.8);
}

#[test]
fn a_burst_spreads_over_the_servers_and_ends_with_its_last_request() {
    let alone = |servers, burst| {
        let station = Station { servers, burst, ..Station::single("banks", 8.0) };
        solved(1.0, 0.0, vec![station]).cycle_time
    };
    assert_close(alone(1, 8.0), 8.0, 1e-15, "one server takes one after another");
    assert_close(alone(4, 1.0), 8.0, 1e-15, "single requests use one server");
    assert_close(alone(7, 8.0), 2.0, 1e-15, "seven at once, then the eighth");
    assert_close(alone(4, 8.0), 2.75, 1e-15, "the envelope of two rounds and what is left of a third");
}

#[test]
fn networks_that_share_their_only_station_are_one_network_with_all_their_customers() {
    for (customers, sharers) in [(1.0, 2), (8.0, 4), (16.0, 24)] {
        for (servers, burst) in [(1, 1.0), (4, 1.0), (2, 8.0)] {
            let own = Station { servers, burst, ..Station::single("dram", 3.0) };
            let shared = solved(customers, 5.0, vec![Station { sharers, ..own }]);
            let together = solved(customers * f64::from(sharers), 5.0, vec![own]);
            assert_close(shared.throughput * f64::from(sharers), together.throughput, 1e-12, "throughput");
            assert_close(shared.cycle_time, together.cycle_time, 1e-12, "cycle time");
        }
    }
}
