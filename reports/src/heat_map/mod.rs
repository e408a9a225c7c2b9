//! Heat maps as PNG, one or several side by side, with their scale: a colour bar with ticks, the unit, the range, and what
//! was clamped.
//!
//! The scale starts at 0 and is linear. It ends at a given value, or at a stated percentile of the values, so that a few extreme pixels do
//! not flatten the rest; pixels above it take the last colour, and the caption says how many they are. Maps side by side
//! share one scale. Pixels without a value ([`NO_VALUE`]) are grey and count nowhere. Colours come from viridis: perceptually ordered and safe for the colour-blind.

mod page;
pub(crate) mod scale;

use crate::picture::{TEXT, Zoom, text_height};
use std::fmt;

/// In the place of the value of a pixel that has none.
pub const NO_VALUE: u32 = u32::MAX;

/// Where a scale ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScaleEnd {
    /// At this percentile of the values of all maps together, above 0 and at most 100.
    Percentile(f64),
    /// At this value, above 0.
    Value(u32),
}

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
    /// `width * height` values, or [`NO_VALUE`].
    pub values: &'a [u32],
    /// Where the scale ends.
    pub end: ScaleEnd,
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
    /// Where the common scale ends.
    pub end: ScaleEnd,
}

/// One of several maps.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// What this one shows, such as a traversal.
    pub label: String,
    /// `width * height` values, or [`NO_VALUE`].
    pub values: &'a [u32],
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unpaintable(pub(crate) String);

impl fmt::Display for Unpaintable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unpaintable {}

/// One map as the bytes of a PNG file, a pixel or more for each value.
///
/// # Errors
/// When there are no values, or not a whole number of rows.
pub fn write_png(map: &HeatMap<'_>) -> Result<Vec<u8>, Unpaintable> {
    let height = rows(map.width, map.values.len())?;
    let page = page::Page {
        title: &map.title,
        subtitle: &map.subtitle,
        unit: &map.unit,
        size: [map.width, height],
        maps: &[map.values],
        labels: &[],
        columns: 1,
        end: map.end,
        zoom: Zoom::of_single([map.width, height]),
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
    let sizes = panels.panels.iter().map(|panel| (panel.label.as_str(), panel.values.len()));
    let height = rows_of_all(panels.width, sizes, panels.columns)?;
    let columns = panels.columns.min(panels.panels.len());
    let page = page::Page {
        title: &panels.title,
        subtitle: &panels.subtitle,
        unit: &panels.unit,
        size: [panels.width, height],
        maps: &panels.panels.iter().map(|panel| panel.values).collect::<Vec<_>>(),
        labels: &panels.panels.iter().map(|panel| panel.label.as_str()).collect::<Vec<_>>(),
        columns,
        end: panels.end,
        zoom: Zoom::of_several([panels.width, height]),
        text: text_height(columns),
    };
    page.png()
}

/// Rows of maps of that width, labels and numbers of values, which share a page.
pub(crate) fn rows_of_all<'a>(
    width: u32,
    mut sizes: impl Iterator<Item = (&'a str, usize)>,
    columns: usize,
) -> Result<u32, Unpaintable> {
    let Some((label, values)) = sizes.next() else {
        return Err(Unpaintable("no map to paint: expected at least one panel".to_owned()));
    };
    if columns == 0 {
        return Err(Unpaintable("maps in 0 columns: expected at least one column".to_owned()));
    }
    match sizes.find(|&(_, others)| others != values) {
        Some((odd, others)) => Err(Unpaintable(format!(
            "map \"{label}\" has {values} values and map \"{odd}\" {others}: maps on one page have the same size"
        ))),
        None => rows(width, values),
    }
}

/// Rows of a map of that width.
pub(crate) fn rows(width: u32, values: usize) -> Result<u32, Unpaintable> {
    if width == 0 || values == 0 || !values.is_multiple_of(width as usize) {
        return Err(Unpaintable(format!(
            "{values} values do not fill rows of {width} pixels: expected at least one whole row"
        )));
    }
    let rows = u32::try_from(values / width as usize).ok().filter(|&rows| rows.max(width) <= MOST_SIDE);
    rows.ok_or_else(|| {
        Unpaintable(format!("more than {MOST_SIDE} rows or columns of pixels: expected a smaller frame"))
    })
}

/// What a picture's side may be, so that places fit into 32 bits.
const MOST_SIDE: u32 = 1 << 24;
