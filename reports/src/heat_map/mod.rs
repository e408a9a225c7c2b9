//! Heat maps as PNG, one or several side by side, with their scale: a colour bar with ticks, the unit, the range, and what
//! was clamped.
//!
//! The scale starts at 0 and is linear. It ends at a stated percentile of the values, so that a few extreme pixels do
//! not flatten the rest; pixels above it take the last colour, and the caption says how many they are. Maps side by side
//! share one scale. Colours come from viridis: perceptually ordered and safe for the colour-blind.

mod page;
mod scale;

use crate::picture::TEXT;
use std::fmt;

/// Values per pixel, row by row, and what they are.
#[derive(Clone, Debug)]
pub struct HeatMap<'a> {
    /// What is shown, such as "Node fetches per pixel".
    pub title: String,
    /// Of which frame.
    pub subtitle: String,
    /// Unit of a value, such as "fetches".
    pub unit: String,
    /// Pixels per row.
    pub width: u32,
    /// `width * height` values.
    pub values: &'a [u32],
    /// The percentile at which the scale ends, above 0 and at most 100.
    pub clamp_percentile: f64,
}

/// Maps of the same size on one common scale, in one picture.
#[derive(Clone, Debug)]
pub struct Panels<'a> {
    /// What is shown, such as "Node fetches per pixel".
    pub title: String,
    /// Of which frame.
    pub subtitle: String,
    /// Unit of a value, such as "fetches".
    pub unit: String,
    /// Pixels per row of each map.
    pub width: u32,
    /// The maps, in reading order.
    pub panels: Vec<Panel<'a>>,
    /// Maps side by side, at most.
    pub columns: usize,
    /// The percentile of all values together at which the scale ends, above 0 and at most 100.
    pub clamp_percentile: f64,
}

/// One of several maps.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// What this one shows, such as a traversal.
    pub label: String,
    /// `width * height` values.
    pub values: &'a [u32],
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unpaintable(String);

impl fmt::Display for Unpaintable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unpaintable {}

/// Longer side of a map in pixels: smaller ones are enlarged by the whole factor that reaches it.
const LEAST_SIDE: u32 = 512;
/// Longer side of each of several maps: larger ones are reduced by a whole factor, smaller ones enlarged.
const PANEL_SIDE: u32 = 512;

/// One map as the bytes of a PNG file, a pixel or more for each value.
///
/// # Errors
/// When there are no values, or not a whole number of rows.
pub fn write_png(map: &HeatMap<'_>) -> Result<Vec<u8>, Unpaintable> {
    let height = rows(map.width, map.values)?;
    let page = page::Page {
        title: &map.title,
        subtitle: &map.subtitle,
        unit: &map.unit,
        size: [map.width, height],
        maps: &[map.values],
        labels: &[],
        columns: 1,
        clamp_percentile: map.clamp_percentile,
        zoom: page::Zoom { enlarge: LEAST_SIDE.div_ceil(map.width.max(height)), reduce: 1 },
        text: TEXT,
    };
    page.png()
}

/// Several maps as the bytes of a PNG file. Maps above 512 pixels are reduced: a pixel is then the mean of a square of
/// values, and the caption says so.
///
/// # Errors
/// When there is no map, one has no values, one has not a whole number of rows, they differ in size, or there are no
/// columns.
pub fn write_panels_png(panels: &Panels<'_>) -> Result<Vec<u8>, Unpaintable> {
    let [first, others @ ..] = panels.panels.as_slice() else {
        return Err(Unpaintable("no map to paint: expected at least one panel".to_owned()));
    };
    if panels.columns == 0 {
        return Err(Unpaintable("maps in 0 columns: expected at least one column".to_owned()));
    }
    let height = rows(panels.width, first.values)?;
    if let Some(odd) = others.iter().find(|other| other.values.len() != first.values.len()) {
        return Err(Unpaintable(format!(
            "map \"{}\" has {} values and map \"{}\" {}: maps on one page have the same size",
            first.label,
            first.values.len(),
            odd.label,
            odd.values.len()
        )));
    }
    let side = panels.width.max(height);
    let columns = panels.columns.min(panels.panels.len());
    let page = page::Page {
        title: &panels.title,
        subtitle: &panels.subtitle,
        unit: &panels.unit,
        size: [panels.width, height],
        maps: &panels.panels.iter().map(|panel| panel.values).collect::<Vec<_>>(),
        labels: &panels.panels.iter().map(|panel| panel.label.as_str()).collect::<Vec<_>>(),
        columns,
        clamp_percentile: panels.clamp_percentile,
        zoom: page::Zoom { enlarge: (PANEL_SIDE / side).max(1), reduce: side.div_ceil(PANEL_SIDE) },
        // A wide page is looked at from further away.
        text: TEXT * columns.clamp(2, 4) as i32 / 2,
    };
    page.png()
}

/// Rows of a map of that width.
fn rows(width: u32, values: &[u32]) -> Result<u32, Unpaintable> {
    if width == 0 || values.is_empty() || !values.len().is_multiple_of(width as usize) {
        return Err(Unpaintable(format!(
            "{} values do not fill rows of {width} pixels: expected at least one whole row",
            values.len(),
        )));
    }
    let rows = u32::try_from(values.len() / width as usize).ok().filter(|&rows| rows.max(width) <= MOST_SIDE);
    rows.ok_or_else(|| {
        Unpaintable(format!("more than {MOST_SIDE} rows or columns of pixels: expected a smaller frame"))
    })
}

/// What a picture's side may be, so that places fit into 32 bits.
const MOST_SIDE: u32 = 1 << 24;
