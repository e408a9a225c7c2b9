//! Confidence intervals of counters from the replicates of a sample.

use crate::counters::{COUNTERS, CounterInfo, CounterSet, Pass, Value};
use crate::estimate::{Estimate, PassEstimate};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Share of samples whose intervals hold what they estimate.
const CONFIDENCE: f64 = 0.95;

/// Confidence intervals of 95 % of all counters.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    frame: Vec<Option<[f64; 2]>>,
    passes: Vec<(Pass, Vec<Option<[f64; 2]>>)>,
}

impl Intervals {
    /// `others` are the estimates if warmer caches had done other things that they might.
    pub(super) fn new(whole: &Estimate, others: &[Estimate], replicates: &[Estimate]) -> Self {
        let of = |counters: &dyn Fn(&Estimate) -> &CounterSet| {
            let all =
                |estimates: &[Estimate]| estimates.iter().map(|of| counters(of).clone()).collect::<Vec<_>>();
            intervals(counters(whole), &all(others), &all(replicates))
        };
        let passes = whole.passes.iter().enumerate();
        let of_pass = |(place, pass): (usize, &PassEstimate)| {
            (pass.pass, of(&|estimate| &estimate.passes[place].counters))
        };
        Self { frame: of(&|estimate| &estimate.frame), passes: passes.map(of_pass).collect() }
    }

    /// Of a counter of the frame; both ends are the same where it is exact, and there is none where the frame does not have it.
    pub fn of_frame(&self, id: &str) -> Option<[f64; 2]> {
        of(&self.frame, id)
    }

    /// Of a counter of a pass.
    pub fn of_pass(&self, pass: Pass, id: &str) -> Option<[f64; 2]> {
        let found = self.passes.iter().find(|(of, _)| *of == pass);
        found.and_then(|(_, intervals)| of(intervals, id))
    }
}

fn of(intervals: &[Option<[f64; 2]>], id: &str) -> Option<[f64; 2]> {
    let place = COUNTERS.iter().position(|counter| counter.id == id)?;
    intervals[place]
}

fn intervals(whole: &CounterSet, others: &[CounterSet], replicates: &[CounterSet]) -> Vec<Option<[f64; 2]>> {
    // Of each stratum there are two.
    let quantile = quantile(replicates.len() / 2);
    let of_counter = |(info, value): (&CounterInfo, &Value)| {
        let value = value.number()?;
        let numbers = |sets: &[CounterSet]| -> Vec<f64> {
            sets.iter().filter_map(|set| set.get(info.id).and_then(Value::number)).collect()
        };
        let squares = numbers(replicates).into_iter().map(|replicate| (replicate - value).powi(2));
        let error = (squares.sum::<f64>() / 2.0).sqrt();
        let half = if error > 0.0 { quantile * error } else { 0.0 };
        let [mut least, mut most] = [value; 2];
        for other in numbers(others) {
            (least, most) = (least.min(other), most.max(other));
        }
        Some([(least - half).max(0.0), most + half])
    };
    whole.iter().map(of_counter).collect()
}

/// Of Student's t, for as many degrees of freedom as there are strata.
fn quantile(strata: usize) -> f64 {
    let distribution = StudentsT::new(0.0, 1.0, strata as f64);
    distribution.map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + CONFIDENCE / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables_and_nothing_is_known_without_strata() {
        for (strata, expected) in [(4, 2.776), (8, 2.306), (16, 2.120)] {
            assert!((quantile(strata) - expected).abs() < 5e-4);
        }
        assert_eq!(quantile(0), f64::INFINITY);
    }
}
