//! Options of budgets.

use super::{FrameArgs, MachineArgs, RunArgs};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// What to check: a scene to profile as `profile` does, or a finished report (.json); not where the budget names its frames [default: atrium].
    #[arg(value_name = "SCENE|REPORT.json")]
    pub(crate) subject: Option<String>,
    /// The limits.
    #[arg(long, value_name = "BUDGET.toml")]
    pub(crate) budget: PathBuf,
    /// What limits on changes are held against: an earlier report (.json), or figures that were accepted (.toml); where there is no such file,
    /// nothing is compared.
    #[arg(long, value_name = "BASELINE.json|.toml")]
    pub(crate) baseline: Option<PathBuf>,
    /// Write the figures of the counters that the budget limits into a file to review, for --baseline; nothing is compared meanwhile.
    #[arg(long, value_name = "BASELINE.toml", conflicts_with = "baseline")]
    pub(crate) accept: Option<PathBuf>,
    /// Replay about this part of the tiles of each frame, such as 6%, and all of them only where that leaves open whether a limit is kept.
    #[arg(long, value_name = "PART", conflicts_with = "accept")]
    pub(crate) sample: Option<String>,
    /// Draws another sample [default: 0].
    #[arg(long, value_name = "N", requires = "sample")]
    pub(crate) seed: Option<u64>,
    /// Also say of what each counter with a broken limit is made, and what of that changed most against the baseline.
    #[arg(long)]
    pub(crate) why: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = CheckFormat::Text)]
    pub(crate) format: CheckFormat,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) machine: MachineArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// How the results of a check are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum CheckFormat {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
    /// For spreadsheets.
    Csv,
    /// For pull requests and summaries of jobs.
    Markdown,
    /// For test views of CI services: JUnit XML.
    Junit,
    /// For GitHub Actions: commands that annotate the budget file.
    Github,
}
