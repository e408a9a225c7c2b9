//! The solver of closed queueing networks at the ends of its ranges.
//!
//! It is stiff where a station is nearly saturated: the headroom `1 - utilisation` is a small difference of large sums. The solver takes
//! the odds of idleness as its unknown, counts missing customers instead of present ones, and brackets the root
//! ([`gpumodel::queueing`]); here that is held against a closed form that has no cancellation either.

use crate::Size;
use crate::case::{Case, Limit};
use crate::random::Random;
use crate::structures::Watch;
use gpumodel::queueing::{Network, Solution, Station, solve};

/// Rounding of a solution: some units in the last place.
const ROUNDING: f64 = 1e-13;

/// Roundings of the balance at which the search for its root ends.
const ENDING: f64 = 32.0;

/// Evaluations after which bisection over the floats of a bracket has ended, 32 other steps included.
const MOST_EVALUATIONS: f64 = 96.0;

pub(crate) fn cases(size: Size, _: &Watch) -> Vec<Case> {
    let mut cases = vec![saturation(), populations()];
    cases.extend(decades(size));
    cases.push(rescaled(size));
    cases
}

fn solved(network: &Network) -> Solution {
    solve(network).expect("the network is within its limits")
}

/// `1 - utilisation` of one exponential station of service time 1, `customers` and think time `think`: the root of
/// `a m u^2 + (N + a - 2 a m) u - a/N = 0` with `m = (N-1)/N`, written without cancellation.
fn headroom(customers: f64, think: f64) -> f64 {
    let (n, a) = (customers, think);
    let m = (n - 1.0) / n;
    let b = n - a + 2.0 * a / n;
    let root = (b * b + 4.0 * a * m * a / n).sqrt();
    if b >= 0.0 { 2.0 * (a / n) / (b + root) } else { (root - b) / (2.0 * a * m) }
}

/// By how much more than its numbers, relatively, the headroom changes with them: it is a small difference of customers and think time
/// where these are nearly equal.
fn condition(customers: f64, think: f64) -> f64 {
    const STEP: f64 = 1e-6;
    let at = headroom(customers, think);
    let change = |changed: f64| (changed / at - 1.0).abs() / STEP;
    change(headroom(customers * (1.0 + STEP), think)) + change(headroom(customers, think * (1.0 + STEP)))
}

fn saturation() -> Case {
    let (mut units, mut worst, mut residual) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut least, mut hardest) = (1.0_f64, 1.0_f64);
    for step in 0..=60 {
        let customers = 10.0_f64.powf(1.0 + 0.1 * f64::from(step));
        for share in [1e-6, 1e-3, 0.1, 0.5, 0.9, 0.99, 1.0, 1.01, 2.0, 10.0] {
            let think = customers * share;
            let network =
                Network { customers, think_time: think, stations: vec![Station::single("station", 1.0)] };
            let found = solved(&network);
            let expected = headroom(customers, think);
            let error = (found.stations[0].headroom / expected - 1.0).abs();
            let condition = condition(customers, think).max(1.0);
            units = units.max(error / (f64::EPSILON * condition));
            worst = worst.max(error);
            residual = residual.max(found.residual);
            least = least.min(expected);
            hardest = hardest.max(condition);
        }
    }
    Case::new(
        "solver/saturation",
        "headroom of a station up to a utilisation of 1 - 1e-12 and beyond, against the closed form: the error is the rounding that ends \
         the search, times the condition",
        "roundings",
        Limit::AtMost(ENDING),
        units,
    )
    .under("condition of the headroom", hardest)
    .with_residual(residual)
    .because(format!("bracketed on the odds of idleness; least headroom {least:.1e}, largest relative error {worst:.1e}"))
}

/// From one warp to a million.
fn populations() -> Case {
    let stations = || {
        vec![
            Station { variability: 0.0, ..Station::single("port", 3e-9) },
            Station { servers: 4, burst: 8.0, ..Station::single("cache", 1e-9) },
            Station { sharers: 4, ..Station::single("memory", 2e-9) },
        ]
    };
    let (mut slower, mut residual, mut most) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut before: Option<Solution> = None;
    for step in 0..=600 {
        let customers = 10.0_f64.powf(0.01 * f64::from(step));
        let found = solved(&Network { customers, think_time: 1e-6, stations: stations() });
        if let Some(before) = &before {
            slower = slower.max(1.0 - found.throughput / before.throughput);
            slower = slower.max(1.0 - found.cycle_time / before.cycle_time);
        }
        residual = residual.max(found.residual);
        most = found.stations.iter().map(|station| station.utilisation).fold(most, f64::max);
        before = Some(found);
    }
    Case::new(
        "solver/warps",
        "from one warp to a million neither throughput nor the time of a cycle falls",
        "relative fall",
        Limit::AtMost(ROUNDING),
        slower,
    )
    .under("largest utilisation", most)
    .with_residual(residual)
}

