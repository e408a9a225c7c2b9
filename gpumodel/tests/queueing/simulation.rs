//! A closed network played out, customer by customer.

use crate::random::Random;
use gpumodel::queueing::Network;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cycles in all; the first fifth only warms up.
const CYCLES: usize = 100_000;

/// Throughput with an exponential delay, then each station in turn, first come first served. Service is constant where
/// `variability` is 0, else exponential; bursts are whole.
pub(crate) fn simulate(network: &Network, random: &mut Random) -> f64 {
    let mut free: Vec<Vec<f64>> =
        network.stations.iter().map(|station| vec![0.0; station.servers as usize]).collect();
    // Times are positive, so their bits are ordered as they are.
    let mut events = BinaryHeap::new();
    for customer in 0..network.customers as usize {
        events.push(Reverse(((network.think_time * random.exponential()).to_bits(), customer, 0)));
    }
    let (mut cycles, mut warm, mut now) = (0, 0.0, 0.0);
    while cycles < CYCLES {
        let Reverse((bits, customer, place)) = events.pop().expect("customers never leave");
        now = f64::from_bits(bits);
        let Some(station) = network.stations.get(place) else {
            cycles += 1;
            if cycles == CYCLES / 5 {
                warm = now;
            }
            let thought = now + network.think_time * random.exponential();
            events.push(Reverse((thought.to_bits(), customer, 0)));
            continue;
        };
        let service = station.demand / station.burst;
        let mut done = now;
        for _ in 0..station.burst as u32 {
            let server = free[place].iter_mut().min_by(|a, b| a.total_cmp(b)).expect("a station has servers");
            let time = if station.variability > 0.0 { service * random.exponential() } else { service };
            *server = server.max(now) + time;
            done = done.max(*server);
        }
        events.push(Reverse((done.to_bits(), customer, place + 1)));
    }
    (CYCLES - CYCLES / 5) as f64 / (now - warm)
}
