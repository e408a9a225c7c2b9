//! Temperatures of a phone over time.
//!
//! A phone is a [`Network`] of heat capacities and conductances. Power flows into its nodes, and leakage makes that depend on a temperature: a stiff
//! nonlinear equation, whose time constants reach from milliseconds of a die to minutes of a case. [`Integrator`] follows it by one of several [`Method`]s with
//! error control, and finds the instants at which a temperature crosses a limit.

mod dormand_prince;
mod equation;
mod error;
mod exponential;
mod integrate;
mod leakage;
mod lu;
mod method;
mod network;
mod phi;
mod rosenbrock;
mod steady;
mod symmetric;

pub use equation::{HeatEquation, State};
pub use error::Error;
pub use integrate::{Counts, Crossing, Direction, Integrator, Reached, Steps};
pub use leakage::Leakage;
pub use method::Method;
pub use network::{Link, Network, Node};
pub use steady::{LongRun, long_run};
