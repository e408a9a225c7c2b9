//! What lowers the clock when a sensor is warm, as Linux and Android's thermal daemons do.

use crate::integrate::{Crossing, Direction};

/// A temperature at which something happens, and how far below it that ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// Degrees Celsius.
    pub celsius: f64,
    /// Kelvins below it at which it is over.
    pub hysteresis: f64,
}

impl Trip {
    /// Rise above air of `ambient` degrees Celsius from which on it holds, given whether it held before.
    fn limit(&self, ambient: f64, before: bool) -> f64 {
        (if before { self.celsius - self.hysteresis } else { self.celsius }) - ambient
    }
}

/// A clock that a zone allows while a trip holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// When.
    pub trip: Trip,
    /// Highest clock then, as a part of the highest of all; above 1 it caps nothing.
    pub clock_share: f64,
}

/// What a zone does about its temperature.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// One operating point down at each reading from the trip on that is higher than the last, one up at each below its hysteresis that is lower than the
    /// last: Linux `drivers/thermal/gov_step_wise.c` up to 6.8, with a band between them in which nothing happens, as `ss` of Qualcomm's thermal-engine has
    /// it. Linux itself uses the hysteresis otherwise or not at all, by version.
    StepWise(Trip),
    /// A cap for each trip, by rising temperature: the `monitor` of Qualcomm's thermal-engine.
    Monitor(Vec<Cap>),
}

/// A sensor and what is done about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Its name.
    pub name: String,
    /// The node whose temperature the sensor has, by place in the network.
    pub sensor: usize,
    /// Seconds between readings; 0 where the sensor tells by itself when it crosses a trip.
    pub polling: f64,
    /// Seconds between readings while a trip holds.
    pub polling_passive: f64,
    /// What is done.
    pub rule: Rule,
}

/// A zone at work.
#[derive(Clone, Debug)]
pub(crate) struct Watcher<'a> {
    zone: &'a Zone,
    /// Of the air, in degrees Celsius.
    ambient: f64,
    /// How many of its trips hold; those of lower temperatures first.
    holding: usize,
    /// Operating points that it wants the clock lowered by.
    pub(crate) wanted: usize,
    last: Option<f64>,
    /// When the present series of readings began, and how many there have been since.
    since: f64,
    readings: u64,
}

impl<'a> Watcher<'a> {
    pub(crate) fn new(zone: &'a Zone, ambient: f64) -> Self {
        Self { zone, ambient, holding: 0, wanted: 0, last: None, since: 0.0, readings: 0 }
    }

    fn interval(&self) -> f64 {
        if self.is_passive() { self.zone.polling_passive } else { self.zone.polling }
    }

    /// Whether it lowers the clock, or could be about to.
    fn is_passive(&self) -> bool {
        self.holding > 0 || self.wanted > 0
    }

    /// Whether the sensor itself tells of the next crossing.
    fn is_told(&self) -> bool {
        match self.zone.rule {
            Rule::StepWise(_) => self.interval() == 0.0,
            Rule::Monitor(_) => self.zone.polling == 0.0,
        }
    }

    /// When the sensor is read next, in seconds from the start; never where it tells by itself.
    pub(crate) fn next_reading(&self) -> f64 {
        if self.is_told() {
            f64::INFINITY
        } else {
            self.interval().mul_add((self.readings + 1) as f64, self.since)
        }
    }

    /// What the sensor tells of.
    pub(crate) fn crossings(&self, out: &mut Vec<Crossing>) {
        if !self.is_told() {
            return;
        }
        let node = self.zone.sensor;
        let trips: Vec<Trip> = match &self.zone.rule {
            Rule::StepWise(trip) => vec![*trip],
            Rule::Monitor(caps) => caps.iter().map(|cap| cap.trip).collect(),
        };
        if let Some(next) = trips.get(self.holding) {
            let limit = next.limit(self.ambient, false);
            out.push(Crossing { node, limit, direction: Direction::Rising });
        }
        if let Some(held) = self.holding.checked_sub(1) {
            let limit = trips[held].limit(self.ambient, true);
            out.push(Crossing { node, limit, direction: Direction::Falling });
        }
    }

    /// The node that it watches.
    pub(crate) fn sensor(&self) -> usize {
        self.zone.sensor
    }

