//! Options of sweeps.

use super::{Format, RunArgs};
use clap::Args;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct SweepArgs {
    /// What to vary: a grid or a list of options of `profile`.
    #[arg(value_name = "SWEEP.toml")]
    pub(crate) plan: PathBuf,
    /// Write a file for each point as soon as it is known, and at the end the table, the Pareto front and charts, into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Go on with a sweep that ended early: points that are in the folder are not replayed again.
    #[arg(long)]
    pub(crate) resume: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
