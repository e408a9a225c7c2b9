//! Coverage maps as PNG: where the reflection of each pixel comes from, with a legend and shares (as in Calvo Lista, "Ray Tracing in Mobile
//! Games", Vulkanised 2026). Colours are those of Okabe and Ito 2008 and grey, which the colour-blind can tell apart.

use crate::chart::{BLUE, SKY_BLUE, VERMILION, YELLOW};
use crate::heat_map::{Unpaintable, rows_of_all};
use crate::picture::{FAINT, INK, MARGIN, PanelGrid, Rgb, Sheet, Zoom, legend, text_height};
use gpumodel::reflections::Coverage;

/// Maps of one size in one picture.
#[derive(Clone, Debug)]
pub struct CoverageMaps<'a> {
    /// What is shown.
    pub title: String,
    /// Of which frame.
    pub subtitle: String,
    /// Pixels per row of each map.
    pub width: u32,
    /// The maps, in reading order.
    pub panels: Vec<CoveragePanel<'a>>,
    /// Maps side by side, at most.
    pub columns: usize,
}

/// One of them.
#[derive(Clone, Debug)]
pub struct CoveragePanel<'a> {
    /// What this one shows, such as a way of marching; a map that is alone needs none.
    pub label: String,
    /// Row by row from the top left.
    pub coverage: &'a [Coverage],
}

/// In the order of their declaration, and of the legend.
pub(crate) const ALL: [Coverage; 5] =
    [Coverage::Screen, Coverage::QueryHit, Coverage::QueryMiss, Coverage::Fallback, Coverage::NoSurface];
const LEAST_WIDTH: i32 = 560;
/// Space above and below the maps.
const GAP: i32 = 12;

pub(crate) fn name(coverage: Coverage) -> &'static str {
    match coverage {
        Coverage::Screen => "screen",
        Coverage::QueryHit => "ray query, hit",
        Coverage::QueryMiss => "ray query, sky",
        Coverage::Fallback => "too rough, fallback",
        Coverage::NoSurface => "no surface",
    }
}

pub(crate) fn colour(coverage: Coverage) -> Rgb {
    match coverage {
        Coverage::Screen => YELLOW,
        Coverage::QueryHit => BLUE,
        Coverage::QueryMiss => SKY_BLUE,
        Coverage::Fallback => VERMILION,
        Coverage::NoSurface => [64, 64, 64],
    }
}

/// Pixels of each class, in the order of the legend.
fn counts(coverage: impl Iterator<Item = Coverage>) -> [usize; ALL.len()] {
    let mut counts = [0; ALL.len()];
    coverage.for_each(|of_pixel| counts[of_pixel as usize] += 1);
    counts
}

/// The share of each class in per cent, with one decimal, in the order of the legend.
fn shares(coverage: &[Coverage]) -> [String; ALL.len()] {
    counts(coverage.iter().copied())
        .map(|count| format!("{:.1} %", 100.0 * count as f64 / coverage.len() as f64))
}

/// The maps as the bytes of a PNG file. Maps above 512 pixels side by side are reduced: a pixel then shows what most of its square are, and the
/// caption says so.
///
/// # Errors
/// When there is no map, one has no values, one has not a whole number of rows, they differ in size, or there are no columns.
pub fn write_png(maps: &CoverageMaps<'_>) -> Result<Vec<u8>, Unpaintable> {
    let sizes = maps.panels.iter().map(|panel| (panel.label.as_str(), panel.coverage.len()));
    let size = [maps.width, rows_of_all(maps.width, sizes, maps.columns)?];
    let zoom = if maps.panels.len() == 1 { Zoom::of_single(size) } else { Zoom::of_several(size) };
    let (sheet, corners) = sheet(maps, zoom, size);
    let mut canvas = sheet.canvas();
    for (panel, (left, top)) in maps.panels.iter().zip(corners) {
        zoom.squares(size, |(x, y), side, places| {
            let counts = counts(places.map(|place| panel.coverage[place]));
            // Of equals, the first in the legend.
            let most = (0..ALL.len()).rev().max_by_key(|&class| counts[class]).unwrap_or(0);
            canvas.fill(left + x, top + y, side, side, colour(ALL[most]));
        });
    }
    canvas.encode().map_err(|error| Unpaintable(format!("the picture cannot be encoded: {error}")))
}

/// Everything but the maps, and the top left corners of these.
fn sheet(maps: &CoverageMaps<'_>, zoom: Zoom, size: [u32; 2]) -> (Sheet, Vec<(i32, i32)>) {
    let columns = maps.columns.min(maps.panels.len());
    let text = text_height(columns);
    let pixels = zoom.pixels(size);
    let alone = maps.panels.len() == 1;
    let below = |panel: &CoveragePanel<'_>| {
        let label = PanelGrid::lines(&panel.label, pixels[0], text, INK);
        let shares = shares(panel.coverage);
        let shares: Vec<String> =
            ALL.iter().zip(&shares).map(|(&class, share)| format!("{} {share}", name(class))).collect();
        let shares =
            if alone { Vec::new() } else { PanelGrid::lines(&shares.join("; "), pixels[0], text, FAINT) };
        [label, shares].concat()
    };
    let panels = PanelGrid { size: pixels, columns, text, below: maps.panels.iter().map(below).collect() };
    let mut sheet = Sheet::new((panels.width() + 2 * MARGIN).max(LEAST_WIDTH), text);
    sheet.heading(&maps.title, &maps.subtitle);
    let top = sheet.height + GAP;
    let corners = panels.place(&mut sheet, MARGIN, top);
    sheet.height = top + panels.height() + GAP;
    let names: Vec<String> = match maps.panels.as_slice() {
        [panel] => ALL
            .iter()
            .zip(shares(panel.coverage))
            .map(|(&class, share)| format!("{}: {share}", name(class)))
            .collect(),
        _ => ALL.map(|class| name(class).to_owned()).into(),
    };
    // A swatch is as high as the text.
    legend::paint(&mut sheet, names.iter().map(String::as_str), text, |sheet, (x, y), class| {
        sheet.fill((x, y - text / 2), (text, text), colour(ALL[class]));
        sheet.frame((x, y - text / 2), (text, text), INK);
    });
    if zoom.reduce > 1 {
        let side = zoom.reduce;
        let reduced = format!(
            "Maps are reduced: a pixel shows what most of {side} x {side} pixels of the frame are; shares are those of the whole frame."
        );
        sheet.paragraph(&reduced, text, FAINT);
    }
    sheet.height += MARGIN;
    (sheet, corners)
}

#[cfg(test)]
mod tests;
