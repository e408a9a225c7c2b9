//! What all pictures share: a sheet of marks that becomes SVG or PNG, one font, one colour ramp, round ticks.
//!
//! A picture is first a list of marks at fixed places ([`Sheet`]), so that a test can ask whether two labels overlap;
//! the backends of plotters then draw it. Places are pixels from the top left corner.

mod bar;
mod canvas;
pub(crate) mod legend;
pub(crate) mod lettering;
mod panels;
pub(crate) mod ramp;
mod sheet;
pub(crate) mod ticks;

pub(crate) use bar::ColourBar;
pub(crate) use canvas::{Canvas, encode_png};
#[cfg(test)]
pub(crate) use panels::LEAST_SIDE;
pub(crate) use panels::{PanelGrid, Zoom, text_height};
pub(crate) use sheet::{Across, Down, Label, Sheet};

/// Red, green, blue, 8 bits each, sRGB.
pub type Rgb = [u8; 3];

pub(crate) const BACKGROUND: Rgb = [255, 255, 255];
/// Text and axes.
pub(crate) const INK: Rgb = [24, 24, 24];
/// What explains, and what is missing.
pub(crate) const FAINT: Rgb = [96, 96, 96];
/// Pixels of a map that have no figure.
pub(crate) const UNPAINTED: Rgb = [200, 200, 200];
/// Grid lines.
pub(crate) const GRID: Rgb = [222, 222, 222];

/// Height of text, where a picture has no reason for another.
pub(crate) const TEXT: i32 = 14;
/// Height of figures in a plot.
pub(crate) const SMALL: i32 = 12;
/// Space around everything.
pub(crate) const MARGIN: i32 = 16;

#[cfg(test)]
pub(crate) use sheet::{Mark, tests};
