//! What a network asks of its stations, and what is refused.

/// Customers that cycle through a pure delay and some stations.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// How many customers there are, all alike, from 1 to [`Network::MOST_CUSTOMERS`]. May be fractional, as a mean is.
    pub customers: f64,
    /// Seconds of a cycle that a customer spends waiting for nobody: latency and computation that nothing else delays.
    pub think_time: f64,
    /// Where customers queue. A customer visits all of them in each cycle; the order does not matter.
    pub stations: Vec<Station>,
}

/// A place with one queue and some equal servers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// What errors and reports call it.
    pub name: &'static str,
    /// Seconds of server time that one cycle of a customer needs here: service time of a request, times all requests of
    /// the cycle. So `servers / demand` cycles per second are the station's capacity. 0 if the cycle does not come here.
    pub demand: f64,
    /// Servers that work at the same time, each on one request. At least 1.
    pub servers: u32,
    /// Squared coefficient of variation of the service time of a request: 0 if always the same, 1 if exponential.
    pub variability: f64,
    /// Requests that arrive together, at least 1. They share the `demand` of the cycle, occupy several servers where there
    /// are several, and the customer goes on when the last of them is done.
    pub burst: f64,
    /// Networks like this one whose customers all come here, this one included. At least 1: one that the others do not share.
    pub sharers: u32,
}

impl Network {
    /// The largest population: beyond it, one customer more could not be told in an `f64`.
    pub const MOST_CUSTOMERS: f64 = 1e15;
    /// The shortest demand or think time above 0, in seconds. With [`Network::LONGEST_TIME`] it keeps all ratios finite.
    pub const SHORTEST_TIME: f64 = 1e-60;
    /// The longest demand or think time, in seconds.
    pub const LONGEST_TIME: f64 = 1e60;

    /// Whether every number is in its range and a cycle takes any time at all.
    pub(super) fn check(&self) -> Result<(), NetworkError> {
        if !(1.0..=Self::MOST_CUSTOMERS).contains(&self.customers) {
            return Err(NetworkError::Customers(self.customers));
        }
        if !is_time(self.think_time) {
            return Err(NetworkError::ThinkTime(self.think_time));
        }
        for station in &self.stations {
            station.check()?;
        }
        if self.think_time <= 0.0 && self.stations.iter().all(|station| station.demand <= 0.0) {
            return Err(NetworkError::NoTime);
        }
        Ok(())
    }
}

impl Station {
    /// A station with one server, exponential service and single requests.
    pub fn single(name: &'static str, demand: f64) -> Self {
        Self { name, demand, servers: 1, variability: 1.0, burst: 1.0, sharers: 1 }
    }

    /// Time that a cycle of each sharer keeps one server busy, if all servers work.
    pub(super) fn per_server(&self) -> f64 {
        self.demand * f64::from(self.sharers) / f64::from(self.servers)
    }

    fn check(&self) -> Result<(), NetworkError> {
        let station = self.name;
        if !is_time(self.demand) {
            return Err(NetworkError::Demand { station, value: self.demand });
        }
        if self.servers == 0 {
            return Err(NetworkError::Servers { station });
        }
        if self.sharers == 0 {
            return Err(NetworkError::Sharers { station });
        }
        if !(0.0..=Network::LONGEST_TIME).contains(&self.variability) {
            return Err(NetworkError::Variability { station, value: self.variability });
        }
        if !(1.0..=Network::MOST_CUSTOMERS).contains(&self.burst) {
            return Err(NetworkError::Burst { station, value: self.burst });
        }
        Ok(())
    }
}

fn is_time(seconds: f64) -> bool {
    seconds == 0.0 || (Network::SHORTEST_TIME..=Network::LONGEST_TIME).contains(&seconds)
}

/// Why a network has no solution. Messages name the field, what was expected and the remedy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// `customers` is out of range.
    #[error("customers = {0}: expected 1 to {most:e}; give at least one customer", most = Network::MOST_CUSTOMERS)]
    Customers(f64),
    /// `think_time` is out of range.
    #[error("think_time = {0} s: expected {EXPECTED_TIME}; give the delay in seconds")]
    ThinkTime(f64),
    /// A station's `demand` is out of range.
    #[error(
        "station '{station}': demand = {value} s: expected {EXPECTED_TIME}; give the service time of a cycle in seconds"
    )]
    Demand {
        /// The station's name.
        station: &'static str,
        /// What was given.
        value: f64,
    },
    /// A station has no server.
    #[error("station '{station}': servers = 0: expected at least 1; leave a station out by a demand of 0")]
    Servers {
        /// The station's name.
        station: &'static str,
    },
    /// Nobody shares a station, not even its own network.
    #[error(
        "station '{station}': sharers = 0: expected at least 1; give 1 where no other network comes here"
    )]
    Sharers {
        /// The station's name.
        station: &'static str,
    },
    /// A station's `variability` is out of range.
    #[error(
        "station '{station}': variability = {value}: expected 0 to 1e60; give 0 for constant service, 1 for exponential"
    )]
    Variability {
        /// The station's name.
        station: &'static str,
        /// What was given.
        value: f64,
    },
    /// A station's `burst` is out of range.
    #[error(
        "station '{station}': burst = {value}: expected 1 to 1e15; give 1 where requests come one by one"
    )]
    Burst {
        /// The station's name.
        station: &'static str,
        /// What was given.
        value: f64,
    },
    /// Nothing in a cycle takes time, so its rate has no limit.
    #[error("think_time and every demand are 0: a cycle would take no time; give one of them a time")]
    NoTime,
}

const EXPECTED_TIME: &str = "0 or 1e-60 to 1e60";
