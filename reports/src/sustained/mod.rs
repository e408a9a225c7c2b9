//! A frame drawn again and again on a phone that warms: frame rate, clock, power and temperatures over time.

mod series;
mod text;

pub use series::{chart, csv_text};
pub(crate) use text::{charge, span, write};

use serde::{Deserialize, Serialize};
use thermal::{LongRun, OperatingPoint, Outcome, Phone, Run, Sample, long_run};

/// Seconds over which a sustained frame rate is taken.
const MINUTE: f64 = 60.0;
const SECONDS_PER_HOUR: f64 = 3600.0;

/// What became of a frame rate on a phone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sustained {
    /// The phone.
    pub phone: String,
    /// How long it was to be followed, in seconds.
    pub seconds: f64,
    /// Temperature of the air, and of the phone at the start, in degrees Celsius.
    pub ambient_celsius: f64,
    /// Frames per second at the highest clock.
    pub peak_fps: f64,
    /// Frames per second over the last minute, or all of a shorter time.
    pub sustained_fps: f64,
    /// The part of the peak that is sustained.
    pub stability: f64,
    /// Seconds until the clock was lowered first; none where it never was.
    pub throttled_after_s: Option<f64>,
    /// How it ended: `completed`, `shut_down`, or `ran_away` where the exponential law of leakage has no balance at that clock, however warm.
    pub outcome: String,
    /// When, in seconds.
    pub ended_after_s: f64,
    /// Changes of the clock.
    pub switches: u64,
    /// The clocks that the GPU can have, the highest first.
    pub operating_points: Vec<SustainedPoint>,
    /// Each minute.
    pub minutes: Vec<Minute>,
    /// Each part of the phone.
    pub nodes: Vec<NodeHeat>,
    /// Where the heat went.
    pub heat: Heat,
    /// What it takes from the battery; none where the phone's description does not say what that holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub battery: Option<Battery>,
}

/// A full battery under the load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Energy of a full charge, in Wh.
    pub watt_hours: f64,
    /// The part of it that the whole phone took, from 0; above 1 where it would not have lasted.
    pub used: f64,
    /// Hours that a full charge lasts at the mean power.
    pub lasts_hours: f64,
}

impl Battery {
    /// Of a phone that took so many joules in so many seconds; none where it took none.
    fn new(watt_hours: f64, joules: f64, seconds: f64) -> Option<Self> {
        let charge = watt_hours * SECONDS_PER_HOUR;
        let used = joules / charge;
        (used > 0.0).then(|| Self { watt_hours, used, lasts_hours: seconds / used / SECONDS_PER_HOUR })
    }
}

/// The frame at one clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SustainedPoint {
    /// Clock, in MHz.
    pub mhz: f64,
    /// Supply voltage.
    pub volts: f64,
    /// Frames per second.
    pub fps: f64,
    /// Power of the GPU without leakage, in W.
    pub gpu_w: f64,
    /// Power of the memory, in W.
    pub dram_w: f64,
    /// Leakage of the GPU at `leakage_celsius`, in W.
    pub leakage_w: f64,
    /// Degrees Celsius of the GPU.
    pub leakage_celsius: f64,
    /// Where the GPU would end up if nothing lowered the clock, in degrees Celsius; none where the exponential law of leakage has no balance.
    pub settles_at_celsius: Option<f64>,
    /// Seconds spent at it.
    pub seconds: f64,
}

/// A minute, or what is left of the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Minute {
    /// Its end, in seconds.
    pub until_s: f64,
    /// Frames per second.
    pub fps: f64,
    /// Energy of the whole phone, in J.
    pub energy_j: f64,
    /// Of which the GPU, its leakage and the memory took so much, in J.
    pub frame_energy_j: f64,
}

/// What a part of the phone went through.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeHeat {
    /// The part.
    pub name: String,
    /// Its highest temperature at any sample, in degrees Celsius.
    pub peak_celsius: f64,
    /// That at the end.
    pub last_celsius: f64,
}

/// Heat, in J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// That all power brought in.
    pub in_j: f64,
    /// That the phone kept.
    pub stored_j: f64,
    /// That the air took.
    pub to_air_j: f64,
}

