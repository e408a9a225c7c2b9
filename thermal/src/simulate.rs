//! A load on a phone over time: clock, power and temperatures.

use crate::equation::{HeatEquation, State};
use crate::error::Error;
use crate::governor::Watcher;
use crate::integrate::{Counts, Crossing, Direction, Integrator, Reached, Steps};
use crate::leakage::Leakage;
use crate::method::Method;
use crate::phone::Phone;
use crate::steady::{LongRun, long_run};

/// What the load is at one clock of the GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Clock, in MHz.
    pub mhz: f64,
    /// Frames per second.
    pub frames_per_second: f64,
    /// Power of the GPU without leakage, in W.
    pub gpu_watts: f64,
    /// Power of the memory, in W.
    pub dram_watts: f64,
    /// Leakage of the GPU.
    pub leakage: LeakageLaw,
}

/// Leakage by temperature: exponential through a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeakageLaw {
    /// At a temperature, in W.
    pub watts: f64,
    /// That temperature, in degrees Celsius.
    pub celsius: f64,
    /// Relative growth per kelvin.
    pub per_kelvin: f64,
}

/// How a load is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How long, in seconds.
    pub seconds: f64,
    /// Seconds between samples.
    pub sample_seconds: f64,
    /// How.
    pub method: Method,
    /// Largest error of a temperature in a step, in K.
    pub tolerance: f64,
}

impl Settings {
    /// So many seconds with a sample each, by the default method and tolerance.
    pub fn over(seconds: f64) -> Self {
        Self { seconds, sample_seconds: 1.0, method: Method::default(), tolerance: 1e-3 }
    }
}

/// One instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Seconds from the start.
    pub at: f64,
    /// The operating point from here on, by place.
    pub point: usize,
    /// Power of the whole phone, in W.
    pub watts: f64,
    /// Temperatures of the nodes, in degrees Celsius.
    pub celsius: Vec<f64>,
    /// Frames so far.
    pub frames: f64,
    /// Heat so far, in J: of the whole phone.
    pub joules: f64,
}

/// A change of the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Switch {
    /// Seconds from the start.
    pub at: f64,
    /// The operating point from here on, by place.
    pub to: usize,
    /// The zone that asked for it, by place.
    pub zone: usize,
}

/// How a simulation ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// After its time.
    Completed,
    /// At the temperature at which the phone shuts down.
    ShutDown {
        /// Seconds from the start.
        at: f64,
    },
    /// At the same temperature, where leakage grew faster than heat could leave: its exponential law has no balance, however warm.
    RanAway {
        /// Seconds from the start.
        at: f64,
    },
}

/// What became of a load.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// At each multiple of the sample interval, and at the end.
    pub samples: Vec<Sample>,
    /// Changes of the clock.
    pub switches: Vec<Switch>,
    /// How it ended.
    pub outcome: Outcome,
    /// Heat that has gone to the air, in J.
    pub joules_to_air: f64,
    /// Heat that the phone has kept, in J.
    pub joules_stored: f64,
    /// What it cost.
    pub counts: Counts,
}

/// Readings of sensors and samples that a simulation takes at most.
const MOST_READINGS: f64 = 1e7;

impl OperatingPoint {
    /// Checks that a phone can have it.
    fn check(&self) -> Result<(), Error> {
        let figures = [
            ("clock", self.mhz, f64::MIN_POSITIVE),
            ("frame rate", self.frames_per_second, 0.0),
            ("power of the GPU", self.gpu_watts, 0.0),
            ("power of the memory", self.dram_watts, 0.0),
            ("leakage", self.leakage.watts, 0.0),
            ("growth of leakage per kelvin", self.leakage.per_kelvin, f64::MIN_POSITIVE),
        ];
        for (what, value, least) in figures {
            if !(value >= least && value.is_finite()) {
                let problem = format!("{what} of {value}, expected at least {least}");
                return Err(Error::input("operating point", problem, "correct it"));
            }
        }
        Ok(())
    }
}

impl Phone {
    /// What its temperatures follow at an operating point.
    pub fn equation(&self, point: &OperatingPoint) -> HeatEquation<'_> {
        let mut power = self.other_watts.clone();
        power[self.gpu] += point.gpu_watts;
        power[self.dram] += point.dram_watts;
        let leakage = Leakage {
            node: self.gpu,
            at_reference: point.leakage.watts,
            reference: point.leakage.celsius - self.ambient_celsius,
            per_kelvin: point.leakage.per_kelvin,
        };
        HeatEquation { network: &self.network, power, leakage: Some(leakage) }
    }

    /// Checks that a load can be followed so.
    ///
    /// # Errors
    /// When it takes no time, or so long that its readings and samples are too many.
    pub fn check(&self, settings: &Settings) -> Result<(), Error> {
        let Settings { seconds, sample_seconds, .. } = *settings;
        if !(seconds > 0.0 && seconds.is_finite() && sample_seconds > 0.0) {
            let problem = format!("{seconds} s with a sample each {sample_seconds} s, expected more than 0");
            return Err(Error::input("duration", problem, "give a duration such as 600"));
        }
        let intervals = self.zones.iter().flat_map(|zone| [zone.polling, zone.polling_passive]);
        let shortest = intervals.filter(|interval| *interval > 0.0).fold(sample_seconds, f64::min);
        if seconds / shortest > MOST_READINGS {
            let problem = format!("{seconds} s with a reading or sample each {shortest} s");
            return Err(Error::input("duration", problem, "shorten it, or read sensors less often"));
        }
        Ok(())
    }

    /// Follows a load from a phone as warm as the air. `points` are by falling clock; the governor starts at the first.
    ///
    /// # Errors
    /// When there is no operating point, their clocks do not fall, a figure is out of its range, or the method cannot meet its tolerance.
    pub fn simulate(&self, points: &[OperatingPoint], settings: &Settings) -> Result<Run, Error> {
        let Settings { seconds, sample_seconds, method, tolerance } = *settings;
        points.iter().try_for_each(OperatingPoint::check)?;
        if points.is_empty() || points.windows(2).any(|pair| pair[1].mhz >= pair[0].mhz) {
            let problem = "expected at least one, by falling clock";
            return Err(Error::input("operating points", problem, "sort them, each clock once"));
        }
        self.check(settings)?;
        let integrator = Integrator::new(method, Steps::Tolerance(tolerance), &self.network)?;
        Simulation::new(self, points, integrator).run(seconds, sample_seconds)
    }
}

