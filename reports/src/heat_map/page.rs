//! The page: heading, maps in a grid, colour bar, caption.

use super::Unpaintable;
use super::scale::{Scale, mean_and_max};
use crate::picture::{
    Across, Canvas, ColourBar, Down, FAINT, INK, Label, MARGIN, Sheet, lettering, ramp, ticks,
};
use crate::units;

/// Pixels of a map for a square of its values: at least one of the two is 1.
#[derive(Clone, Copy)]
pub(super) struct Zoom {
    /// Side in pixels of a value.
    pub(super) enlarge: u32,
    /// Side in values of a pixel.
    pub(super) reduce: u32,
}

/// One map or more of one size. Without labels nothing stands below the maps.
pub(super) struct Page<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: &'a str,
    pub(super) unit: &'a str,
    /// Values across and down.
    pub(super) size: [u32; 2],
    pub(super) maps: &'a [&'a [u32]],
    pub(super) labels: &'a [&'a str],
    pub(super) columns: usize,
    pub(super) clamp_percentile: f64,
    pub(super) zoom: Zoom,
    /// Height of the text.
    pub(super) text: i32,
}

const LEAST_WIDTH: i32 = 560;
const LEAST_BAR: i32 = 200;
/// A longer bar would not be easier to read.
const MOST_BAR: i32 = 640;
/// Space above and below the maps.
const GAP: i32 = 12;

impl Page<'_> {
    pub(super) fn png(&self) -> Result<Vec<u8>, Unpaintable> {
        let scale = Scale::of(self.maps, self.clamp_percentile);
        let (sheet, corners) = self.sheet(scale);
        let mut canvas = sheet.canvas();
        for (values, corner) in self.maps.iter().zip(corners) {
            self.paint(&mut canvas, corner, values, scale);
        }
        canvas.encode().map_err(|error| Unpaintable(format!("the picture cannot be encoded: {error}")))
    }

    /// Pixels of a map across and down.
    fn map_size(&self) -> [i32; 2] {
        self.size.map(|side| (side.div_ceil(self.zoom.reduce) * self.zoom.enlarge) as i32)
    }

    /// Everything but the maps, and the top left corners of these.
    pub(super) fn sheet(&self, scale: Scale) -> (Sheet, Vec<(i32, i32)>) {
        let text = self.text;
        let [map_width, map_height] = self.map_size();
        let columns = self.columns;
        let across = columns as i32 * (map_width + MARGIN) - MARGIN;
        let below: Vec<Vec<(String, [u8; 3])>> = self
            .labels
            .iter()
            .zip(self.maps)
            .map(|(label, values)| below(label, values, map_width, text))
            .collect();
        let row_heights: Vec<i32> = (0..self.maps.len().div_ceil(columns))
            .map(|row| {
                let lines = below.iter().skip(row * columns).take(columns).map(Vec::len).max().unwrap_or(0);
                map_height + lines as i32 * lettering::line(text)
            })
            .collect();
        let body_height = row_heights.iter().sum::<i32>() + (row_heights.len() as i32 - 1) * MARGIN;
        let bar = bar(self.unit, text, scale.end, body_height.clamp(LEAST_BAR, MOST_BAR.max(map_height)));
        let width = MARGIN + across + MARGIN + bar.width() + MARGIN;

        let mut sheet = Sheet::new(width.max(LEAST_WIDTH), text);
        sheet.heading(self.title, self.subtitle);
        sheet.height += GAP;
        let mut y = sheet.height + bar.unit_height();
        bar.paint(&mut sheet, MARGIN + across + MARGIN, y);
        let bottom = y + body_height.max(LEAST_BAR);
        let mut corners = Vec::new();
        for (row, row_height) in row_heights.into_iter().enumerate() {
            for (column, index) in (row * columns..self.maps.len()).take(columns).enumerate() {
                let x = MARGIN + column as i32 * (map_width + MARGIN);
                corners.push((x, y));
                let lines = below.get(index).into_iter().flatten();
                for (line, (words, colour)) in (0..).zip(lines) {
                    let middle =
                        y + map_height + lettering::line(text) * line + lettering::line(text) / 2 + 2;
                    let label = Label::new(words.as_str(), (x, middle), text, *colour);
                    sheet.label(label.anchored(Across::Start, Down::Middle));
                }
            }
            y += row_height + MARGIN;
        }
        sheet.height = bottom + GAP;
        sheet.paragraph(&self.caption(scale), text, FAINT);
        sheet.height += MARGIN;
        (sheet, corners)
    }

    fn paint(&self, canvas: &mut Canvas, (left, top): (i32, i32), values: &[u32], scale: Scale) {
        let Zoom { enlarge, reduce } = self.zoom;
        let [width, height] = self.size;
        let end = f64::from(scale.end);
        for row in 0..height.div_ceil(reduce) {
            for column in 0..width.div_ceil(reduce) {
                let columns = column * reduce..width.min((column + 1) * reduce);
                let rows = row * reduce..height.min((row + 1) * reduce);
                let count = f64::from(columns.len() as u32 * rows.len() as u32);
                let sum: u64 = rows
                    .flat_map(|row| {
                        let start = row as usize * width as usize;
                        &values[start + columns.start as usize..start + columns.end as usize]
                    })
                    .map(|&value| u64::from(value))
                    .sum();
                let colour = ramp::colour(sum as f64 / count / end);
                let (x, y, side) = (column * enlarge, row * enlarge, enlarge as i32);
                canvas.fill(left + x as i32, top + y as i32, side, side, colour);
            }
        }
    }

    fn caption(&self, Scale { end, clamped }: Scale) -> String {
        let end = units::grouped(u64::from(end));
        let mut text = match self.maps {
            [values] => {
                let (mean, max) = mean_and_max(values);
                let (mean, max) = (units::digits(mean), units::grouped(u64::from(max)));
                format!("Linear scale, 0 to {end} {}; mean {mean}, max {max}.", self.unit)
            }
            _ => format!("One linear scale for all maps, 0 to {end} {}.", self.unit),
        };
        if clamped > 0.0 {
            text += &format!(
                " The scale ends at percentile {}: {} % of the pixels lie above it and take the last colour.",
                self.clamp_percentile,
                units::digits(clamped * 100.0)
            );
        } else {
            text += " No pixel lies above the scale.";
        }
        if self.zoom.reduce > 1 {
            let side = self.zoom.reduce;
            text += &format!(
                " Maps are reduced: a pixel shows the mean of {side} x {side} pixels of the frame; scale, means and \
                 maxima are those of the whole frame."
            );
        }
        text
    }
}