    /// Acts on a rise above the air, in K; `lowered` operating points is the clock below the highest of `clocks`.
    pub(crate) fn act(&mut self, now: f64, rise: f64, lowered: usize, clocks: &[f64]) {
        let holds = |trip: &Trip, before| rise >= trip.limit(self.ambient, before);
        let interval = self.interval();
        self.readings += 1;
        match &self.zone.rule {
            Rule::StepWise(trip) => {
                let held = holds(trip, self.is_passive());
                if holds(trip, false) && self.last.is_none_or(|last| rise > last) {
                    self.wanted = (lowered + 1).min(clocks.len() - 1);
                } else if !held && self.last.is_some_and(|last| rise < last) {
                    self.wanted = lowered.saturating_sub(1).min(self.wanted);
                }
                self.holding = usize::from(held);
                self.last = Some(rise);
            }
            Rule::Monitor(caps) => {
                while self.holding < caps.len() && holds(&caps[self.holding].trip, false) {
                    self.holding += 1;
                }
                while self.holding > 0 && !holds(&caps[self.holding - 1].trip, true) {
                    self.holding -= 1;
                }
                let share = self.holding.checked_sub(1).map_or(1.0, |held| caps[held].clock_share);
                let allowed = clocks.iter().position(|clock| *clock <= share * clocks[0]);
                self.wanted = allowed.unwrap_or(clocks.len() - 1);
            }
        }
        if self.interval() != interval {
            (self.since, self.readings) = (now, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCKS: [f64; 4] = [700.0, 600.0, 400.0, 250.0];

    fn zone(rule: Rule) -> Zone {
        Zone { name: "zone".to_owned(), sensor: 0, polling: 0.0, polling_passive: 0.25, rule }
    }

    /// The rules of `get_target_state` of Linux, each reading in turn, and the band in which nothing happens.
    #[test]
    fn step_wise_lowers_while_it_warms_and_lifts_while_it_cools_below_its_hysteresis() {
        let zone = zone(Rule::StepWise(Trip { celsius: 95.0, hysteresis: 5.0 }));
        let mut watcher = Watcher::new(&zone, 25.0);
        let mut lowered = 0;
        let readings = [
            (95.0, 1),
            (96.0, 2),
            (96.0, 2),
            (94.0, 2),
            (94.5, 2),
            (95.5, 3),
            (90.0, 3),
            (89.9, 2),
            (89.9, 2),
            (89.0, 1),
            (93.0, 1),
            (80.0, 0),
            (94.9, 0),
        ];
        for (celsius, expected) in readings {
            watcher.act(0.0, celsius - 25.0, lowered, &CLOCKS);
            lowered = watcher.wanted;
            assert_eq!(lowered, expected, "at {celsius}");
        }
        assert_eq!(watcher.next_reading(), f64::INFINITY);
    }

    #[test]
    fn a_monitor_caps_at_each_trip_and_lifts_below_its_hysteresis() {
        let cap = |celsius, clock_share| Cap { trip: Trip { celsius, hysteresis: 1.0 }, clock_share };
        let zone = zone(Rule::Monitor(vec![cap(50.0, 0.6), cap(52.0, 0.1)]));
        let mut watcher = Watcher::new(&zone, 25.0);
        let readings = [
            (49.9, 0),
            (50.0, 2),
            (49.0, 2),
            (52.0, 3),
            (51.1, 3),
            (50.9, 2),
            (48.9, 0),
            (60.0, 3),
            (40.0, 0),
        ];
        for (celsius, expected) in readings {
            watcher.act(0.0, celsius - 25.0, 0, &CLOCKS);
            assert_eq!(watcher.wanted, expected, "at {celsius}");
        }
    }

    #[test]
    fn a_sensor_tells_of_its_next_trip_and_of_the_end_of_the_last() {
        let cap = |celsius| Cap { trip: Trip { celsius, hysteresis: 1.0 }, clock_share: 0.5 };
        let zone = zone(Rule::Monitor(vec![cap(50.0), cap(52.0)]));
        let mut watcher = Watcher::new(&zone, 25.0);
        watcher.act(0.0, 26.0, 0, &CLOCKS);
        let mut told = Vec::new();
        watcher.crossings(&mut told);
        let limits: Vec<_> = told.iter().map(|crossing| (crossing.limit, crossing.direction)).collect();
        assert_eq!(limits, [(27.0, Direction::Rising), (24.0, Direction::Falling)]);
    }

    #[test]
    fn readings_follow_each_other_by_the_interval_of_the_state() {
        let mut zone = zone(Rule::StepWise(Trip { celsius: 95.0, hysteresis: 2.0 }));
        zone.polling = 1.0;
        let mut watcher = Watcher::new(&zone, 25.0);
        assert_eq!(watcher.next_reading(), 1.0);
        watcher.act(1.0, 0.0, 0, &CLOCKS);
        assert_eq!(watcher.next_reading(), 2.0);
        watcher.act(2.0, 74.0, 0, &CLOCKS);
        assert_eq!(watcher.next_reading(), 2.25);
        watcher.act(2.25, 55.0, 1, &CLOCKS);
        assert_eq!(watcher.next_reading(), 3.25);
    }
}
