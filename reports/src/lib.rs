//! Reports of ray-tracing cost estimates: one [`Report`], many writers.
//!
//! [`text`] is for people, [`html`] for people with a browser, [`json`] and [`csv_table`] for programs, [`heat_map`], [`chart`] and [`image`](mod@image) for eyes, [`comparison`] for several
//! reports side by side, [`vendor`] for the names of the makers' profilers, [`budget`] for gates, [`claims`] for statements of others,
//! [`hardware`] for measurements of others, [`sweep`] for many frames that differ in their options, [`accuracy`] for one rung of fidelity against another, [`stability`](mod@stability) for the
//! suite of numerical stability, [`thermal`](mod@thermal) for integrators of temperatures, [`timeline`] for the Perfetto UI. Every writer takes the same value, so that no
//! two of them can disagree. A counter that a scene or a GPU does not have keeps the reason for its absence through all of
//! them. The crate writes into memory and never prints.

pub mod accuracy;
pub mod budget;
pub mod chart;
pub mod claims;
mod columns;
pub mod comparison;
mod counters;
pub mod coverage;
mod csv_rows;
pub mod csv_table;
mod error;
mod forced;
mod from_estimate;
pub mod hardware;
pub mod heat_map;
pub mod html;
pub mod image;
pub mod json;
pub mod lane_use;
mod picture;
mod report;
pub mod sampling;
pub mod stability;
pub mod sustained;
pub mod sweep;
pub mod text;
pub mod thermal;
pub mod timeline;
pub mod two_eyes;
mod units;
pub mod vendor;
mod within;

pub use counters::{Counter, Counters, Fidelity, Value};
pub use error::Error;
pub use from_estimate::SceneFacts;
pub use report::{
    Bound, Buffer, Energy, EnergyCause, Forced, Hashes, Inputs, LeftOut, LevelTraffic, Pass, Report, Run,
    SCHEMA, TimePart, Traffic,
};
pub use units::digits;
pub use within::{Recorded, Within};
