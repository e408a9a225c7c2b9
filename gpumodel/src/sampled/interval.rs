//! Confidence intervals of counters from the replicates of a sample.

use crate::counters::{COUNTERS, CounterSet, Pass, Value};
use crate::estimate::Estimate;
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
    /// `other` is the estimate if the cold caches of the sample did the other thing of what they might.
    pub(super) fn new(whole: &Estimate, other: &Estimate, replicates: &[Estimate]) -> Self {
        let sets: Vec<&CounterSet> = replicates.iter().map(|replicate| &replicate.frame).collect();
        let passes = whole.passes.iter().enumerate().map(|(place, pass)| {
            let sets: Vec<_> = replicates.iter().map(|replicate| &replicate.passes[place].counters).collect();
            (pass.pass, intervals(&pass.counters, &other.passes[place].counters, &sets))
        });
        Self { frame: intervals(&whole.frame, &other.frame, &sets), passes: passes.collect() }
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

fn intervals(whole: &CounterSet, other: &CounterSet, replicates: &[&CounterSet]) -> Vec<Option<[f64; 2]>> {
    let quantile = quantile(replicates.len());
    let mut replicates: Vec<_> = replicates.iter().map(|set| set.iter()).collect();
    let of_counter = |((_, value), (_, other)): ((_, &Value), (_, &Value))| {
        let of_replicates: Vec<Option<f64>> =
            replicates.iter_mut().map(|set| set.next().and_then(|(_, value)| value.number())).collect();
        let (value, other) = (value.number()?, other.number()?);
        let square = |replicate: Option<f64>| replicate.map_or(0.0, |replicate| (replicate - value).powi(2));
        let squares = of_replicates.into_iter().map(square);
        let half = quantile * squares.sum::<f64>().sqrt();
        Some([(value.min(other) - half).max(0.0), value.max(other) + half])
    };
    whole.iter().zip(other.iter()).map(of_counter).collect()
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
