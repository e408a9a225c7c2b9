//! Samples of frames held against their replays, and what samples say of a change against what replays say of it: errors, intervals
//! and run times by the part that was replayed.
//!
//! An error is `sampled / replayed - 1`, of a figure or, for a change, of how many times as large it makes the figure. The 95th
//! percentile of its magnitude is over the seeds of a frame and part.

mod charts;
mod tables;

pub use charts::charts;
pub use tables::{COLUMNS, csv_text, json_text, text};

/// What is asked of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// So many times less processor time than a replay.
    pub speed: f64,
    /// Largest 95th percentile of errors, of samples of that speed.
    pub error: f64,
    /// Least and largest share of intervals that hold the replay's figure.
    pub covered: [f64; 2],
}

/// Intervals are of 95 %; two points to either side are the chance of some 500 samples.
pub const LIMITS: Limits = Limits { speed: 10.0, error: 0.02, covered: [0.93, 0.97] };

/// A counter in all samples of a frame of one part.
#[derive(Clone, Debug, PartialEq)]
pub struct Counter {
    /// Which.
    pub id: String,
    /// By seed.
    pub errors: Vec<f64>,
    /// By seed, how far the interval reaches, as a part of the value.
    pub margins: Vec<f64>,
    /// Seeds whose interval holds the replay's figure.
    pub covered: usize,
}

/// Samples of one part of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// Part of the tiles that was replayed, the mean over seeds.
    pub part: f64,
    /// Seconds of one processor of this machine, the mean over seeds.
    pub run_s: f64,
    /// In the same order for all parts and frames.
    pub counters: Vec<Counter>,
}

/// A frame on a GPU.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The scene's name.
    pub scene: String,
    /// The structure and how rays walk it.
    pub traversal: String,
    /// The GPU's name.
    pub gpu: String,
    /// What is changed, where the counters are of the change.
    pub change: Option<String>,
    /// Seconds of one processor of this machine that its replay takes, with that of the changed frame.
    pub replay_s: f64,
    /// The smallest part first.
    pub samples: Vec<Samples>,
}

/// Samples of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// The frames.
    pub frames: Vec<Frame>,
    /// Samples of each frame and part.
    pub seeds: u32,
    /// What is asked of them.
    pub limits: Limits,
}

/// Something that is stated of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its name.
    pub id: String,
    /// What is stated.
    pub text: String,
    /// What was found.
    pub found: String,
    /// Whether it is true.
    pub holds: bool,
}

impl Counter {
    /// The magnitude of errors that this share of the seeds does not exceed.
    pub fn error_at(&self, share: f64) -> f64 {
        quantile(&self.errors, share)
    }

    /// The median reach of the intervals.
    pub fn margin(&self) -> f64 {
        quantile(&self.margins, 0.5)
    }

    /// The share of intervals that hold the replay's figure.
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.errors.len() as f64
    }
}

