//! Points on two logarithmic axes, joined by lines or not.

use super::{palette, png, refuse};
use crate::error::Error;
use crate::picture::{
    Across, Down, FAINT, GRID, INK, Label, MARGIN, Rgb, Sheet, TEXT, legend, lettering, ramp, ticks,
};
use crate::units;

/// Points on two logarithmic axes: errors against run time, one objective against another.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLogChart {
    /// What is shown.
    pub title: String,
    /// Of what.
    pub subtitle: String,
    /// Name and unit of what grows to the right, such as "processor time, seconds".
    pub x_label: String,
    /// Name and unit of what grows upwards, such as "error, 95th percentile, %".
    pub y_label: String,
    /// The series, such as methods; at most 8.
    pub series: Vec<LogLogSeries>,
    /// A horizontal line across the chart with its label, such as a limit.
    pub limit: Option<(f64, String)>,
}

/// Points of one colour and shape. What is not finite and above 0 has no place on the axes and is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLogSeries {
    /// Its name in the legend.
    pub name: String,
    /// (x, y) in any order.
    pub points: Vec<(f64, f64)>,
    /// Whether a line joins them, by rising x.
    pub joined: bool,
    /// Where a dashed tick rises from the x axis, such as the run time of the exact answer.
    pub exact_at: Option<f64>,
}

impl LogLogSeries {
    /// The points that have a place, by rising x.
    fn drawn(&self) -> Vec<(f64, f64)> {
        let all = self.points.iter().copied();
        let mut points: Vec<(f64, f64)> = all.filter(|&(x, y)| has_place(x) && has_place(y)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points
    }

    fn exact(&self) -> Option<f64> {
        self.exact_at.filter(|&x| has_place(x))
    }
}

/// Whether a value has a place on a logarithmic axis.
fn has_place(value: f64) -> bool {
    value.is_normal() && value > 0.0
}

const MOST_SERIES: usize = 8;
const WIDTH: i32 = 1000;
const PLOT_HEIGHT: i32 = 440;
const MOST_TICKS: usize = 7;
/// Decades that an axis shows at least.
const LEAST_SPAN: f64 = 0.9;
/// Decades up to which every multiple of a power of ten has a line, and up to which every power has one.
const MULTIPLES_SPAN: f64 = 6.0;
const POWERS_SPAN: f64 = 40.0;
/// Part of an axis beyond the outermost points.
const PADDING: f64 = 0.06;
const MINOR_GRID: Rgb = [242, 242, 242];
const TICK: i32 = 5;
const GAP: i32 = 6;
/// From the middle of a marker to its outermost corner.
const REACH: i32 = 6;
const LINE: i32 = 2;
/// Height of the tick at the run time of the exact answer, and of its dashes.
const EXACT_TICK: i32 = 62;
const DASH: i32 = 6;
const SAMPLE: i32 = 34;
/// Width of the lines of the limit's label.
const LIMIT_WIDTH: i32 = 130;
const NO_POINTS: &str = "no points";
/// Above this CIE lightness a line needs a dark border on white.
const LIGHT: f64 = 80.0;

/// Markers of the series, around their middle.
#[rustfmt::skip]
const SHAPES: [&[(i32, i32)]; MOST_SERIES] = [
    // Circle.
    &[(6, 0), (5, 3), (3, 5), (0, 6), (-3, 5), (-5, 3), (-6, 0), (-5, -3), (-3, -5), (0, -6), (3, -5), (5, -3)],
    // Square.
    &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
    // Triangle.
    &[(0, -6), (6, 5), (-6, 5)],
    // Diamond.
    &[(0, -6), (6, 0), (0, 6), (-6, 0)],
    // Triangle upside down.
    &[(0, 6), (6, -5), (-6, -5)],
    // Plus.
    &[(-2, -6), (2, -6), (2, -2), (6, -2), (6, 2), (2, 2), (2, 6), (-2, 6), (-2, 2), (-6, 2), (-6, -2), (-2, -2)],
    // Cross.
    &[(-6, -4), (-4, -6), (0, -2), (4, -6), (6, -4), (2, 0), (6, 4), (4, 6), (0, 2), (-4, 6), (-6, 4), (-2, 0)],
    // Hourglass.
    &[(-6, -6), (6, -6), (2, 0), (6, 6), (-6, 6), (-2, 0)],
];

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    /// The axis of values above 0, with space beyond them.
    fn new(values: impl Iterator<Item = f64>) -> Self {
        let extremes = values
            .map(|value| (value, value))
            .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)));
        let (low, high) = extremes.unwrap_or((0.1, 10.0));
        let span = high.log10() - low.log10();
        let beyond = 10_f64.powf((PADDING * span).max((LEAST_SPAN - span) / 2.0));
        Self { low: (low / beyond).max(f64::MIN_POSITIVE), high: (high * beyond).min(f64::MAX) }
    }

    fn span(&self) -> f64 {
        self.high.log10() - self.low.log10()
    }

    /// Where a value stands on an axis of `length` pixels.
    fn place(&self, value: f64, length: i32) -> i32 {
        let part = (value.log10() - self.low.log10()) / self.span();
        (part * f64::from(length - 1)).round() as i32
    }

    /// Values with a tick and a label.
    fn ticks(&self) -> Vec<(f64, String)> {
        let values = ticks::logarithmic(self.low, self.high, MOST_TICKS);
        values.into_iter().map(|value| (value, units::short(value))).collect()
    }

    /// Values with a faint line.
    fn minor(&self) -> Vec<f64> {
        let factors: &[f64] = match self.span() {
            ..=MULTIPLES_SPAN => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
            ..=POWERS_SPAN => &[1.0],
            _ => &[],
        };
        let powers = self.low.log10().floor() as i32..=self.high.log10().floor() as i32;
        let values = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)));
        values.filter(|value| (self.low..=self.high).contains(value)).collect()
    }
}

