//! A stiff load: a phone whose GPU warms a million times as fast as its case.

use super::WorkPoint;
use crate::Size;
use std::fmt;
use std::time::Instant;
use thermal::{
    BUILTIN, Counts, Error, HeatEquation, Integrator, LeakageLaw, Method, Network, OperatingPoint, Phone,
    State, Steps,
};

/// Ratio of the longest to the shortest time constant.
const STIFFNESS: f64 = 1e6;
/// A load of so many watts, with the instants at which the temperatures are compared, in seconds; the last ends it. The first of each is within the fastest
/// transient: steps of a fixed length may be longer, and are compared only where it is over.
const LOADS: [(f64, [f64; 4]); 2] = [(4.0, [1e-3, 0.1, 10.0, 30.0]), (1.0, [30.001, 30.1, 40.0, 60.0])];
/// Tolerance of the reference, in K.
const FINEST: f64 = 1e-11;
/// Each run is timed as often, or as long, as this.
const MOST_REPEATS: u32 = 20;
const TIMED_SECONDS: f64 = 0.02;

/// A phone and loads on it.
pub(super) struct Problem {
    phone: Phone,
    network: Network,
    reference: Vec<Option<Vec<f64>>>,
}

/// Temperatures at each instant that is compared, and what they cost.
pub(super) type Solved = (Vec<Option<Vec<f64>>>, Counts);

pub(super) fn builtin() -> Phone {
    Phone::parse(BUILTIN, "configs/thermal/phone.toml").expect("the built-in phone is well-formed")
}

/// A load of so many watts at the GPU, and some more at the memory and as leakage.
pub(super) fn load(gpu_watts: f64) -> OperatingPoint {
    let leakage = LeakageLaw { watts: 0.2, celsius: 55.0, per_kelvin: 0.035 };
    OperatingPoint { mhz: 700.0, frames_per_second: 60.0, gpu_watts, dram_watts: 0.5, leakage }
}

impl Problem {
    pub(super) fn stiff() -> Self {
        let phone = builtin();
        let mut network = phone.network.clone();
        // The shortest time constant is nearly proportional to the smallest capacity.
        for _ in 0..16 {
            let constants = network.time_constants();
            let ratio = constants[0] / constants[constants.len() - 1];
            let capacity = network.nodes()[phone.gpu].heat_capacity * ratio / STIFFNESS;
            network = network.with_capacity(phone.gpu, capacity).expect("a capacity above 0");
        }
        let mut problem = Self { phone, network, reference: Vec::new() };
        let (reference, _) =
            problem.solve(Method::Implicit, Steps::Tolerance(FINEST)).expect("an L-stable method solves it");
        problem.reference = reference;
        problem
    }

    pub(super) fn network(&self) -> &Network {
        &self.network
    }

    /// The equation of a load on the stiff network, or on one like it.
    pub(super) fn equation<'a>(&self, network: &'a Network, gpu_watts: f64) -> HeatEquation<'a> {
        HeatEquation { network, ..self.phone.equation(&load(gpu_watts)) }
    }

    pub(super) fn gpu(&self) -> usize {
        self.phone.gpu
    }

    /// Follows the loads.
    pub(super) fn solve(&self, method: Method, steps: Steps) -> Result<Solved, Error> {
        let mut integrator = Integrator::new(method, steps, &self.network)?;
        let mut state = State::cold(&self.network);
        let (mut now, mut found) = (0.0, Vec::new());
        let skipped = usize::from(matches!(steps, Steps::Fixed(_)));
        for (watts, instants) in LOADS {
            let equation = self.equation(&self.network, watts);
            found.extend(std::iter::repeat_n(None, skipped));
            for &instant in &instants[skipped..] {
                integrator.advance(&equation, &mut state, instant - now, &[])?;
                now = instant;
                found.push(Some(state.temperatures().to_vec()));
            }
        }
        Ok((found, integrator.counts()))
    }

    /// Largest difference to the reference, in K.
    pub(super) fn error(&self, found: &[Option<Vec<f64>>]) -> f64 {
        let pairs = found.iter().zip(&self.reference).filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
        let apart =
            |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        pairs.map(apart).fold(0.0, f64::max)
    }

    /// Error and run time of every method at tolerances and at fixed steps, over six decades of each or more.
    pub(super) fn work(&self, size: Size) -> Vec<WorkPoint> {
        let decades = |from: i32, to: i32| (from..=to).map(|power| 10_f64.powi(power));
        let tolerances = decades(-7, -1).map(Steps::Tolerance);
        let lengths = decades(size.of(-3, -4), 2).map(Steps::Fixed);
        let steps: Vec<Steps> = tolerances.chain(lengths).collect();
        let of_method = |method| steps.iter().map(move |&steps| self.point(method, steps));
        Method::ALL.into_iter().flat_map(of_method).collect()
    }

    fn point(&self, method: Method, steps: Steps) -> WorkPoint {
        let begun = Instant::now();
        let mut solved = self.solve(method, steps);
        let mut seconds = begun.elapsed().as_secs_f64();
        for _ in 1..MOST_REPEATS {
            if begun.elapsed().as_secs_f64() > TIMED_SECONDS {
                break;
            }
            let again = Instant::now();
            solved = self.solve(method, steps);
            seconds = seconds.min(again.elapsed().as_secs_f64());
        }
        let taken = solved.as_ref().map_or(0, |(_, counts)| counts.steps + counts.rejected);
        WorkPoint { method, steps, error: solved.ok().map(|(found, _)| self.error(&found)), seconds, taken }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let constants = self.network.time_constants();
        let (longest, shortest) = (constants[0], constants[constants.len() - 1]);
        write!(
            f,
            "{} with time constants from {:.1e} to {:.0} s (ratio {:.0e}), {} s at {} W and {} s at {} W of the GPU, leaking",
            self.phone.name,
            shortest,
            longest,
            longest / shortest,
            LOADS[0].1[3],
            LOADS[0].0,
            LOADS[1].1[3] - LOADS[0].1[3],
            LOADS[1].0
        )
    }
}