/// A network whose times and rates are spread over 18 decades.
fn spread(random: &mut Random) -> Network {
    let mut station = |name| Station {
        demand: random.log_uniform(1e-18, 1.0),
        servers: 1 << random.below(7),
        variability: [0.0, 0.5, 1.0, 4.0][random.below(4)],
        burst: [1.0, 4.0, 64.0][random.below(3)],
        sharers: 1 << random.below(5),
        name,
    };
    let stations = vec![station("alu"), station("cache"), station("memory")];
    let think_time = random.log_uniform(1e-18, 1.0);
    Network { customers: random.log_uniform(1.0, 1e6), think_time, stations }
}

/// Networks of which nothing is near anything else.
fn decades(size: Size) -> [Case; 4] {
    let networks = size.of(500, 20_000);
    let mut random = Random(18);
    let (mut residual, mut evaluations, mut odd, mut slower, mut beyond) = (0.0_f64, 0, 0, 0.0_f64, 0.0_f64);
    let mut condition = 1.0_f64;
    for _ in 0..networks {
        let network = spread(&mut random);
        let found = solved(&network);
        residual = residual.max(found.residual);
        evaluations = evaluations.max(found.evaluations);
        let numbers =
            found.stations.iter().flat_map(|s| [s.service, s.queueing, s.queue, s.utilisation, s.headroom]);
        odd += numbers
            .chain([found.throughput, found.cycle_time])
            .filter(|x| !x.is_finite() || *x < 0.0)
            .count();
        let least = found.stations.iter().map(|station| station.headroom).fold(1.0, f64::min);
        condition = condition.max(1.0 / least.max(f64::MIN_POSITIVE));
        beyond = beyond.max(found.throughput / bound(&network) - 1.0);
        for faster in better(&network) {
            slower = slower.max(1.0 - solved(&faster).throughput / found.throughput);
        }
    }
    let of = |case: Case| case.under("1 / headroom", condition).with_residual(residual);
    [
        of(Case::none_of(
            "solver/finite",
            "networks with times over 18 decades: every time, queue and rate is a number of at least 0",
            "numbers",
            odd as u64,
        )),
        of(Case::new(
            "solver/residual",
            "networks with times over 18 decades: customers in the solution against customers given",
            "relative residual",
            Limit::AtMost(ROUNDING),
            residual,
        )),
        of(Case::new(
            "solver/monotone",
            "networks with times over 18 decades: anything faster, by 10 or by 1e-12, lowers the throughput by no more than rounding",
            "relative fall",
            Limit::AtMost(ROUNDING),
            slower.max(beyond),
        )
        .because(format!("above its asymptotic bound by {beyond:.1e} at most"))),
        of(Case::new(
            "solver/evaluations",
            "networks with times over 18 decades: evaluations until the root is found",
            "evaluations",
            Limit::AtMost(MOST_EVALUATIONS),
            f64::from(evaluations),
        )),
    ]
}

/// The larger of no throughput that a network can have: a station's capacity, and a cycle that waits for nobody.
fn bound(network: &Network) -> f64 {
    let capacity =
        |station: &Station| f64::from(station.servers) / (station.demand * f64::from(station.sharers));
    let alone = |station: &Station| {
        station.demand / station.burst * (1.0 + (station.burst - 1.0) / f64::from(station.servers))
    };
    let unqueued = network.think_time + network.stations.iter().map(alone).sum::<f64>();
    network.stations.iter().map(capacity).fold(network.customers / unqueued, f64::min)
}

/// The network with one time shorter, by much or by hardly anything.
fn better(network: &Network) -> Vec<Network> {
    let mut faster = Vec::new();
    for factor in [0.1, 1.0 - 1e-12] {
        faster.push(Network { think_time: network.think_time * factor, ..network.clone() });
        for place in 0..network.stations.len() {
            let mut with = network.clone();
            with.stations[place].demand *= factor;
            faster.push(with);
        }
    }
    faster
}

/// All times twice as long: half the throughput, to the bit.
fn rescaled(size: Size) -> Case {
    let mut random = Random(2);
    let mut differing = 0;
    for _ in 0..size.of(500, 5000) {
        let network = spread(&mut random);
        let mut slow = network.clone();
        slow.think_time *= 2.0;
        slow.stations.iter_mut().for_each(|station| station.demand *= 2.0);
        differing += u64::from(2.0 * solved(&slow).throughput != solved(&network).throughput);
    }
    Case::none_of(
        "solver/rescaled",
        "twice every time gives half the throughput, bit by bit",
        "networks",
        differing,
    )
}