/// Of magnitudes, the nearest rank.
fn quantile(numbers: &[f64], share: f64) -> f64 {
    let mut magnitudes: Vec<f64> = numbers.iter().map(|number| number.abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    let place = (share * magnitudes.len() as f64).ceil() as usize;
    magnitudes.get(place.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

impl Frame {
    /// Its name: scene, traversal and GPU, and what is changed.
    pub fn id(&self) -> String {
        let Self { scene, traversal, gpu, change, .. } = self;
        match change {
            Some(change) => format!("{scene}/{traversal}/{gpu}/{change}"),
            None => format!("{scene}/{traversal}/{gpu}"),
        }
    }

    /// How much less time samples take than the replay.
    pub fn speed(&self, samples: &Samples) -> f64 {
        self.replay_s / samples.run_s
    }

    /// The largest samples that are as quick as the limits ask.
    fn quick(&self, limits: &Limits) -> Option<&Samples> {
        self.samples.iter().rev().find(|samples| self.speed(samples) >= limits.speed)
    }
}

impl Sampling {
    /// For each frame its errors at the speed that is asked for, for each counter its coverage over all samples.
    pub fn statements(&self) -> Vec<Statement> {
        let Self { frames, limits, .. } = self;
        let of_frame = |frame: &Frame| {
            let quick = frame.quick(limits);
            let counters = frame.samples.first().map_or(&[][..], |samples| &samples.counters);
            let of_counter = |(place, counter): (usize, &Counter)| {
                let error = quick.map(|samples| samples.counters[place].error_at(0.95));
                Statement {
                    id: format!("{}/{}", frame.id(), counter.id),
                    text: format!(
                        "{}: in {} times less processor time, {} is within {} % for 95 % of the samples.",
                        frame.id(),
                        limits.speed,
                        counter.id,
                        100.0 * limits.error
                    ),
                    found: match quick.zip(error) {
                        Some((samples, error)) => {
                            format!("{:.2} % at {:.1} times less", 100.0 * error, frame.speed(samples))
                        }
                        None => "no part is sampled so quickly".to_owned(),
                    },
                    holds: error.is_some_and(|error| error <= limits.error),
                }
            };
            counters.iter().enumerate().map(of_counter).collect::<Vec<_>>()
        };
        let errors = frames.iter().flat_map(of_frame);
        errors.chain(self.coverage()).collect()
    }

    fn coverage(&self) -> Vec<Statement> {
        let [least, largest] = self.limits.covered;
        let mut found: Vec<(String, usize, usize)> = Vec::new();
        for frame in &self.frames {
            let of_changes = if frame.change.is_some() { "changes of " } else { "" };
            for counter in frame.samples.iter().flat_map(|samples| &samples.counters) {
                let what = format!("{of_changes}{}", counter.id);
                match found.iter_mut().find(|(known, ..)| *known == what) {
                    Some((_, covered, all)) => {
                        *covered += counter.covered;
                        *all += counter.errors.len();
                    }
                    None => found.push((what, counter.covered, counter.errors.len())),
                }
            }
        }
        let statement = |(what, covered, all): (String, usize, usize)| {
            let share = covered as f64 / all as f64;
            Statement {
                id: format!("coverage/{what}"),
                text: format!(
                    "The intervals of {what} hold the replay's figure in {:.0} to {:.0} % of the samples.",
                    100.0 * least,
                    100.0 * largest
                ),
                found: format!("{:.1} % of {all}", 100.0 * share),
                holds: (least..=largest).contains(&share),
            }
        };
        found.into_iter().map(statement).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counter(errors: &[f64], covered: usize) -> Counter {
        Counter {
            id: "frame_time_ms".to_owned(),
            errors: errors.to_vec(),
            margins: vec![0.1; errors.len()],
            covered,
        }
    }

    fn sampling(run_s: f64, errors: &[f64], covered: usize) -> Sampling {
        let samples = Samples { part: 0.1, run_s, counters: vec![counter(errors, covered)] };
        let frame = Frame {
            scene: "cornell".to_owned(),
            traversal: "bvh-stack".to_owned(),
            gpu: "adreno-540".to_owned(),
            change: None,
            replay_s: 1.0,
            samples: vec![samples],
        };
        Sampling { frames: vec![frame], seeds: errors.len() as u32, limits: LIMITS }
    }

    #[test]
    fn percentiles_are_of_magnitudes_by_nearest_rank() {
        let errors: Vec<f64> =
            (1..=20).map(|n| if n % 2 == 0 { f64::from(n) } else { -f64::from(n) }).collect();
        let counter = counter(&errors, 0);
        assert_eq!(
            (counter.error_at(0.95), counter.error_at(0.5), counter.error_at(1.0)),
            (19.0, 10.0, 20.0)
        );
    }

    #[test]
    fn statements_fail_for_slow_samples_large_errors_and_coverage_on_either_side() {
        let holds = |sampling: Sampling| sampling.statements().iter().map(|s| s.holds).collect::<Vec<_>>();
        let errors = [0.01; 20];
        assert_eq!(holds(sampling(0.1, &errors, 19)), [true, true]);
        assert_eq!(holds(sampling(0.11, &errors, 19)), [false, true]);
        assert_eq!(holds(sampling(0.1, &[0.03; 20], 19)), [false, true]);
        assert_eq!(holds(sampling(0.1, &errors, 20)), [true, false]);
        assert_eq!(holds(sampling(0.1, &errors, 18)), [true, false]);
    }
}
