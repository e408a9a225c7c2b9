//! Confidence intervals of counters from the replicates of a sample.

use crate::counters::{COUNTERS, CounterInfo, CounterSet, Pass, Value};
use crate::estimate::{Estimate, PassEstimate};
use crate::sampled::design::Pick;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Share of samples whose intervals hold what they estimate.
const CONFIDENCE: f64 = 0.95;

/// Ratios of two replays that differ in the order of a few accesses differ by this part, at most: so far is the ratio of two samples from
/// that of the frames, beyond what its replicates tell. It was 0.2 % in frame time at worst over changes of layout, order and technique,
/// for Crytek Sponza on Adreno 540, 640 and Mali-G715. Intervals of single counters are so much wider that it does not matter there.
const RATIO_NOISE: f64 = 0.002_5;

/// How many times as large a counter is as that of another variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// 1 where both are 0.
    pub value: f64,
    /// The ends of an interval of 95 %.
    pub ci95: [f64; 2],
}

impl Ratio {
    /// The ratio of two figures; `None` where only the second is 0.
    pub fn of(this: f64, first: f64) -> Option<f64> {
        let ratio = if this == first { 1.0 } else { this / first };
        ratio.is_finite().then_some(ratio)
    }

    /// How far the interval reaches from the value.
    pub fn reach(&self) -> f64 {
        let [low, high] = self.ci95;
        (self.value - low).max(high - self.value)
    }
}

/// What else a sample says of its frame: it tells how far off the frame may be.
pub(super) struct Basis {
    pub(super) picks: Vec<Pick>,
    /// As [`Sampled::represents`](super::Sampled::represents).
    pub(super) represents: bool,
    pub(super) whole: CounterSet,
    /// If warmer caches had done other things that they might.
    pub(super) others: Vec<CounterSet>,
    pub(super) replicates: Vec<CounterSet>,
}

impl Basis {
    /// How many times as large each counter is as that of `first`, a sample of the same blocks: what chance does to both of them cancels.
    /// `None` of other blocks.
    pub(super) fn ratios(&self, first: &Self) -> Option<Vec<Option<Ratio>>> {
        let alike = self.picks == first.picks && self.replicates.len() == first.replicates.len();
        alike.then(|| {
            let of_counter = |info: &CounterInfo| {
                let ratio = |(this, first): (&CounterSet, &CounterSet)| {
                    let number = |set: &CounterSet| set.get(info.id).and_then(Value::number);
                    Ratio::of(number(this)?, number(first)?)
                };
                let all = |these: &[CounterSet], firsts: &[CounterSet]| -> Option<Vec<f64>> {
                    these.iter().zip(firsts).map(ratio).collect()
                };
                let others = all(&self.others, &first.others)?;
                let replicates = all(&self.replicates, &first.replicates)?;
                let value = ratio((&self.whole, &first.whole))?;
                let represents = self.represents && first.represents;
                let [low, high] = if_known(interval(value, &others, &replicates), represents);
                let more = if low < high { RATIO_NOISE * value } else { 0.0 };
                Some(Ratio { value, ci95: [(low - more).max(0.0), high + more] })
            };
            COUNTERS.iter().map(of_counter).collect()
        })
    }
}

/// Confidence intervals of 95 % of all counters.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    frame: Vec<Option<[f64; 2]>>,
    passes: Vec<(Pass, Vec<Option<[f64; 2]>>)>,
}

impl Intervals {
    /// `others`, `replicates` and `represents` as of a [`Basis`].
    pub(super) fn new(
        whole: &Estimate,
        others: &[Estimate],
        replicates: &[Estimate],
        represents: bool,
    ) -> Self {
        let of = |counters: &dyn Fn(&Estimate) -> &CounterSet| {
            let all =
                |estimates: &[Estimate]| estimates.iter().map(|of| counters(of).clone()).collect::<Vec<_>>();
            let known = intervals(counters(whole), &all(others), &all(replicates)).into_iter();
            known.map(|ends| ends.map(|ends| if_known(ends, represents))).collect::<Vec<_>>()
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
    let of_counter = |(info, value): (&CounterInfo, &Value)| {
        let numbers = |sets: &[CounterSet]| -> Vec<f64> {
            sets.iter().filter_map(|set| set.get(info.id).and_then(Value::number)).collect()
        };
        Some(interval(value.number()?, &numbers(others), &numbers(replicates)))
    };
    whole.iter().map(of_counter).collect()
}

/// What is exact stays so; of all else nothing is known from a sample that does not represent its frame.
fn if_known([low, high]: [f64; 2], represents: bool) -> [f64; 2] {
    if represents || low == high { [low, high] } else { [0.0, f64::INFINITY] }
}

/// Of a figure, the figures of other cache states, and those of the replicates.
fn interval(value: f64, others: &[f64], replicates: &[f64]) -> [f64; 2] {
    let squares = replicates.iter().map(|replicate| (replicate - value).powi(2));
    let error = (squares.sum::<f64>() / 2.0).sqrt();
    // Of each stratum there are two.
    let half = if error > 0.0 { quantile(replicates.len() / 2) * error } else { 0.0 };
    let all = || others.iter().copied().chain([value]);
    let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    [(least - half).max(0.0), most + half]
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