impl Sustained {
    /// What `run` says of `points` at so many volts each on `phone`, which was to be followed for `seconds`.
    pub fn new(phone: &Phone, points: &[OperatingPoint], volts: &[f64], run: &Run, seconds: f64) -> Self {
        let (ended_after_s, outcome) = ended(run);
        let last = run.samples.last();
        let peak_fps = points.first().map_or(0.0, |point| point.frames_per_second);
        let sustained_fps = if run.switches.is_empty() {
            peak_fps
        } else {
            rate(run, (ended_after_s - MINUTE).max(0.0), ended_after_s)
        };
        let settles = |point: &OperatingPoint| match long_run(&phone.equation(point)) {
            LongRun::Settles(rises) => Some(phone.ambient_celsius + rises[phone.gpu]),
            LongRun::RunsAway => None,
        };
        let of_point = |(index, (point, &volts)): (usize, (&OperatingPoint, &f64))| SustainedPoint {
            mhz: point.mhz,
            volts,
            fps: point.frames_per_second,
            gpu_w: point.gpu_watts,
            dram_w: point.dram_watts,
            leakage_w: point.leakage.watts,
            leakage_celsius: point.leakage.celsius,
            settles_at_celsius: settles(point),
            seconds: seconds_at(run, index, ended_after_s),
        };
        let of_node = |(node, name): (usize, &str)| NodeHeat {
            name: name.to_owned(),
            peak_celsius: run
                .samples
                .iter()
                .map(|sample| sample.celsius[node])
                .fold(f64::NEG_INFINITY, f64::max),
            last_celsius: last.map_or(phone.ambient_celsius, |sample| sample.celsius[node]),
        };
        let joules = last.map_or(0.0, |sample| sample.joules);
        Self {
            phone: phone.title.clone(),
            seconds,
            ambient_celsius: phone.ambient_celsius,
            peak_fps,
            sustained_fps,
            stability: if peak_fps > 0.0 { sustained_fps / peak_fps } else { 0.0 },
            throttled_after_s: run.switches.first().map(|switch| switch.at),
            outcome: outcome.to_owned(),
            ended_after_s,
            switches: run.switches.len() as u64,
            operating_points: points.iter().zip(volts).enumerate().map(of_point).collect(),
            minutes: minutes(phone, run, ended_after_s),
            nodes: phone
                .network
                .nodes()
                .iter()
                .map(|node| node.name.as_str())
                .enumerate()
                .map(of_node)
                .collect(),
            heat: Heat { in_j: joules, stored_j: run.joules_stored, to_air_j: run.joules_to_air },
            battery: phone.charge_watt_hours.and_then(|charge| Battery::new(charge, joules, ended_after_s)),
        }
    }
}

fn ended(run: &Run) -> (f64, &'static str) {
    let last = run.samples.last().map_or(0.0, |sample| sample.at);
    match run.outcome {
        Outcome::Completed => (last, "completed"),
        Outcome::ShutDown { at } => (at, "shut_down"),
        Outcome::RanAway { at } => (at, "ran_away"),
    }
}

/// What a running total of samples was at an instant: they are close enough for a straight line between them.
fn at(run: &Run, instant: f64, total: impl Fn(&Sample) -> f64) -> f64 {
    let after = run.samples.partition_point(|sample| sample.at < instant);
    match (after.checked_sub(1).map(|before| &run.samples[before]), run.samples.get(after)) {
        (Some(a), Some(b)) => total(a) + (total(b) - total(a)) * (instant - a.at) / (b.at - a.at),
        (None, Some(only)) | (Some(only), None) => total(only),
        (None, None) => 0.0,
    }
}

fn rate(run: &Run, from: f64, to: f64) -> f64 {
    let frames = |instant| at(run, instant, |sample| sample.frames);
    if to > from { (frames(to) - frames(from)) / (to - from) } else { 0.0 }
}

fn minutes(phone: &Phone, run: &Run, end: f64) -> Vec<Minute> {
    let other: f64 = phone.other_watts.iter().sum();
    let count = (end / MINUTE).ceil() as u32;
    let minute = |number: u32| {
        let (from, to) = (MINUTE * f64::from(number), (MINUTE * f64::from(number + 1)).min(end));
        let joules = |instant| at(run, instant, |sample| sample.joules);
        let energy_j = joules(to) - joules(from);
        let frame_energy_j = energy_j - other * (to - from);
        Minute { until_s: to, fps: rate(run, from, to), energy_j, frame_energy_j }
    };
    (0..count).map(minute).collect()
}

fn seconds_at(run: &Run, point: usize, end: f64) -> f64 {
    let starts = std::iter::once((0.0, 0)).chain(run.switches.iter().map(|switch| (switch.at, switch.to)));
    let ends = run.switches.iter().map(|switch| switch.at).chain([end]);
    starts
        .zip(ends)
        .filter(|((_, to), _)| *to == point)
        .map(|((from, _), to)| to - from)
        .fold(0.0, |sum, span| sum + span)
}
