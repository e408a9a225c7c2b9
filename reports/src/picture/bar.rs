//! The colour bar of a scale: its unit, the ramp from bottom to top, ticks.

use super::sheet::{Across, Down, Label, Sheet};
use super::{INK, lettering, ramp};

const WIDTH: i32 = 24;
const TICK: i32 = 6;
const GAP: i32 = 4;

/// A colour bar.
pub(crate) struct ColourBar {
    unit: String,
    height: i32,
    text: i32,
    /// Part of the scale, 0 at the bottom, and what stands there.
    labels: Vec<(f64, String)>,
}

impl ColourBar {
    /// A bar with labels for `round` parts of the scale and for its `ends`; round ones that would touch an end's are
    /// left out.
    pub(crate) fn new(
        unit: &str,
        height: i32,
        text: i32,
        round: impl IntoIterator<Item = (f64, String)>,
        ends: impl IntoIterator<Item = (f64, String)>,
    ) -> Self {
        let ends: Vec<(f64, String)> = ends.into_iter().collect();
        let room = f64::from(lettering::line(text)) * 1.2 / f64::from(height);
        let apart = |part: f64| ends.iter().all(|(end, _)| (end - part).abs() >= room);
        let mut labels: Vec<_> = round.into_iter().filter(|(part, _)| apart(*part)).collect();
        labels.extend(ends);
        Self { unit: unit.to_owned(), height, text, labels }
    }

    /// Width with the labels and the unit.
    pub(crate) fn width(&self) -> i32 {
        let label = self.labels.iter().map(|(_, text)| lettering::width(text, self.text)).max();
        (WIDTH + TICK + GAP + label.unwrap_or(0)).max(lettering::width(&self.unit, self.text))
    }

    /// Height of the line above the bar that holds the unit.
    pub(crate) fn unit_height(&self) -> i32 {
        lettering::line(self.text) + GAP
    }

    /// Adds the bar, its top left corner at (`left`, `top`), and the unit above it.
    pub(crate) fn paint(&self, sheet: &mut Sheet, left: i32, top: i32) {
        sheet.label(Label::new(self.unit.as_str(), (left, top - self.unit_height()), self.text, INK));
        for row in 0..self.height {
            let part = 1.0 - (f64::from(row) + 0.5) / f64::from(self.height);
            sheet.fill((left, top + row), (WIDTH, 1), ramp::colour(part));
        }
        sheet.frame((left, top), (WIDTH, self.height), INK);
        for (part, text) in &self.labels {
            let y = top + ((1.0 - part) * f64::from(self.height - 1)).round() as i32;
            sheet.fill((left + WIDTH, y), (TICK, 1), INK);
            let text_y = y.clamp(top + self.text / 2, top + self.height - self.text / 2);
            let at = (left + WIDTH + TICK + GAP, text_y);
            sheet.label(Label::new(text.as_str(), at, self.text, INK).anchored(Across::Start, Down::Middle));
        }
    }
}
