//! The balance of customers as a function of one number, and its root.
//!
//! The unknown is `v = u / ρ` of the station that is busiest per cycle: the odds of finding a server of it idle. Unlike `u`
//! it keeps its digits when the station is nearly idle, and unlike `ρ` when it is nearly saturated. Customers missing from
//! the busiest station are counted as such, never as `N - Q`, so that the balance is a difference of two sums of positive
//! terms, and its root as exact as those.

use super::network::{Network, Station};

/// A station with demand, in units of the demand per server of the busiest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    /// Utilisation over that of the busiest station, in `(0, 1]`.
    share: f64,
    /// Odds of idleness when the busiest station is saturated.
    idle: f64,
    /// Customers in service at once at full load, `c`.
    in_service: f64,
    /// `s - 1`.
    exponent: f64,
    /// `φ`.
    residual: f64,
    /// `M`; nobody waits unless it is above 1.
    population: f64,
    /// Part of the customers here that is this network's.
    ours: f64,
}

/// What a [`Term`] comes to at some throughput.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    /// `ρ`.
    pub(super) utilisation: f64,
    /// `1 - ρ`.
    pub(super) headroom: f64,
    /// Mean number of customers in service.
    pub(super) served: f64,
    /// Mean number of customers waiting.
    pub(super) waiting: f64,
}

impl Term {
    /// The term of a station whose demand is not 0, where `busiest` is the largest demand per server.
    pub(super) fn new(station: &Station, customers: f64, busiest: f64) -> Self {
        let (per_server, sharers) = (station.per_server(), f64::from(station.sharers));
        let in_service = 1.0 + f64::from(station.servers - 1) / station.burst;
        Self {
            share: per_server / busiest,
            idle: (busiest - per_server) / per_server,
            in_service,
            exponent: if station.servers == 1 { 1.0 } else { (2.0 * (in_service + 1.0)).sqrt() - 1.0 },
            residual: 0.5 * (1.0 + station.variability / station.burst),
            population: customers * sharers - in_service + 1.0,
            ours: 1.0 / sharers,
        }
    }

    /// Odds of idleness when those of the busiest station are `odds`.
    fn odds(&self, odds: f64) -> f64 {
        self.idle * (1.0 + odds) + odds
    }

    fn waits(&self) -> bool {
        self.population > 1.0
    }

    /// Customers of this network in service.
    fn served(&self, utilisation: f64) -> f64 {
        self.ours * self.in_service * utilisation
    }

    /// `ρ^(s-1)`.
    fn power(&self, utilisation: f64) -> f64 {
        if self.exponent == 1.0 { utilisation } else { utilisation.powf(self.exponent) }
    }

    fn waiting(&self, utilisation: f64, odds: f64) -> f64 {
        if !self.waits() {
            return 0.0;
        }
        let bound = self.population - 1.0;
        self.ours * self.residual * self.power(utilisation) * bound / (self.population * odds + self.residual)
    }

    /// Rate at which [`Term::waiting`] falls with `ln(1 + v)`.
    fn waiting_slope(&self, waiting: f64, odds: f64, spread: f64) -> f64 {
        let steepness =
            self.population * (1.0 + self.idle) * spread / (self.population * odds + self.residual);
        if self.waits() { waiting * (self.exponent + steepness) } else { 0.0 }
    }

    pub(super) fn load(&self, odds: f64) -> Load {
        let own_odds = self.odds(odds);
        let utilisation = self.share / (1.0 + odds);
        Load {
            utilisation,
            headroom: own_odds / (1.0 + own_odds),
            served: self.served(utilisation),
            waiting: self.waiting(utilisation, own_odds),
        }
    }

    /// `N - Q` of the busiest station, if `N >= c`, from what is missing in service and what is missing in the queue.
    fn missing(&self, headroom: f64, odds: f64) -> f64 {
        let unpowered =
            if self.exponent == 1.0 { headroom } else { -(-self.exponent * odds.ln_1p()).exp_m1() };
        let lack =
            (self.population * odds + self.residual * unpowered) / (self.population * odds + self.residual);
        self.ours * (self.in_service * headroom + (self.population - 1.0) * lack)
    }
}

/// The customers elsewhere against the customers missing from the busiest station.
#[derive(Debug)]
pub(super) struct Balance<'a> {
    customers: f64,
    /// Think time over the busiest demand per server, and what all but the busiest station have in service at full load.
    delays: f64,
    busiest: Term,
    others: &'a [Term],
}

/// A root and what it took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) odds: f64,
    pub(super) evaluations: u32,
}

/// Evaluations before bisection takes over, above twice what any tested network needs.
const MOST_STEPS: u32 = 32;
/// Imbalance that is only rounding, relative to the customers elsewhere.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