/// The rectangle of the points, and its axes.
struct Plot {
    left: i32,
    top: i32,
    width: i32,
    x: Axis,
    y: Axis,
}

impl Plot {
    fn bottom(&self) -> i32 {
        self.top + PLOT_HEIGHT
    }

    fn across(&self, x: f64) -> i32 {
        self.left + self.x.place(x, self.width)
    }

    fn down(&self, y: f64) -> i32 {
        self.bottom() - 1 - self.y.place(y, PLOT_HEIGHT)
    }

    fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        (self.across(x), self.down(y))
    }

    /// Grid lines, ticks and their labels.
    fn paint_axes(&self, sheet: &mut Sheet, x_ticks: &[(f64, String)], y_ticks: &[(f64, String)]) {
        let upright = |sheet: &mut Sheet, x, colour| {
            sheet.fill((self.across(x), self.top), (1, PLOT_HEIGHT), colour);
        };
        let level = |sheet: &mut Sheet, y, colour| {
            sheet.fill((self.left, self.down(y)), (self.width, 1), colour);
        };
        self.x.minor().into_iter().for_each(|x| upright(sheet, x, MINOR_GRID));
        self.y.minor().into_iter().for_each(|y| level(sheet, y, MINOR_GRID));
        for (x, label) in x_ticks {
            upright(sheet, *x, GRID);
            let at = (self.across(*x), self.bottom());
            sheet.fill(at, (1, TICK), INK);
            let label = Label::new(label.as_str(), (at.0, at.1 + REACH + GAP), TEXT, INK);
            sheet.label(label.anchored(Across::Middle, Down::Top));
        }
        for (y, label) in y_ticks {
            level(sheet, *y, GRID);
            let at = (self.left - TICK, self.down(*y));
            sheet.fill(at, (TICK, 1), INK);
            let label = Label::new(label.as_str(), (at.0 - GAP, at.1), TEXT, INK);
            sheet.label(label.anchored(Across::End, Down::Middle));
        }
        sheet.fill((self.left, self.top), (1, PLOT_HEIGHT), INK);
        sheet.fill((self.left, self.bottom()), (self.width, 1), INK);
    }

    /// The line of a limit, and the lines of its label to its right.
    fn paint_limit(&self, sheet: &mut Sheet, limit: f64, lines: &[String]) {
        let y = self.down(limit);
        sheet.fill((self.left, y), (self.width, LINE), INK);
        let height = lettering::line(TEXT) * lines.len() as i32;
        let top = (y - height / 2).min(self.bottom() - height).max(self.top);
        for (line, text) in (0..).zip(lines) {
            let at = (self.left + self.width + GAP, top + lettering::line(TEXT) * line);
            sheet.label(Label::new(text.as_str(), at, TEXT, INK));
        }
    }
}

