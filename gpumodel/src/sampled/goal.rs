//! How much is sampled: a part of the frame, as much as an error asks for, or as much as there is time for.

use super::{Sampled, Sampler};
use crate::error::Error;
use std::time::Instant;
use tracer::TileSource;

/// What a sample is to reach.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// About this part of the frame's tiles is replayed.
    Part(f64),
    /// The intervals of these counters reach no further than these parts of them to either side. Of several variants, those of what each
    /// of the others changes do, by these parts of the first one's counters.
    Within(Vec<(String, f64)>),
    /// All is done by then.
    By(Instant),
}

/// What came of it.
pub enum Attempt {
    /// A sample that reaches the goal, by variant.
    Sampled(Vec<Sampled>),
    /// The smallest sample, which does not.
    TooLate(Vec<Sampled>),
    /// The whole frame should be replayed, for this reason.
    Whole(String),
}

/// The pilot's variance is but an estimate: so much larger a sample is taken.
const VARIANCE_MARGIN: f64 = 1.5;
/// Part of the work on a whole frame that one thread does after the others; the work on samples is shared out.
const SERIAL_PART: f64 = 0.65;
/// Part of the time left that is planned with.
const TIME_MARGIN: f64 = 0.7;

impl<S: TileSource> Sampler<'_, S> {
    /// Samples until `goal` is reached, or finds that a sample is of no use. Sizes are settled in stages (Stein 1945): a small sample
    /// tells how large a fresh one has to be, whose size then does not depend on what it finds, so that its intervals hold; should
    /// that be too wide, it tells the size of the next.
    ///
    /// # Errors
    /// As [`replay`](crate::replay).
    pub fn reach(&self, goal: &Goal, seed: u64) -> Result<Attempt, Error> {
        let [smallest, largest] = self.parts();
        if smallest > largest {
            let tiles = self.source.header().frame.tiles();
            return Ok(Attempt::Whole(format!("the frame's {tiles} tiles are too few for a sample of them")));
        }
        match goal {
            &Goal::Part(part) => Ok(Attempt::Sampled(self.sample(part, seed)?)),
            Goal::Within(tolerances) => self.within(tolerances, [smallest, largest], seed),
            &Goal::By(end) => self.by(end, [smallest, largest], seed),
        }
    }

    fn within(
        &self,
        tolerances: &[(String, f64)],
        [smallest, largest]: [f64; 2],
        seed: u64,
    ) -> Result<Attempt, Error> {
        let mut part = smallest;
        for stage in 0.. {
            let sampled = self.sample(part, seed ^ (stage << STAGE_BITS))?;
            // By how much an interval is too wide.
            let excess = |(id, tolerance): &(String, f64)| margin(&sampled, id) / tolerance;
            let widest = tolerances.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)));
            let Some(widest) = widest.filter(|widest| stage == 0 || excess(widest) > 1.0) else {
                return Ok(Attempt::Sampled(sampled));
            };
            part = part.max(excess(widest).powi(2) * VARIANCE_MARGIN * part);
            if part > largest {
                let (id, tolerance) = widest;
                let what = if sampled.len() > 1 { "the change of " } else { "" };
                return Ok(Attempt::Whole(format!(
                    "a sample that saves time would leave {what}{id} further off than {} %",
                    100.0 * tolerance
                )));
            }
        }
        unreachable!("parts grow until a sample is tight or too large")
    }

    fn by(&self, end: Instant, [smallest, largest]: [f64; 2], seed: u64) -> Result<Attempt, Error> {
        let start = Instant::now();
        let pilot = self.sample(smallest, seed)?;
        let took = start.elapsed().as_secs_f64();
        let left = end.saturating_duration_since(Instant::now()).as_secs_f64() * TIME_MARGIN;
        let tiles = f64::from(self.source.header().frame.tiles());
        let of_tile = took / f64::from(pilot[0].tiles);
        // However many threads make tiles, one takes the turns of all warps.
        let threads = rayon::current_num_threads() as f64;
        if of_tile * (threads * SERIAL_PART).max(1.0) * tiles <= left {
            return Ok(Attempt::Whole("there is time for every tile".to_owned()));
        }
        let part = (left / of_tile / tiles).min(largest);
        if part > smallest {
            return Ok(Attempt::Sampled(self.sample(part, seed ^ (1 << STAGE_BITS))?));
        }
        Ok(if Instant::now() <= end { Attempt::Sampled(pilot) } else { Attempt::TooLate(pilot) })
    }
}

/// Where in a seed the number of the stage is.
const STAGE_BITS: u32 = 56;

/// How far a counter's interval reaches from its value, as a part of that; of several variants, how far those of the changes reach, as
/// a part of the first one's, the furthest of them.
fn margin(sampled: &[Sampled], id: &str) -> f64 {
    match sampled {
        [] => 0.0,
        [alone] => alone.margin(id),
        [first, others @ ..] => {
            others.iter().map(|other| other.margin_of_change(first, id)).fold(0.0, f64::max)
        }
    }
}

impl Sampled {
    /// How far a counter's interval reaches from its value, as a part of that; infinite from a value of 0 that is not exact, and 0
    /// for a counter that the frame does not have.
    pub fn margin(&self, id: &str) -> f64 {
        let value = self.estimate.frame.get(id).and_then(|value| value.number());
        let Some((value, [low, high])) = value.zip(self.intervals.of_frame(id)) else {
            return 0.0;
        };
        let reach = (value - low).max(high - value);
        if reach > 0.0 { reach / value.abs() } else { 0.0 }
    }

    /// How far the interval of what a counter is in terms of that of `first`, a sample of the same blocks, reaches from its value; 0 for
    /// a counter without such an interval.
    fn margin_of_change(&self, first: &Self, id: &str) -> f64 {
        let ratio = self.ratios_to(first).and_then(|ratios| ratios.into_iter().find(|(of, _)| *of == id));
        ratio.map_or(0.0, |(_, ratio)| ratio.reach())
    }
}
