//! What is asked of a phone that warms.

use super::Format;
use clap::Args;
use std::path::PathBuf;

/// A load on a phone that warms.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Warm phone")]
pub(crate) struct SustainedArgs {
    /// Draw the frame again and again for that long, such as 10min, on a phone whose governor lowers the GPU's clock where it is too warm; also
    /// replays the frame at each of these clocks.
    #[arg(long, value_name = "TIME")]
    pub(crate) sustained: Option<String>,
    /// A file that describes the phone, instead of the built-in one.
    #[arg(long, value_name = "FILE", requires = "sustained")]
    pub(crate) phone: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct ThermalArgs {
    /// Fixed steps from a millisecond instead of a tenth of one.
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
    /// Also write the tables, and charts of error against run time and length of step, into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