struct Simulation<'a> {
    phone: &'a Phone,
    points: &'a [OperatingPoint],
    clocks: Vec<f64>,
    equations: Vec<HeatEquation<'a>>,
    watchers: Vec<Watcher<'a>>,
    integrator: Integrator,
    state: State,
    now: f64,
    point: usize,
    frames: f64,
    samples: Vec<Sample>,
    switches: Vec<Switch>,
}

impl<'a> Simulation<'a> {
    fn new(phone: &'a Phone, points: &'a [OperatingPoint], integrator: Integrator) -> Self {
        Self {
            phone,
            points,
            clocks: points.iter().map(|point| point.mhz).collect(),
            equations: points.iter().map(|point| phone.equation(point)).collect(),
            watchers: phone.zones.iter().map(|zone| Watcher::new(zone, phone.ambient_celsius)).collect(),
            integrator,
            state: State::cold(&phone.network),
            now: 0.0,
            point: 0,
            frames: 0.0,
            samples: Vec::new(),
            switches: Vec::new(),
        }
    }

    fn run(mut self, seconds: f64, sample_seconds: f64) -> Result<Run, Error> {
        let mut crossings = Vec::new();
        // Which watcher each crossing is of; the first is the phone's end.
        let mut owners = Vec::new();
        self.sample();
        let outcome = loop {
            let next_sample = (sample_seconds * self.samples.len() as f64).min(seconds);
            let readings = self.watchers.iter().map(Watcher::next_reading);
            let until = readings.fold(next_sample, f64::min);
            self.list_crossings(&mut crossings, &mut owners);
            let equation = &self.equations[self.point];
            let span = until - self.now;
            let reached = self.integrator.advance(equation, &mut self.state, span, &crossings)?;
            let (passed, now) = match reached {
                Reached::End => (span, until),
                Reached::Crossing { after, .. } => (after, self.now + after),
            };
            self.frames += passed * self.points[self.point].frames_per_second;
            self.now = now;
            match reached {
                Reached::Crossing { which: 0, .. } => {
                    self.sample();
                    break match long_run(&self.equations[self.point]) {
                        LongRun::RunsAway => Outcome::RanAway { at: now },
                        LongRun::Settles(_) => Outcome::ShutDown { at: now },
                    };
                }
                Reached::Crossing { which, .. } => self.act(owners[which]),
                Reached::End => {
                    (0..self.watchers.len())
                        .filter(|&zone| self.watchers[zone].next_reading() <= now)
                        .collect::<Vec<_>>()
                        .into_iter()
                        .for_each(|zone| self.act(zone));
                    if now >= next_sample {
                        self.sample();
                    }
                }
            }
            if self.now >= seconds {
                break Outcome::Completed;
            }
        };
        Ok(Run {
            outcome,
            joules_to_air: self.state.heat_out(),
            joules_stored: self.phone.network.stored(self.state.temperatures()),
            counts: self.integrator.counts(),
            samples: self.samples,
            switches: self.switches,
        })
    }

    fn celsius(&self, node: usize) -> f64 {
        self.phone.ambient_celsius + self.state.temperatures()[node]
    }

    fn list_crossings(&self, crossings: &mut Vec<Crossing>, owners: &mut Vec<usize>) {
        let limit = self.phone.shutdown.celsius - self.phone.ambient_celsius;
        crossings.clear();
        owners.clear();
        crossings.push(Crossing { node: self.phone.shutdown.node, limit, direction: Direction::Rising });
        owners.push(usize::MAX);
        for (zone, watcher) in self.watchers.iter().enumerate() {
            watcher.crossings(crossings);
            owners.resize(crossings.len(), zone);
        }
    }

    /// Lets a zone read its sensor, and sets the clock to the lowest that any zone wants.
    fn act(&mut self, zone: usize) {
        let rise = self.state.temperatures()[self.watchers[zone].sensor()];
        self.watchers[zone].act(self.now, rise, self.point, &self.clocks);
        let wanted = self.watchers.iter().map(|watcher| watcher.wanted).max().unwrap_or(0);
        if wanted != self.point {
            self.point = wanted;
            self.switches.push(Switch { at: self.now, to: wanted, zone });
        }
    }

    fn sample(&mut self) {
        let equation = &self.equations[self.point];
        self.samples.push(Sample {
            at: self.now,
            point: self.point,
            watts: equation.power_in(self.state.temperatures()),
            celsius: (0..self.phone.network.size()).map(|node| self.celsius(node)).collect(),
            frames: self.frames,
            joules: self.state.heat_in(),
        });
    }
}
