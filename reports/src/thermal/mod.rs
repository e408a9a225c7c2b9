//! Integrators of temperatures: error against run time.

mod charts;
mod table;

pub use charts::charts;
pub use table::{csv_text, json, text};