impl LogLogChart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// When there are more series than can be told apart.
    pub fn svg(&self) -> Result<String, Error> {
        Ok(self.sheet()?.svg())
    }

    /// The chart as the bytes of a PNG file.
    ///
    /// # Errors
    /// As [`Self::svg`].
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        png(&self.title, &self.sheet()?)
    }

    fn sheet(&self) -> Result<Sheet, Error> {
        if self.series.len() > MOST_SERIES {
            let problem = format!("{} series, expected at most {MOST_SERIES}", self.series.len());
            return Err(refuse(&self.title, problem, "draw a chart for some of them each"));
        }
        let drawn: Vec<Vec<(f64, f64)>> = self.series.iter().map(LogLogSeries::drawn).collect();
        let exact: Vec<Option<f64>> = self.series.iter().map(LogLogSeries::exact).collect();
        let limit = self.limit.as_ref().filter(|(limit, _)| has_place(*limit));
        let points = || drawn.iter().flatten();
        let x = Axis::new(points().map(|point| point.0).chain(exact.iter().copied().flatten()));
        let y = Axis::new(points().map(|point| point.1).chain(limit.map(|(limit, _)| *limit)));
        let (x_ticks, y_ticks) = (x.ticks(), y.ticks());
        let widest = |ticks: &[(f64, String)]| {
            ticks.iter().map(|(_, label)| lettering::width(label, TEXT)).max().unwrap_or(0)
        };
        let y_title = lettering::wrap(&self.y_label, PLOT_HEIGHT, TEXT);
        let limit_lines = limit.map_or_else(Vec::new, |(_, label)| lettering::wrap(label, LIMIT_WIDTH, TEXT));
        let limit_width = limit_lines.iter().map(|line| GAP + lettering::width(line, TEXT)).max();
        let left =
            MARGIN + lettering::line(TEXT) * y_title.len() as i32 + GAP + widest(&y_ticks) + GAP + TICK;
        let right = limit_width.unwrap_or(0).max(widest(&x_ticks) / 2) + MARGIN;

        let mut sheet = Sheet::new(WIDTH, TEXT);
        sheet.heading(&self.title, &self.subtitle);
        let plot = Plot { left, top: sheet.height + 2 * GAP, width: WIDTH - left - right, x, y };
        plot.paint_axes(&mut sheet, &x_ticks, &y_ticks);
        for (line, title) in (0..).zip(y_title) {
            let at = (MARGIN + lettering::line(TEXT) * line, plot.top + PLOT_HEIGHT / 2);
            sheet.label(Label::new(title, at, TEXT, INK).anchored(Across::Middle, Down::Top).upwards());
        }
        if let Some((limit, _)) = limit {
            plot.paint_limit(&mut sheet, *limit, &limit_lines);
        }
        for (series, x) in exact.iter().enumerate().filter_map(|(series, x)| Some((series, (*x)?))) {
            let foot = (plot.across(x), plot.bottom());
            paint_dashes(&mut sheet, foot, EXACT_TICK, palette::colour(series).0);
            paint_marker(&mut sheet, foot, series);
        }
        let joined = |series: &usize| self.series[*series].joined;
        for (series, points) in drawn.iter().enumerate().filter(|(series, _)| joined(series)) {
            for pair in points.windows(2) {
                paint_line(&mut sheet, [plot.at(pair[0]), plot.at(pair[1])], series);
            }
        }
        for (series, points) in drawn.iter().enumerate() {
            points.iter().for_each(|&point| paint_marker(&mut sheet, plot.at(point), series));
        }
        if points().next().is_none() {
            let at = (plot.left + plot.width / 2, plot.top + 2 * GAP);
            sheet.label(Label::new(NO_POINTS, at, TEXT, FAINT).anchored(Across::Middle, Down::Top));
        }
        sheet.height = plot.bottom() + REACH + GAP + lettering::line(TEXT) + GAP;
        for line in lettering::wrap(&self.x_label, plot.width, TEXT) {
            let at = (plot.left + plot.width / 2, sheet.height);
            sheet.label(Label::new(line, at, TEXT, INK).anchored(Across::Middle, Down::Top));
            sheet.height += lettering::line(TEXT);
        }
        sheet.height += 2 * GAP;
        paint_legend(&mut sheet, &self.series, &drawn, exact.iter().any(Option::is_some));
        sheet.height += MARGIN;
        Ok(sheet)
    }
}

/// The legend: a line with its marker for each series, and what a dashed tick means where there is one.
fn paint_legend(sheet: &mut Sheet, series: &[LogLogSeries], drawn: &[Vec<(f64, f64)>], exact: bool) {
    let named = series.iter().zip(drawn).map(|(LogLogSeries { name, .. }, points)| {
        if points.is_empty() { format!("{name} ({NO_POINTS})") } else { name.clone() }
    });
    let mut names: Vec<String> = named.collect();
    if exact {
        names.push("dashed, at the foot: the exact answer".to_owned());
    }
    legend::paint(sheet, names.iter().map(String::as_str), SAMPLE, |sheet, (x, y), entry| {
        if entry < series.len() {
            if series[entry].joined {
                paint_line(sheet, [(x, y), (x + SAMPLE, y)], entry);
            }
            paint_marker(sheet, (x + SAMPLE / 2, y), entry);
        } else {
            paint_dashes(sheet, (x + SAMPLE / 2, y + DASH * 3 / 2), DASH * 3, INK);
        }
    });
}