impl<'a> Balance<'a> {
    /// The balance of stations with demand, whose first is the busiest. `think` is in units of its demand per server.
    pub(super) fn new(customers: f64, think: f64, busiest: Term, others: &'a [Term]) -> Self {
        let delays = think + others.iter().map(|term| term.served(term.share)).sum::<f64>();
        Self { customers, delays, busiest, others }
    }

    /// Customers elsewhere, customers missing here, and the slope of the sum of all customers in the odds.
    fn at(&self, odds: f64) -> (f64, f64, f64) {
        let spread = 1.0 + odds;
        let utilisation = 1.0 / spread;
        let mut elsewhere = self.delays * utilisation;
        let mut slope = (self.delays + self.busiest.served(1.0)) * utilisation;
        for term in self.others {
            let own_odds = term.odds(odds);
            let waiting = term.waiting(term.share * utilisation, own_odds);
            elsewhere += waiting;
            slope += term.waiting_slope(waiting, own_odds, spread);
        }
        slope += self.busiest.waiting_slope(self.busiest.waiting(utilisation, odds), odds, spread);
        let missing = if self.busiest.population >= 1.0 {
            self.busiest.missing(odds * utilisation, odds)
        } else {
            elsewhere += self.busiest.served(utilisation);
            self.customers
        };
        (elsewhere, missing, -slope * utilisation)
    }

    /// Odds that are surely too low and odds that are surely too high: nobody waits, and everybody waits everywhere.
    fn bracket(&self, think: f64) -> (f64, f64) {
        let lack = self.busiest.served(1.0) - self.customers;
        let queued: f64 =
            self.others.iter().map(|term| term.share * term.served(1.0).max(self.customers)).sum();
        let low = (self.delays + lack) / self.customers;
        let high = (think + queued + lack.max(0.0)) / self.customers;
        (low.max(0.0) * (1.0 - 1e-9), high.max(low) * (1.0 + 1e-9) + f64::MIN_POSITIVE)
    }

    /// The odds at which customers elsewhere and customers missing are equal.
    ///
    /// Steps by the slope of the reciprocal, which is straight where the network is far from saturation and where it is
    /// near; a step out of the bracket is replaced by its middle. After [`MOST_STEPS`] the bracket is halved over the
    /// floats in it, in order, which ends at two neighbours after at most 64 halvings. So there are at most 96 evaluations.
    pub(super) fn root(&self, think: f64) -> Root {
        self.root_stepping(think, MOST_STEPS)
    }

    fn root_stepping(&self, think: f64, most_steps: u32) -> Root {
        let (mut low, mut high) = self.bracket(think);
        let mut odds = low;
        let mut evaluations = 0;
        loop {
            let (elsewhere, missing, slope) = self.at(odds);
            evaluations += 1;
            let excess = elsewhere - missing;
            if excess.abs() <= ROUNDING * elsewhere {
                break;
            }
            if excess > 0.0 {
                low = low.max(odds);
            } else {
                high = high.min(odds);
            }
            let middle = f64::from_bits(low.to_bits().midpoint(high.to_bits()));
            if middle == low || middle == high {
                break;
            }
            let step = -excess * (1.0 + excess / self.customers) / slope;
            let next = odds + step;
            odds = if evaluations < most_steps && low < next && next < high { next } else { middle };
        }
        Root { odds, evaluations }
    }
}

/// The largest demand per server of a network and the station's place, if any station has demand.
pub(super) fn busiest(network: &Network) -> Option<(usize, f64)> {
    let per_server = network.stations.iter().map(Station::per_server);
    per_server
        .enumerate()
        .filter(|(_, time)| *time > 0.0)
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bisection_alone_finds_the_same_root_in_time() {
        let mut most = 0;
        for customers in [1.0, 2.0, 63.5, 1e6] {
            for think in [0.0, 1e-9, 1.0, 1e9, customers] {
                for (servers, ratio) in [(1, 1.0), (1, 1e-9), (16, 0.5), (64, 1e-3)] {
                    let first = Station { servers, ..Station::single("first", f64::from(servers)) };
                    let second = Station { variability: 0.0, ..Station::single("second", ratio) };
                    let others = [Term::new(&second, customers, 1.0)];
                    let balance = Balance::new(customers, think, Term::new(&first, customers, 1.0), &others);
                    let (stepped, halved) = (balance.root(think), balance.root_stepping(think, 0));
                    let (found, expected) =
                        (stepped.odds / (1.0 + stepped.odds), halved.odds / (1.0 + halved.odds));
                    assert!((found - expected).abs() <= 1e-13, "{balance:?}: {stepped:?} and {halved:?}");
                    most = most.max(halved.evaluations);
                }
            }
        }
        assert!((32..=64).contains(&most), "{most} evaluations");
    }
}
