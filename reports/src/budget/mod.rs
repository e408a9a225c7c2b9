//! Budgets: limits on counters, and whether a report keeps them.
//!
//! ```toml
//! [[limit]]
//! counter = "frame_time_ms"            # an id of `raybudget list counters`
//! soft = { max = 14.0 }                # broken: a warning
//! hard = { max = 16.6 }                # broken: the check fails
//!
//! [[limit]]
//! counter = "dram_read_bytes"
//! pass = "primary"                     # optional; without it, the whole frame
//! hard = { max_increase = "5 %" }      # against a baseline report; a number is in the counter's unit
//! ```
//!
//! The rules are `max`, `min`, `max_increase` and `max_decrease`; `soft` and `hard` may hold any of them. A figure that
//! equals its limit keeps it. Unknown keys and counters are refused with their line.

mod check;
mod file;
mod table;

pub use check::{Checked, Outcome, Row, Severity};
pub use file::{Budget, Change, Limit, Rule};
pub use table::{csv_text, json_text, text};
