//! Charts as SVG and as PNG, from one description: grouped bars, a matrix over two parameters, errors against run time, and
//! figures over time.
//!
//! A picture grows with its content until every label has its place: nothing is cut off, and nothing covers anything else.
//! Series are told apart by the colours of Okabe and Ito (2008), safe for the colour-blind; a matrix is coloured by
//! viridis. The same description gives the same bytes.

mod axis;
mod bars;
mod log_log;
mod matrix;
mod palette;
mod time_series;

pub use bars::{BarChart, Scale, Series};
pub use log_log::{LogLogChart, LogLogSeries};
pub use matrix::MatrixChart;
pub(crate) use palette::{BLUE, MOST as MOST_SERIES, SKY_BLUE, VERMILION, YELLOW, colour as series_colour};
pub use time_series::{TimePanel, TimeSeries, TimeSeriesChart};

use crate::error::Error;
use crate::picture::Sheet;

/// What stands in the place of a figure that there is not.
const ABSENT: &str = "n/a";

/// Why a chart called `title` cannot be drawn.
fn refuse(title: &str, problem: impl Into<String>, remedy: &str) -> Error {
    Error::new(format!("chart \"{title}\""), problem, remedy)
}

/// A finite figure, or none.
fn checked(title: &str, value: Option<f64>, least: f64) -> Result<(), Error> {
    match value {
        Some(value) if !value.is_finite() => {
            Err(refuse(title, format!("{value} is no finite number"), "give no value where there is none"))
        }
        Some(value) if value < least => {
            Err(refuse(title, format!("{value} is negative"), "bars show values of 0 and above"))
        }
        _ => Ok(()),
    }
}

fn png(title: &str, sheet: &Sheet) -> Result<Vec<u8>, Error> {
    let encoded = sheet.canvas().encode();
    encoded.map_err(|error| {
        refuse(title, format!("the picture cannot be encoded: {error}"), "write SVG instead")
    })
}
