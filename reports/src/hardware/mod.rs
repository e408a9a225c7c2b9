//! Measurements of real GPUs, as data, and how near the model comes to them.
//!
//! A row names an access pattern, a GPU, a quantity and what was published. [`Row::judge`] compares; [`Summary`] holds the limits
//! on means. The probes themselves are [`gpumodel::kernel`]'s, and this module runs none of them.

mod chart;
mod file;
mod power;
mod summary;
mod verdict;
mod write;

pub use chart::charts;
pub use file::{Apart, Kind, MEASUREMENTS, Published, Quantity, Row, parse};
pub use power::set_interface_rate;
pub use summary::{Group, Summary};
pub use verdict::{Figure, Found, RowVerdict};
pub use write::{csv_text, json_text, markdown, text};
