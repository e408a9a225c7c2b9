//! Steps of controlled error, and the instants at which a temperature crosses a limit.

use crate::equation::{HeatEquation, State};
use crate::error::Error;
use crate::method::{Method, Stepper};
use crate::network::Network;

/// A way through a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From below to the limit or beyond.
    Rising,
    /// From above to below the limit.
    Falling,
}

/// A limit that ends an integration where a node's temperature crosses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The node, by place in the network.
    pub node: usize,
    /// Rise above the air, in K.
    pub limit: f64,
    /// Which way.
    pub direction: Direction,
}

impl Crossing {
    /// How far the temperature is beyond the limit in the direction of the crossing, in K; from 0 on it has been crossed. At the limit itself a
    /// rising temperature has crossed it, a falling one has not.
    fn beyond(&self, temperatures: &[f64]) -> f64 {
        match self.direction {
            Direction::Rising => temperatures[self.node] - self.limit,
            Direction::Falling => self.limit.next_down() - temperatures[self.node],
        }
    }

    fn crossed(&self, temperatures: &[f64]) -> bool {
        self.beyond(temperatures) >= 0.0
    }
}

/// Why an integration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// Its time is over.
    End,
    /// A limit was crossed, so many seconds after the start; the state is that just after.
    Crossing {
        /// Which of the limits, by place.
        which: usize,
        /// When, in seconds from the start.
        after: f64,
    },
}

/// How long steps are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// As long as the estimated error of each temperature is at most so many K in a step.
    Tolerance(f64),
    /// So many seconds, whatever the error.
    Fixed(f64),
}

/// What an integration has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Steps taken.
    pub steps: u64,
    /// Steps that had to be repeated with a shorter one.
    pub rejected: u64,
    /// Steps tried to find the instant of a crossing.
    pub located: u64,
}

/// Follows the heat equation.
#[derive(Clone, Debug)]
pub struct Integrator {
    method: Method,
    stepper: Stepper,
    steps: Steps,
    /// Length of step that the error allows, in seconds; none before the first.
    allowed: Option<f64>,
    counts: Counts,
    next: State,
    trial: State,
}

/// Part of the allowed growth or reduction that is used, as error estimates are estimates.
const SAFETY: f64 = 0.9;
/// Bounds of the change of the length from one step to the next.
const LEAST_CHANGE: f64 = 0.1;
const LARGEST_CHANGE: f64 = 5.0;
/// Steps, rejected ones included, after which an integration is given up.
const MOST_STEPS: u64 = 10_000_000;
/// Part of the time until the end below which a step moves nothing.
const SHORTEST: f64 = 1e-14;
/// Halvings and secants after which a bracket of an instant is as narrow as floats are.
const MOST_TRIALS: u32 = 120;

impl Integrator {
    /// A way to follow a network.
    ///
    /// # Errors
    /// When the tolerance or the length of the steps is not positive and finite.
    pub fn new(method: Method, steps: Steps, network: &Network) -> Result<Self, Error> {
        let (what, value) = match steps {
            Steps::Tolerance(kelvin) => ("tolerance", kelvin),
            Steps::Fixed(seconds) => ("length of a step", seconds),
        };
        if !(value > 0.0 && value.is_finite()) {
            let problem = format!("{value}, expected more than 0");
            return Err(Error::input(what, problem, "give one, such as 0.001"));
        }
        let cold = State::cold(network);
        Ok(Self {
            method,
            stepper: Stepper::new(method),
            steps,
            allowed: None,
            counts: Counts::default(),
            next: cold.clone(),
            trial: cold,
        })
    }

    /// What all integrations so far have cost.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Follows the equation for `seconds`, or until the first of the crossings.
    ///
    /// Crossings are located by bracketing the length of the last step, each trial a step of the method itself: so the state at the
    /// crossing is as accurate as any. A temperature that touches a limit within a step and turns back is found by its turning point.
    ///
    /// # Errors
    /// When the method cannot meet its tolerance, or needs too many steps.
    pub fn advance(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &mut State,
        seconds: f64,
        crossings: &[Crossing],
    ) -> Result<Reached, Error> {
        let mut passed = 0.0;
        if let Some(which) = crossings.iter().position(|crossing| crossing.crossed(state.temperatures())) {
            return Ok(Reached::Crossing { which, after: passed });
        }
        while passed < seconds {
            self.stepper.start(equation, state);
            let step = self.step(equation, state, seconds - passed, passed)?;
            if let Some((which, after)) = self.first_crossing(equation, state, step, crossings) {
                std::mem::swap(state, &mut self.trial);
                return Ok(Reached::Crossing { which, after: passed + after });
            }
            std::mem::swap(state, &mut self.next);
            // The last step ends exactly where the time does.
            passed = if step >= seconds - passed { seconds } else { passed + step };
        }
        Ok(Reached::End)
    }

