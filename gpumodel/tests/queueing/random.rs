//! Seeded random networks, from ordinary to extreme.

use gpumodel::queueing::{Network, Station};

/// The splitmix64 generator of Steele et al. 2014.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// In `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-53)
    }

    /// One of `0..count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// Between two positive numbers, every ratio alike.
    pub(crate) fn log_uniform(&mut self, least: f64, most: f64) -> f64 {
        (least.ln() + self.unit() * (most / least).ln()).exp().clamp(least, most)
    }

    /// Exponential, mean 1.
    pub(crate) fn exponential(&mut self) -> f64 {
        -(-self.unit()).ln_1p()
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

pub(crate) const NAMES: [&str; 12] =
    ["s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11"];

/// Up to 12 stations whose demands lie up to 1e18 apart, with and without zeros, ties, delays, bursts and many servers.
pub(crate) fn extreme_network(random: &mut Random) -> Network {
    let count = random.pick(&[1, 1, 2, 3, 5, 8, 12, 12]);
    let equal = random.below(5) == 0;
    let narrow = random.below(3) == 0;
    let unit = random.log_uniform(1e-15, 1e3);
    let template = extreme_station(random, unit, narrow);
    let mut stations: Vec<Station> = (0..count)
        .map(|place| {
            let station = if equal { template } else { extreme_station(random, unit, narrow) };
            Station { name: NAMES[place], ..station }
        })
        .collect();
    if random.below(3) == 0 {
        for station in &mut stations {
            *station = Station { servers: 1, variability: 1.0, burst: 1.0, sharers: 1, ..*station };
        }
    }
    let customers = match random.below(4) {
        0 => 1.0,
        1 => 1.0 + random.below(64) as f64,
        2 => random.log_uniform(1.0, 1e6),
        _ => random.pick(&[1.0, 2.0, 63.5, 1e3, 1e6]),
    };
    let mut think_time = match random.below(4) {
        0 => 0.0,
        1 => unit * random.log_uniform(1e-9, 1e9),
        // A delay that leaves the busiest station just short of, at or beyond saturation.
        2 => unit * customers * random.pick(&[1.0 - 1e-12, 1.0, 1.0 + 1e-12, 0.5, 2.0]),
        _ => unit * random.log_uniform(1e-3, 1e3),
    };
    if stations.iter().all(|station| station.demand <= 0.0) && think_time <= 0.0 {
        think_time = unit;
    }
    Network { customers, think_time, stations }
}

fn extreme_station(random: &mut Random, unit: f64, narrow: bool) -> Station {
    let demand = match random.below(8) {
        0 => 0.0,
        1 => unit,
        _ if narrow => unit * random.log_uniform(0.1, 10.0),
        _ => unit * random.log_uniform(1e-9, 1e9),
    };
    let servers = random.pick(&[1, 1, 1, 2, 4, 16, 63, 64]);
    let variability = random.pick(&[0.0, 0.25, 1.0, 1.0]);
    let burst = random.pick(&[1.0, 1.0, 1.5, 8.0, 64.0]);
    let sharers = random.pick(&[1, 1, 1, 2, 6, 24]);
    Station { name: "", demand, servers, variability, burst, sharers }
}

/// Up to 8 stations with demands at most a hundred times apart, single servers.
pub(crate) fn small_network(random: &mut Random) -> Network {
    let count = 1 + random.below(8);
    let spread = random.pick(&[1.0, 2.0, 10.0, 100.0]);
    let stations: Vec<Station> = (0..count)
        .map(|place| Station::single(NAMES[place], random.log_uniform(1.0, 2.0 * spread)))
        .collect();
    let customers = random.pick(&[1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64]) as f64;
    let total: f64 = stations.iter().map(|station| station.demand).sum();
    let think_time = random.pick(&[0.0, 0.0, 0.5, 1.0, 4.0, 16.0, customers]) * total * random.unit();
    Network { customers, think_time, stations }
}
