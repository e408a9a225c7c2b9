//! The solved network: rates, queues and what a cycle's time is made of.

use super::balance::{Balance, Load, Term, busiest};
use super::network::{Network, NetworkError};

/// How fast customers cycle, and where they are meanwhile.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Cycles per second, of all customers together.
    pub throughput: f64,
    /// Seconds of one cycle of a customer: the sum of [`Solution::stack`], to the last bit.
    pub cycle_time: f64,
    /// Seconds of [`Network::think_time`].
    pub think_time: f64,
    /// The stations in the order of the network.
    pub stations: Vec<StationLoad>,
    /// What keeps the throughput from being higher.
    pub deciding: Deciding,
    /// `|throughput * cycle_time - customers| / customers`.
    pub residual: f64,
    /// Evaluations of the balance; never more than 96.
    pub evaluations: u32,
}

/// What a station does in the solved network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationLoad {
    /// The station's name.
    pub name: &'static str,
    /// Seconds of a cycle for which the customer's own requests are served, the later of a burst after the earlier.
    pub service: f64,
    /// Seconds of a cycle for which the customer waits for others.
    pub queueing: f64,
    /// Mean number of customers here, waiting or served.
    pub queue: f64,
    /// Busy fraction of the servers, at most 1.
    pub utilisation: f64,
    /// `1 - utilisation`, with all its digits where the utilisation has lost them.
    pub headroom: f64,
}

impl StationLoad {
    /// Seconds of a cycle spent here.
    pub fn response(&self) -> f64 {
        self.service + self.queueing
    }
}

/// The lower of the two asymptotic bounds of throughput.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deciding {
    /// The capacity of the station at this place in the network.
    Station(usize),
    /// The time that a cycle takes without any queueing: too few customers to keep a station busy.
    Latency,
}

/// A part of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The think time.
    Think,
    /// Own service at the station at this place in the network.
    Service(usize),
    /// Waiting for others there.
    Queueing(usize),
}

/// How much of a cycle a part takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The part.
    pub part: Part,
    /// Its seconds.
    pub seconds: f64,
}

impl Solution {
    /// What a cycle is made of: think time, then service and queueing of each station in the order of the network. Adding
    /// the seconds up in this order gives [`Solution::cycle_time`] exactly.
    pub fn stack(&self) -> Vec<Share> {
        let mut shares = vec![Share { part: Part::Think, seconds: self.think_time }];
        for (place, station) in self.stations.iter().enumerate() {
            shares.push(Share { part: Part::Service(place), seconds: station.service });
            shares.push(Share { part: Part::Queueing(place), seconds: station.queueing });
        }
        shares
    }
}

/// Solves a network. The method and its properties are those of [the module](super).
///
/// # Errors
///
/// A number out of its range, or a network whose cycle takes no time.
pub fn solve(network: &Network) -> Result<Solution, NetworkError> {
    network.check()?;
    let customers = network.customers;
    let Some((place, per_server)) = busiest(network) else {
        let stations = network.stations.iter().map(|station| idle(station.name)).collect();
        return Ok(assemble(network, customers / network.think_time, stations, Deciding::Latency, 0));
    };
    let term = |station| Term::new(station, customers, per_server);
    let others: Vec<Term> = (network.stations.iter().enumerate())
        .filter(|(index, station)| *index != place && station.demand > 0.0)
        .map(|(_, station)| term(station))
        .collect();
    let think = network.think_time / per_server;
    let root = Balance::new(customers, think, term(&network.stations[place]), &others).root(think);
    let throughput = 1.0 / ((1.0 + root.odds) * per_server);

    let mut unqueued = network.think_time;
    let stations: Vec<StationLoad> = (network.stations.iter())
        .map(|station| {
            if station.demand <= 0.0 {
                return idle(station.name);
            }
            let Load { utilisation, headroom, served, waiting } = term(station).load(root.odds);
            let time_per_load = station.per_server() / utilisation;
            let service = served * time_per_load;
            unqueued += service;
            StationLoad {
                name: station.name,
                service,
                queueing: waiting * time_per_load,
                queue: served + waiting,
                utilisation,
                headroom,
            }
        })
        .collect();
    let latency_bound = customers * per_server < unqueued;
    let deciding = if latency_bound { Deciding::Latency } else { Deciding::Station(place) };
    Ok(assemble(network, throughput, stations, deciding, root.evaluations))
}

fn idle(name: &'static str) -> StationLoad {
    StationLoad { name, service: 0.0, queueing: 0.0, queue: 0.0, utilisation: 0.0, headroom: 1.0 }
}

fn assemble(
    network: &Network,
    throughput: f64,
    stations: Vec<StationLoad>,
    deciding: Deciding,
    evaluations: u32,
) -> Solution {
    let think_time = network.think_time;
    let mut solution =
        Solution { throughput, cycle_time: 0.0, think_time, stations, deciding, residual: 0.0, evaluations };
    solution.cycle_time = solution.stack().iter().map(|share| share.seconds).sum();
    solution.residual = (throughput * solution.cycle_time / network.customers - 1.0).abs();
    solution
}