/// What stands below a map: its label, mean and largest value.
fn below(label: &str, values: &[u32], width: i32, height: i32) -> Vec<(String, [u8; 3])> {
    let (mean, max) = mean_and_max(values);
    let figures = format!("mean {}, max {}", units::digits(mean), units::grouped(u64::from(max)));
    let lines = |text: &str, colour| {
        lettering::wrap(text, width, height).into_iter().map(move |line| (line, colour)).collect::<Vec<_>>()
    };
    [lines(label, INK), lines(&figures, FAINT)].concat()
}

fn bar(unit: &str, text: i32, end: u32, height: i32) -> ColourBar {
    let label = |value: f64| (value / f64::from(end), units::grouped(value as u64));
    let round = ticks::linear(0.0, f64::from(end), 8, 1.0);
    ColourBar::new(unit, height, text, round.into_iter().map(label), [label(f64::from(end))])
}

#[cfg(test)]
mod tests {
    use super::super::*;
    use super::*;
    use crate::picture::tests::assert_legible;

    fn page<'a>(unit: &'a str, size: [u32; 2], maps: &'a [&'a [u32]], labels: &'a [&'a str]) -> Page<'a> {
        Page {
            title: "A title that is long enough to need more than one line of a narrow picture, as some are",
            subtitle: "a scene, 1024x1024, primary + shadow rays",
            unit,
            size,
            maps,
            labels,
            columns: 3,
            clamp_percentile: 99.0,
            zoom: Zoom { enlarge: 1, reduce: 4 },
            text: 14,
        }
    }

    #[test]
    fn no_label_is_clipped_or_meets_another() {
        let names = ["kd push-down with a short stack of 4 entries and a restart trail", "b", "c", "d"];
        for (side, value) in [(40, 0), (40, 7), (2000, 12), (40, u32::MAX), (3, 1_234_567)] {
            let values = vec![value; side * side];
            for count in 1..=4 {
                let maps = vec![values.as_slice(); count];
                let size = [side as u32; 2];
                for unit in ["B", "misses of the second level"] {
                    let page = page(unit, size, &maps, &names[..count]);
                    assert_legible(&page.sheet(Scale::of(&maps, 99.0)).0);
                }
            }
        }
    }

    #[test]
    fn the_caption_says_what_was_clamped_and_reduced() {
        let values: Vec<u32> = (1..=1000).collect();
        let maps = [values.as_slice(), &values];
        let text = page("fetches", [10, 100], &maps, &["a", "b"]).caption(Scale::of(&maps, 99.0));
        assert!(text.starts_with("One linear scale for all maps, 0 to 990 fetches."), "{text}");
        assert!(text.contains("percentile 99: 1.000 % of the pixels"), "{text}");
        assert!(text.contains("mean of 4 x 4 pixels"), "{text}");
        let single = page("fetches", [10, 100], &maps[..1], &[]).caption(Scale::of(&maps[..1], 100.0));
        assert!(single.contains("mean 500.5, max 1,000. No pixel"), "{single}");
    }

    struct Picture {
        width: u32,
        height: u32,
        pixels: Vec<u8>,
    }

    impl Picture {
        fn of(bytes: Vec<u8>) -> Self {
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
            let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
            let info = reader.next_frame(&mut pixels).expect("a whole PNG");
            Self { width: info.width, height: info.height, pixels }
        }

        /// Pixels of the colour at a part of the scale.
        fn count(&self, part: f64) -> usize {
            self.pixels.chunks_exact(3).filter(|pixel| *pixel == ramp::colour(part)).count()
        }
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
        let picture = Picture::of(write_png(&map).expect("a small picture"));
        let zoomed = LEAST_SIDE as usize / 2 * (LEAST_SIDE as usize / 2);
        assert!(picture.width >= LEAST_WIDTH as u32 && picture.height > LEAST_SIDE);
        assert!(picture.count(0.0) >= zoomed && picture.count(0.5) >= zoomed);
        assert!(picture.count(1.0) >= 2 * zoomed);
    }

    fn panels<'a>(width: u32, maps: &[&'a [u32]]) -> Panels<'a> {
        let panel = |values| Panel { label: "a map".into(), values };
        Panels {
            title: "t".into(),
            subtitle: "s".into(),
            unit: "fetches".into(),
            width,
            panels: maps.iter().copied().map(panel).collect(),
            columns: 2,
            clamp_percentile: 100.0,
        }
    }

    #[test]
    fn several_maps_are_coloured_by_one_scale() {
        let (low, high) = (vec![10; 512 * 512], vec![20; 512 * 512]);
        let picture = Picture::of(write_panels_png(&panels(512, &[&low, &high])).expect("a picture"));
        assert!(picture.width >= 2 * 512);
        assert!(picture.count(0.5) >= 512 * 512 && picture.count(1.0) >= 512 * 512);
    }

    #[test]
    fn a_reduced_map_shows_means() {
        // Columns of 0 and 20 in turn: the mean of any square of 2 x 2 is 10.
        let stripes: Vec<u32> = (0..1024 * 1024).map(|index| index % 2 * 20).collect();
        let picture = Picture::of(write_panels_png(&panels(1024, &[&stripes])).expect("a picture"));
        assert!(picture.count(0.5) >= 512 * 512);
        assert!(picture.count(0.0) < 512 && picture.count(1.0) < 512);
        // An odd side: the last square holds fewer values.
        let flat = vec![20; 1025 * 3];
        let picture = Picture::of(write_panels_png(&panels(1025, &[&flat])).expect("a picture"));
        assert!(picture.count(1.0) >= 342);
    }

    #[test]
    fn the_same_maps_give_the_same_bytes() {
        let values: Vec<u32> = (0..64 * 64).collect();
        let bytes = || write_panels_png(&panels(64, &[&values, &values])).expect("a picture");
        assert_eq!(bytes(), bytes());
    }

    #[test]
    fn maps_that_make_no_page_are_refused() {
        let (three, four) = ([1, 2, 3], [1, 2, 3, 4]);
        assert!(write_panels_png(&panels(1, &[])).is_err());
        assert!(write_panels_png(&panels(0, &[&three])).is_err());
        assert!(write_panels_png(&panels(2, &[&three])).is_err());
        assert!(write_panels_png(&panels(1, &[&three, &four])).is_err());
        assert!(write_panels_png(&Panels { columns: 0, ..panels(1, &[&three]) }).is_err());
        assert!(write_panels_png(&panels(1, &[&three, &three])).is_ok());
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
