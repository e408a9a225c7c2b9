//! The page: heading, maps in a grid, colour bar, caption.

use super::scale::{Scale, mean_and_max, there};
use super::{ScaleEnd, Unpaintable};
use crate::picture::{
    Canvas, ColourBar, FAINT, INK, MARGIN, PanelGrid, Rgb, Sheet, UNPAINTED, Zoom, ramp, ticks,
};
use crate::units;

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
    pub(super) end: ScaleEnd,
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
        let scale = Scale::of(self.maps, self.end);
        let (sheet, corners) = self.sheet(scale);
        let mut canvas = sheet.canvas();
        for (values, corner) in self.maps.iter().zip(corners) {
            self.paint(&mut canvas, corner, values, scale);
        }
        canvas.encode().map_err(|error| Unpaintable(format!("the picture cannot be encoded: {error}")))
    }

    /// Everything but the maps, and the top left corners of these.
    pub(super) fn sheet(&self, scale: Scale) -> (Sheet, Vec<(i32, i32)>) {
        let text = self.text;
        let size = self.zoom.pixels(self.size);
        let lines = |(index, values): (usize, &&[u32])| {
            self.labels.get(index).map_or(Vec::new(), |label| below(label, values, size[0], text))
        };
        let below = self.maps.iter().enumerate().map(lines).collect();
        let panels = PanelGrid { size, columns: self.columns, text, below };
        let height = panels.height();
        let bar = bar(self.unit, text, scale.end, height.clamp(LEAST_BAR, MOST_BAR.max(size[1])));
        let bar_left = MARGIN + panels.width() + MARGIN;

        let mut sheet = Sheet::new((bar_left + bar.width() + MARGIN).max(LEAST_WIDTH), text);
        sheet.heading(self.title, self.subtitle);
        let top = sheet.height + GAP + bar.unit_height();
        bar.paint(&mut sheet, bar_left, top);
        let corners = panels.place(&mut sheet, MARGIN, top);
        sheet.height = top + height.max(LEAST_BAR) + GAP;
        sheet.paragraph(&self.caption(scale), text, FAINT);
        sheet.height += MARGIN;
        (sheet, corners)
    }

    fn paint(&self, canvas: &mut Canvas, (left, top): (i32, i32), values: &[u32], scale: Scale) {
        let end = f64::from(scale.end);
        self.zoom.squares(self.size, |(x, y), side, places| {
            let of_square: Vec<u32> = places.map(|place| values[place]).collect();
            let mean = mean_and_max(&of_square).map(|(mean, _)| mean);
            let colour = mean.map_or(UNPAINTED, |mean| ramp::colour(mean / end));
            canvas.fill(left + x, top + y, side, side, colour);
        });
    }

    fn caption(&self, Scale { end, clamped }: Scale) -> String {
        let end = units::grouped(u64::from(end));
        let mut text = match self.maps {
            [values] => format!("Linear scale, 0 to {end} {}; {}.", self.unit, figures(values)),
            _ => format!("One linear scale for all maps, 0 to {end} {}.", self.unit),
        };
        if clamped > 0.0 {
            if let ScaleEnd::Percentile(percentile) = self.end {
                text += &format!(" The scale ends at percentile {percentile}.");
            }
            let above = units::digits(clamped * 100.0);
            text += &format!(" {above} % of the pixels lie above it and take the last colour.");
        } else {
            text += " No pixel lies above the scale.";
        }
        let absent = self.maps.iter().any(|map| there(map).count() < map.len());
        if absent {
            text += " Grey pixels have no such figure and are not in the mean.";
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
fn below(label: &str, values: &[u32], width: i32, height: i32) -> Vec<(String, Rgb)> {
    let lines = |text: &str, colour| PanelGrid::lines(text, width, height, colour);
    [lines(label, INK), lines(&figures(values), FAINT)].concat()
}

fn figures(values: &[u32]) -> String {
    mean_and_max(values).map_or("no figures".to_owned(), |(mean, max)| {
        format!("mean {}, max {}", units::digits(mean), units::grouped(u64::from(max)))
    })
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
    use crate::picture::LEAST_SIDE;
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
            end: ScaleEnd::Percentile(99.0),
            zoom: Zoom { enlarge: 1, reduce: 4 },
            text: 14,
        }
    }

    #[test]
    fn no_label_is_clipped_or_meets_another() {
        let names = ["kd push-down with a short stack of 4 entries and a restart trail", "b", "c", "d"];
        for (side, value) in
            [(40, 0), (40, 7), (2000, 12), (40, NO_VALUE - 1), (40, NO_VALUE), (3, 1_234_567)]
        {
            let values = vec![value; side * side];
            for count in 1..=4 {
                let maps = vec![values.as_slice(); count];
                let size = [side as u32; 2];
                for unit in ["B", "misses of the second level"] {
                    let page = page(unit, size, &maps, &names[..count]);
                    assert_legible(&page.sheet(Scale::of(&maps, ScaleEnd::Percentile(99.0))).0);
                }
            }
        }
    }

    #[test]
    fn the_caption_says_what_was_clamped_and_reduced() {
        let values: Vec<u32> = (1..=1000).collect();
        let maps = [values.as_slice(), &values];
        let text = page("fetches", [10, 100], &maps, &["a", "b"])
            .caption(Scale::of(&maps, ScaleEnd::Percentile(99.0)));
        assert!(text.starts_with("One linear scale for all maps, 0 to 990 fetches."), "{text}");
        assert!(text.contains("percentile 99. 1.000 % of the pixels"), "{text}");
        assert!(text.contains("mean of 4 x 4 pixels"), "{text}");
        let single = page("fetches", [10, 100], &maps[..1], &[])
            .caption(Scale::of(&maps[..1], ScaleEnd::Percentile(100.0)));
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
            end: ScaleEnd::Percentile(100.0),
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
            end: ScaleEnd::Percentile(100.0),
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
    fn pixels_without_a_value_are_grey_and_the_scale_ends_where_it_is_told_to() {
        let values = [NO_VALUE, 25, 50, NO_VALUE];
        let map = HeatMap {
            title: "t".into(),
            subtitle: "s".into(),
            unit: "%".into(),
            width: 2,
            values: &values,
            end: ScaleEnd::Value(100),
        };
        let picture = Picture::of(write_png(&map).expect("a small picture"));
        let zoomed = LEAST_SIDE as usize / 2 * (LEAST_SIDE as usize / 2);
        assert!(picture.count(0.25) >= zoomed && picture.count(0.5) >= zoomed);
        assert!(picture.pixels.chunks_exact(3).filter(|pixel| *pixel == UNPAINTED).count() >= 2 * zoomed);
        let maps = [values.as_slice()];
        let caption = Page { end: ScaleEnd::Value(100), ..page("%", [2, 2], &maps, &[]) }
            .caption(Scale::of(&maps, ScaleEnd::Value(100)));
        assert!(caption.starts_with("Linear scale, 0 to 100 %; mean 37.50, max 50."), "{caption}");
        assert!(caption.contains("Grey pixels"), "{caption}");
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
            end: ScaleEnd::Percentile(99.0),
        };
        assert!(write_png(&map(2, &[1, 2, 3])).is_err());
        assert!(write_png(&map(0, &[])).is_err());
        assert!(write_png(&map(3, &[1, 2, 3])).is_ok());
    }
}
