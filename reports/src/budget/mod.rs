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
//! scene = "cornell"                    # optional, as gpu, technique and frame: only for frames with these
//! group = "memory"                     # optional: what it is told with
//! pass = "primary rays"                # optional; without it, the whole frame
//! hard = { max_increase = "5 %" }      # against a baseline report; a number is in the counter's unit
//! ```
//!
//! A budget may name the frames that it is for, with options of `raybudget profile`; else it is for whatever is checked.
//!
//! ```toml
//! [base]                               # options of all frames
//! size = "256x256"
//!
//! [[frame]]
//! name = "cornell on a Mali"
//! scene = "cornell"
//! gpu = "mali-g715"
//! ```
//!
//! The rules are `max`, `min`, `max_increase` and `max_decrease`, and `min_increase` and `min_decrease` for an improvement that is
//! asked for; `soft` and `hard` may hold any of them. A figure that equals its limit keeps it. Unknown keys and counters are refused
//! with their line.

mod annotations;
mod baseline;
mod check;
mod file;
mod junit;
mod markdown;
mod table;
mod why;

pub use annotations::annotations;
pub use baseline::{Accepted, AcceptedFrame, Baseline};
pub use check::{Checked, CheckedFrame, Outcome, Row, Severity};
pub use file::{Budget, BudgetFrame, Change, Limit, RawOptions, Rule, Selection};
pub use junit::junit;
pub use markdown::markdown;
pub use table::{csv_text, json_text, text};
pub use why::{Cause, Why};