    /// Takes one step of at most `rest` seconds into [`Self::next`], and answers its length.
    fn step(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        rest: f64,
        passed: f64,
    ) -> Result<f64, Error> {
        let mut step = match self.steps {
            Steps::Fixed(length) => length.min(rest),
            Steps::Tolerance(_) => self.allowed.unwrap_or(rest).min(rest),
        };
        loop {
            if self.counts.steps + self.counts.rejected >= MOST_STEPS {
                return Err(self.stuck(passed, "too many steps"));
            }
            let error = self.stepper.step(equation, state, step, &mut self.next);
            let finite = self.next.values().iter().all(|value| value.is_finite());
            let Steps::Tolerance(tolerance) = self.steps else {
                self.counts.steps += 1;
                return if finite {
                    Ok(step)
                } else {
                    Err(self.stuck(passed, "the step is too long for it"))
                };
            };
            let ratio = if finite && error.is_finite() { error / tolerance } else { f64::INFINITY };
            let change = SAFETY * ratio.powf(-1.0 / self.method.error_order());
            let change = change.clamp(LEAST_CHANGE, LARGEST_CHANGE);
            if ratio <= 1.0 {
                self.counts.steps += 1;
                // A step that was cut to the end of the time says little about how long one may be.
                let proposal = step * change;
                if step < rest || self.allowed.is_none_or(|allowed| proposal > allowed) {
                    self.allowed = Some(proposal);
                }
                return Ok(step);
            }
            self.counts.rejected += 1;
            step *= change.min(SAFETY);
            self.allowed = Some(step);
            if step <= SHORTEST * rest {
                return Err(self.stuck(passed, "no step is short enough for the tolerance"));
            }
        }
    }

    fn stuck(&self, passed: f64, problem: &str) -> Error {
        Error::Stuck { method: self.method.name(), at_s: passed, problem: problem.to_owned() }
    }

    /// The first crossing within the step that led to [`Self::next`], and when; the state there goes into [`Self::trial`].
    fn first_crossing(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        step: f64,
        crossings: &[Crossing],
    ) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for (which, crossing) in crossings.iter().enumerate() {
            let last = if crossing.crossed(self.next.temperatures()) {
                step
            } else {
                let Some(turn) = self.turning_point(equation, state, step, crossing) else { continue };
                turn
            };
            let when = self.locate(equation, state, last, |_, trial| crossing.beyond(trial.temperatures()));
            if first.is_none_or(|(_, earliest)| when < earliest) {
                first = Some((which, when));
            }
        }
        if let Some((_, when)) = first {
            self.stepper.step(equation, state, when, &mut self.trial);
        }
        first
    }

    /// Where within the step the temperature turns back from beyond the limit, if it does.
    fn turning_point(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        step: f64,
        crossing: &Crossing,
    ) -> Option<f64> {
        let towards = |equation: &HeatEquation<'_>, state: &State| {
            let heat = equation.net_heat(state.temperatures(), crossing.node);
            if crossing.direction == Direction::Rising { heat } else { -heat }
        };
        if !(towards(equation, state) > 0.0 && towards(equation, &self.next) < 0.0) {
            return None;
        }
        let turn = self.locate(equation, state, step, |equation, trial| -towards(equation, trial));
        self.stepper.step(equation, state, turn, &mut self.trial);
        crossing.crossed(self.trial.temperatures()).then_some(turn)
    }

    /// The length of step up to `high` at which `beyond` is no longer below 0, by the method of Anderson and Bjorck (1973) with a bisection after each two secants.
    fn locate(
        &mut self,
        equation: &HeatEquation<'_>,
        state: &State,
        mut high: f64,
        beyond: impl Fn(&HeatEquation<'_>, &State) -> f64,
    ) -> f64 {
        let at = |this: &mut Self, step: f64| {
            this.counts.located += 1;
            this.stepper.step(equation, state, step, &mut this.trial);
            beyond(equation, &this.trial)
        };
        let mut low = 0.0;
        let mut below = beyond(equation, state);
        let mut above = at(self, high);
        for trial in 0..MOST_TRIALS {
            let width = high - low;
            let secant = low + width * (below / (below - above));
            let bisects = trial % 3 == 2 || !(secant > low && secant < high);
            let middle = if bisects { low + 0.5 * width } else { secant };
            if middle <= low || middle >= high {
                break;
            }
            let found = at(self, middle);
            if found >= 0.0 {
                // The side that stays is halved, so that secants do not stall there.
                if !bisects && found > 0.0 {
                    let factor = 1.0 - found / above;
                    below *= if factor > 0.0 { factor } else { 0.5 };
                }
                (high, above) = (middle, found);
            } else {
                if !bisects {
                    let factor = 1.0 - found / below;
                    above *= if factor > 0.0 { factor } else { 0.5 };
                }
                (low, below) = (middle, found);
            }
            if found == 0.0 || high - low <= f64::EPSILON * high {
                break;
            }
        }
        high
    }
}
