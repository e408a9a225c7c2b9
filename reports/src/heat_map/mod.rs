//! A heat map as PNG, with its scale: a colour bar with ticks, the unit, the range, and what was clamped.
//!
//! The scale starts at 0 and is linear. It ends at a stated percentile of the values, so that a few extreme pixels do
//! not flatten the rest; pixels above it take the last colour, and the caption says how many they are. Colours come
//! from viridis: perceptually ordered and safe for the colour-blind.

mod canvas;
mod font;
mod ramp;
mod ticks;

use canvas::{Canvas, Rgb};
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

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unpaintable(String);

impl fmt::Display for Unpaintable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unpaintable {}

/// Range of a heat map's scale and of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    /// Value of the last colour; at least 1.
    end: u32,
    /// Largest value.
    max: u32,
    mean: f64,
    /// Part of the pixels above `end`.
    clamped: f64,
}

impl Scale {
    fn of(values: &[u32], percentile: f64) -> Self {
        let mut sorted = values.to_vec();
        let rank = ((values.len() as f64 * percentile / 100.0).ceil() as usize).clamp(1, values.len()) - 1;
        let (_, &mut at_rank, _) = sorted.select_nth_unstable(rank);
        let end = at_rank.max(1);
        let max = values.iter().copied().max().unwrap_or(0);
        let mean = values.iter().map(|&value| u64::from(value)).sum::<u64>() as f64 / values.len() as f64;
        let clamped = values.iter().filter(|&&value| value > end).count() as f64 / values.len() as f64;
        Self { end, max, mean, clamped }
    }
}

const MARGIN: u32 = 16;
const BAR_WIDTH: u32 = 24;
const TICK: u32 = 6;
const BACKGROUND: Rgb = [255, 255, 255];
const INK: Rgb = [24, 24, 24];
const FAINT: Rgb = [96, 96, 96];
/// Smaller maps are enlarged by a whole factor until their longer side has this many pixels.
const LEAST_SIDE: u32 = 512;
const LEAST_BAR: u32 = 200;
const LEAST_WIDTH: u32 = 560;
/// Pixels per dot of the font.
const TEXT: u32 = 2;
const TITLE: u32 = 3;
const TEXT_HEIGHT: u32 = font::ROWS * TEXT;

/// The picture as the bytes of a PNG file.
///
/// # Errors
/// When there are no values, or not a whole number of rows.
pub fn write_png(map: &HeatMap<'_>) -> Result<Vec<u8>, Unpaintable> {
    if map.width == 0 || map.values.is_empty() || !map.values.len().is_multiple_of(map.width as usize) {
        return Err(Unpaintable(format!(
            "{} values do not fill rows of {} pixels: expected at least one whole row",
            map.values.len(),
            map.width
        )));
    }
    let height = u32::try_from(map.values.len() / map.width as usize)
        .map_err(|_| Unpaintable("more than 2^32 rows of pixels".to_owned()))?;
    let canvas = paint(map, height, Scale::of(map.values, map.clamp_percentile));
    canvas.encode().map_err(|error| Unpaintable(format!("the picture cannot be encoded: {error}")))
}

fn paint(map: &HeatMap<'_>, height: u32, scale: Scale) -> Canvas {
    let zoom = LEAST_SIDE.div_ceil(map.width.max(height));
    let (map_width, map_height) = (map.width * zoom, height * zoom);
    let body_height = map_height.max(LEAST_BAR);
    let labels = labels(scale.end, body_height);
    let label_width = labels.iter().map(|(_, text)| font::width(text, TEXT)).max().unwrap_or(0);
    let bar_column = (BAR_WIDTH + TICK + 4 + label_width).max(font::width(&map.unit, TEXT));
    let width = (MARGIN + map_width + MARGIN + bar_column + MARGIN).max(LEAST_WIDTH);
    let text_width = width - 2 * MARGIN;

    let title = font::wrap(&map.title, text_width, TITLE);
    let subtitle = font::wrap(&map.subtitle, text_width, TEXT);
    let caption = font::wrap(&caption(map, scale), text_width, TEXT);
    let body_top =
        MARGIN + font::line(TITLE) * title.len() as u32 + font::line(TEXT) * subtitle.len() as u32 + 10;
    // The unit stands above the bar, on a line of its own.
    let bar_top = body_top + font::line(TEXT);
    let body_bottom = bar_top + body_height;
    let total = body_bottom + 12 + font::line(TEXT) * caption.len() as u32 + MARGIN;

    let mut canvas = Canvas::new(width, total, BACKGROUND);
    let mut y = MARGIN;
    for line in &title {
        canvas.text(MARGIN, y, line, TITLE, INK);
        y += font::line(TITLE);
    }
    for line in &subtitle {
        canvas.text(MARGIN, y, line, TEXT, FAINT);
        y += font::line(TEXT);
    }
    for (row, values) in (0..).zip(map.values.chunks_exact(map.width as usize)) {
        for (column, &value) in (0..).zip(values) {
            let colour = ramp::colour(f64::from(value.min(scale.end)) / f64::from(scale.end));
            canvas.fill(MARGIN + column * zoom, bar_top + row * zoom, zoom, zoom, colour);
        }
    }
    let bar_left = MARGIN + map_width + MARGIN;
    canvas.text(bar_left, body_top - 2, &map.unit, TEXT, INK);
    paint_bar(&mut canvas, bar_left, bar_top, body_height, scale, &labels);
    y = body_bottom + 12;
    for line in &caption {
        canvas.text(MARGIN, y, line, TEXT, FAINT);
        y += font::line(TEXT);
    }
    canvas
}