/// A line in the colour of its series, with a border where it would be too light.
pub(super) fn paint_line(sheet: &mut Sheet, ends: [(i32, i32); 2], series: usize) {
    let (colour, _) = palette::colour(series);
    if ramp::lightness(colour) > LIGHT {
        sheet.line(ends, LINE + 2, INK);
    }
    sheet.line(ends, LINE, colour);
}

/// A marker in the colour and shape of its series.
fn paint_marker(sheet: &mut Sheet, (x, y): (i32, i32), series: usize) {
    let corners: Vec<(i32, i32)> = SHAPES[series].iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    sheet.area(corners.clone(), palette::colour(series).0);
    for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        sheet.line([from, to], 1, INK);
    }
}

/// A dashed line upwards from its foot, with a border where it would be too light.
fn paint_dashes(sheet: &mut Sheet, (x, y): (i32, i32), height: i32, colour: Rgb) {
    for above in (0..height).step_by(2 * DASH as usize) {
        let (left, top) = (x - LINE / 2, y - above - DASH);
        if ramp::lightness(colour) > LIGHT {
            sheet.fill((left - 1, top - 1), (LINE + 2, DASH + 2), INK);
        }
        sheet.fill((left, top), (LINE, DASH), colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Mark;
    use crate::picture::tests::{Edges, assert_legible, edges, labels, meet};

    fn chart(series: &[&[(f64, f64)]]) -> LogLogChart {
        let names = ["tiles", "a sampled rung with replicates and a long name", "<&\"'>"];
        let series = series.iter().enumerate().map(|(index, points)| LogLogSeries {
            name: format!("{} {index}", names[index % 3]),
            points: points.to_vec(),
            joined: index % 2 == 0,
            exact_at: points.first().map(|point| 40.0 * point.0),
        });
        LogLogChart {
            title: "Error against run time".into(),
            subtitle: "all scenes on adreno-540".into(),
            x_label: "processor time, seconds".into(),
            y_label: "error, 95th percentile, %".into(),
            series: series.collect(),
            limit: Some((1.0, "limit 1 % of the frame time".into())),
        }
    }

    /// The labels are legible, and none lies on a point, a line or a sample of the legend.
    fn assert_clear(chart: &LogLogChart) {
        let sheet = chart.sheet().expect("a chart");
        assert_legible(&sheet);
        let around = |places: &[(i32, i32)]| {
            let (xs, ys) = (places.iter().map(|place| place.0), places.iter().map(|place| place.1));
            Some([xs.clone().min()?, ys.clone().min()?, xs.max()?, ys.max()?])
        };
        let drawn = sheet.marks.iter().filter_map(|mark| match mark {
            Mark::Area { corners, .. } => around(corners),
            Mark::Line { ends, .. } => around(ends),
            _ => None,
        });
        let drawn: Vec<Edges> = drawn.collect();
        for label in labels(&sheet) {
            assert!(!drawn.iter().any(|&mark| meet(edges(label), mark)), "{label:?} lies on a mark");
        }
        for [left, top, right, bottom] in drawn {
            assert!(left >= 0 && top >= 0 && right <= sheet.width && bottom <= sheet.height);
        }
    }

    fn texts(chart: &LogLogChart) -> Vec<String> {
        labels(&chart.sheet().expect("a chart")).iter().map(|label| label.text.clone()).collect()
    }

    #[test]
    fn no_label_is_clipped_or_meets_another_whatever_the_points() {
        let cases: [&[(f64, f64)]; 8] = [
            &[],
            &[(3.0, 0.2)],
            &[(2.0, 2.0), (2.0, 2.0)],
            &[(1e-12, 1e12), (1e12, 1e-12)],
            &[(1e-300, 1e300), (1e300, 1e-300)],
            &[(f64::MIN_POSITIVE, f64::MAX), (f64::MAX, f64::MIN_POSITIVE)],
            &[(0.9, 9e-4), (11.0, 0.9), (90.0, 1e-3)],
            &[(123_456.0, 1e14), (999_999.0, 2e14)],
        ];
        for points in cases {
            for count in [0, 1, 4, 8] {
                let mut chart = chart(&vec![points; count]);
                assert_clear(&chart);
                chart.limit = None;
                chart.x_label =
                    "a name that is wider than the whole of the axis below which it stands ".repeat(3);
                chart.y_label = chart.x_label.clone();
                assert_clear(&chart);
                assert!(chart.png().is_ok());
            }
        }
    }

    #[test]
    fn short_axes_label_2_and_5_times_the_powers_of_ten_and_long_ones_the_powers() {
        let labels = |low, high| {
            let ticks = Axis::new([low, high].into_iter()).ticks();
            ticks.into_iter().map(|(_, label)| label).collect::<Vec<_>>()
        };
        assert_eq!(labels(0.02, 1.0), ["0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
        assert_eq!(labels(0.01, 100.0), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(3.0, 3.0), ["2", "5"]);
        for (low, high) in [(1e-12, 1e12), (f64::MIN_POSITIVE, f64::MAX), (7e-300, 7e-300)] {
            assert!((2..=8).contains(&labels(low, high).len()), "{low} to {high}");
        }
    }

    #[test]
    fn every_point_has_a_marker_where_its_values_stand_and_others_are_left_out() {
        let points = [
            (100.0, 0.01),
            (1.0, 1.0),
            (10.0, 0.1),
            (0.0, 1.0),
            (1.0, -1.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
        ];
        let mut chart = chart(&[&points]);
        chart.series[0].exact_at = None;
        let sheet = chart.sheet().expect("a chart");
        let middles = sheet.marks.iter().filter_map(|mark| match mark {
            Mark::Area { corners, .. } => Some((corners[3].0, corners[0].1)),
            _ => None,
        });
        let middles: Vec<(i32, i32)> = middles.collect();
        // The last one is in the legend.
        let [first, second, third, _] = middles[..] else { panic!("{middles:?}") };
        assert!(first.0 < second.0 && first.1 < second.1, "{middles:?}");
        let even = |a: i32, b: i32, c: i32| (a - 2 * b + c).abs() <= 1;
        assert!(even(first.0, second.0, third.0) && even(first.1, second.1, third.1), "{middles:?}");
    }

    #[test]
    fn series_differ_in_shape_and_colour() {
        let sheet = chart(&[&[(1.0, 1.0)][..]; MOST_SERIES]).sheet().expect("a chart");
        let swatches = sheet.marks.iter().rev().filter_map(|mark| match mark {
            Mark::Area { corners, colour } => {
                let (x, y) = corners[0];
                Some((corners.iter().map(|corner| (corner.0 - x, corner.1 - y)).collect(), *colour))
            }
            _ => None,
        });
        let swatches: Vec<(Vec<(i32, i32)>, Rgb)> = swatches.take(MOST_SERIES).collect();
        for (index, (shape, colour)) in swatches.iter().enumerate() {
            assert!(swatches[..index].iter().all(|other| other.0 != *shape && other.1 != *colour), "{index}");
        }
    }

    #[test]
    fn labels_say_what_is_shown_and_what_is_not() {
        let mut chart = chart(&[&[(1.0, 1.0)], &[]]);
        let shown = texts(&chart);
        for text in ["processor time, seconds", "error, 95th percentile, %", "tiles 0", "limit 1 % of the"] {
            assert!(shown.iter().any(|label| label == text), "{text} is not among {shown:?}");
        }
        assert!(shown.iter().any(|label| label.ends_with("1 (no points)")), "{shown:?}");
        assert!(shown.iter().any(|label| label.contains("exact")), "{shown:?}");
        assert!(!shown.contains(&NO_POINTS.to_owned()));
        chart.series.clear();
        let shown = texts(&chart);
        assert!(shown.contains(&NO_POINTS.to_owned()) && !shown.iter().any(|label| label.contains("exact")));
    }

    #[test]
    fn a_ninth_series_is_refused() {
        let error = chart(&[&[(1.0, 1.0)][..]; MOST_SERIES + 1]).svg().expect_err("no chart");
        assert!(error.to_string().contains("9 series"), "{error}");
    }

    #[test]
    fn the_same_chart_gives_the_same_bytes_of_a_picture_of_its_size() {
        let chart = chart(&[&[(1.0, 1.0), (5.0, 0.1)], &[(2.0, 3.0)]]);
        assert_eq!((chart.svg(), chart.png()), (chart.svg(), chart.png()));
        let bytes = chart.png().expect("a picture");
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG file");
        let (width, height) = reader.info().size();
        let sheet = chart.sheet().expect("a chart");
        assert_eq!((width as i32, height as i32), (sheet.width, sheet.height));
        let svg = chart.svg().expect("a chart");
        assert!(svg.contains("<polyline") && svg.contains("<polygon"), "{svg}");
    }
}
