//! Temperatures of a phone over time.
//!
//! A phone is a [`Network`] of heat capacities and conductances. Power flows into its nodes, and leakage makes that depend on a temperature: a stiff
//! nonlinear equation, whose time constants reach from milliseconds of a die to minutes of a case. [`Integrator`] follows it by one of several [`Method`]s with
//! error control, and finds the instants at which a temperature crosses a limit. A [`Phone`] is a network from a file with a governor, which lowers the clock of a load
//! where sensors are warm: [`Phone::simulate`].

mod dormand_prince;
mod equation;
mod error;
mod exponential;
mod file;
mod governor;
mod integrate;
mod leakage;
mod lu;
mod method;
mod network;
mod phi;
mod phone;
mod rosenbrock;
mod simulate;
mod sourced;
mod steady;
mod symmetric;

pub use equation::{HeatEquation, State};
pub use error::Error;
pub use governor::{Cap, Rule, Trip, Zone};
pub use integrate::{Counts, Crossing, Direction, Integrator, Reached, Steps};
pub use leakage::Leakage;
pub use method::Method;
pub use network::{Link, Network, Node};
pub use phone::{BUILTIN, Phone, Shutdown};
pub use simulate::{LeakageLaw, OperatingPoint, Outcome, Run, Sample, Settings, Switch};
pub use steady::{LongRun, long_run};