/// Round values and the end of the scale; round ones that would touch the end's label are left out.
fn labels(end: u32, bar_height: u32) -> Vec<(u32, String)> {
    let label = |value: u32| (value, value.to_string());
    let pixels_below_end = |value: u32| f64::from(end - value) / f64::from(end) * f64::from(bar_height);
    let round = ticks::ticks(end).into_iter();
    let apart = round.filter(|&tick| pixels_below_end(tick) >= f64::from(font::line(TEXT)) * 1.5);
    apart.map(label).chain([label(end)]).collect()
}

fn paint_bar(canvas: &mut Canvas, left: u32, top: u32, height: u32, scale: Scale, labels: &[(u32, String)]) {
    for row in 0..height {
        let part = 1.0 - (f64::from(row) + 0.5) / f64::from(height);
        canvas.fill(left, top + row, BAR_WIDTH, 1, ramp::colour(part));
    }
    canvas.frame(left, top, BAR_WIDTH, height, INK);
    for (value, label) in labels {
        let part = f64::from(*value) / f64::from(scale.end);
        let y = top + ((1.0 - part) * f64::from(height - 1)).round() as u32;
        canvas.fill(left + BAR_WIDTH, y, TICK, 1, INK);
        let text_y = (y.saturating_sub(TEXT_HEIGHT / 2)).clamp(top, top + height - TEXT_HEIGHT);
        canvas.text(left + BAR_WIDTH + TICK + 4, text_y, label, TEXT, INK);
    }
}

fn caption(map: &HeatMap<'_>, scale: Scale) -> String {
    let Scale { end, max, mean, clamped } = scale;
    let mut text =
        format!("Linear scale, 0 to {end} {}; mean {}, max {max}.", map.unit, crate::units::digits(mean));
    if clamped > 0.0 {
        text += &format!(
            " The scale ends at percentile {}: {} % of the pixels lie above it and take the last colour.",
            map.clamp_percentile,
            crate::units::digits(clamped * 100.0)
        );
    } else {
        text += " No pixel lies above the scale.";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_at_the_percentile_and_counts_what_lies_above() {
        let values: Vec<u32> = (1..=1000).collect();
        assert_eq!(Scale::of(&values, 99.0), Scale { end: 990, max: 1000, mean: 500.5, clamped: 0.01 });
        assert_eq!(Scale::of(&values, 100.0).clamped, 0.0);
    }

    #[test]
    fn a_black_map_still_has_a_scale() {
        assert_eq!(Scale::of(&[0, 0], 99.5), Scale { end: 1, max: 0, mean: 0.0, clamped: 0.0 });
    }

    #[test]
    fn a_picture_holds_each_value_in_its_colour() {
        let values = [0, 10, 20, 20];
        let map = HeatMap {
            title: "t".into(),
            subtitle: "s".into(),
            unit: "fetches".into(),
            width: 2,
            values: &values,
            clamp_percentile: 100.0,
        };
        let bytes = write_png(&map).expect("a small picture");
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
        let info = reader.next_frame(&mut pixels).expect("a whole PNG");
        let has = |part: f64| pixels.chunks_exact(3).filter(|pixel| *pixel == ramp::colour(part)).count();
        let zoomed = LEAST_SIDE as usize / 2 * (LEAST_SIDE as usize / 2);
        assert!(info.width >= LEAST_WIDTH && info.height > LEAST_SIDE);
        assert!(has(0.0) >= zoomed && has(0.5) >= zoomed && has(1.0) >= 2 * zoomed);
    }

    #[test]
    fn values_that_do_not_fill_rows_are_refused() {
        let map = |width, values| HeatMap {
            title: String::new(),
            subtitle: String::new(),
            unit: String::new(),
            width,
            values,
            clamp_percentile: 99.0,
        };
        assert!(write_png(&map(2, &[1, 2, 3])).is_err());
        assert!(write_png(&map(0, &[])).is_err());
        assert!(write_png(&map(3, &[1, 2, 3])).is_ok());
    }
}
