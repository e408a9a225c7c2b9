//! How far the figures of a report may be from those of a more faithful rung of the ladder.

use crate::counters::Fidelity;
use crate::report::Report;
use crate::units;
use serde::{Deserialize, Serialize};

/// Errors of the default rung that were measured.
const RECORDED: &str = include_str!("../../configs/accuracy.toml");

/// How far the figures of a report may be from those of a more faithful rung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Within {
    /// That is known.
    Known {
        /// The more faithful rung.
        of: Fidelity,
        /// Relative error of the frame time, at most.
        frame_time: f64,
        /// Relative error of the bytes to and from DRAM, at most.
        dram_bytes: f64,
        /// Where the two come from.
        basis: String,
    },
    /// It is not known.
    Unknown {
        /// Why not.
        why: String,
    },
}

/// What `raybudget verify accuracy` said of the default rung.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorded {
    /// Frames that were compared.
    pub frames: u32,
    /// Largest relative error of a frame's time.
    pub frame_time: f64,
    /// Largest relative error of a frame's bytes to and from DRAM.
    pub dram_bytes: f64,
    /// The command that said so.
    pub source: String,
}

impl Recorded {
    /// What comes with the program.
    ///
    /// # Panics
    /// When that file is damaged, which a test excludes.
    pub fn embedded() -> Self {
        toml::from_str(RECORDED).expect("configs/accuracy.toml is valid")
    }
}

impl Within {
    /// How far figures of several frames may be off, in sentences: the largest errors that are known, from each rung, and of how many
    /// frames they are not.
    pub(crate) fn told<'a>(all: impl Iterator<Item = &'a Self>) -> Vec<String> {
        let (mut known, mut unknown): (Vec<(Fidelity, f64, f64, &str)>, usize) = (Vec::new(), 0);
        for within in all {
            match within {
                Self::Known { of, frame_time, dram_bytes, basis } => {
                    match known.iter_mut().find(|(rung, ..)| rung == of) {
                        Some((_, time, bytes, _)) => {
                            (*time, *bytes) = (time.max(*frame_time), bytes.max(*dram_bytes));
                        }
                        None => known.push((*of, *frame_time, *dram_bytes, basis)),
                    }
                }
                Self::Unknown { .. } => unknown += 1,
            }
        }
        let bound = |(rung, time, bytes, basis): (Fidelity, f64, f64, &str)| {
            format!(
                "Frame times within {} %, bytes of DRAM within {} % of the {} ones: {}.",
                units::digits(time * 100.0),
                units::digits(bytes * 100.0),
                if rung == Fidelity::Replay { "replayed" } else { "simulated" },
                basis.trim_end_matches('.')
            )
        };
        let rest =
            (unknown > 0).then(|| format!("Of {unknown} frames it is not known; their reports say why."));
        known.into_iter().map(bound).chain(rest).collect()
    }

    /// Of a frame that was replayed as a whole, where `simulated` says why it cannot be simulated event by event, if it cannot.
    pub fn replayed(simulated: Result<(), &str>) -> Self {
        if let Err(why) = simulated {
            return Self::Unknown {
                why: format!("{why}, so nothing more faithful was there to compare with"),
            };
        }
        let Recorded { frames, frame_time, dram_bytes, source } = Recorded::embedded();
        let basis = format!("worst of {frames} other frames: {source}");
        Self::Known { of: Fidelity::Timed, frame_time, dram_bytes, basis }
    }

    /// Of a frame that was simulated event by event.
    pub fn simulated() -> Self {
        Self::Unknown {
            why: "no rung is more faithful; `raybudget verify hardware` holds it against real GPUs"
                .to_owned(),
        }
    }

    /// Of a sample, whose counters have intervals.
    pub fn sampled(report: &Report) -> Self {
        let half_width = |id: &str| {
            let counter = report.counters.get(id)?;
            let value = counter.value.as_f64().filter(|value| *value != 0.0)?;
            counter.ci95.map(|[low, high]| (high - value).max(value - low) / value)
        };
        let (time, read) = (half_width("frame_time_ms"), half_width("dram_read_bytes"));
        match (time, read) {
            (Some(frame_time), Some(dram_bytes)) => {
                let basis = "95 % intervals of the sample, of DRAM those of what is read".to_owned();
                Self::Known { of: Fidelity::Replay, frame_time, dram_bytes, basis }
            }
            _ => Self::Unknown {
                why: "the sample gives no interval for frame time or for what is read from DRAM".to_owned(),
            },
        }
    }

    /// As a report says it.
    pub(crate) fn text(&self) -> String {
        let percent = |ratio: f64| format!("{} %", units::digits(100.0 * ratio));
        match self {
            Self::Known { of, frame_time, dram_bytes, basis } => format!(
                "{} of {} in frame time, {} in DRAM bytes ({basis})",
                percent(*frame_time),
                of.name(),
                percent(*dram_bytes)
            ),
            Self::Unknown { why } => format!("not known: {why}"),
        }
    }
}
