//! Figures over time: panels of lines above each other that share the axis of time.

use super::log_log::paint_line;
use super::{png, refuse};
use crate::error::Error;
use crate::picture::{Across, Down, GRID, INK, Label, MARGIN, Sheet, TEXT, legend, lettering, ticks};
use crate::units;

/// Panels of lines over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSeriesChart {
    /// What is shown.
    pub title: String,
    /// Of what.
    pub subtitle: String,
    /// Name and unit of the time, such as "time, minutes".
    pub x_label: String,
    /// From the top down.
    pub panels: Vec<TimePanel>,
}

/// Lines of one unit.
#[derive(Clone, Debug, PartialEq)]
pub struct TimePanel {
    /// Name and unit of what grows upwards, such as "temperature, degrees Celsius".
    pub y_label: String,
    /// At most 8 in the whole chart.
    pub series: Vec<TimeSeries>,
    /// Horizontal lines with their labels, such as limits.
    pub limits: Vec<(f64, String)>,
    /// Whether the axis begins at 0.
    pub from_zero: bool,
}

/// One line.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSeries {
    /// Its name in the legend.
    pub name: String,
    /// Finite (time, value) by rising time.
    pub points: Vec<(f64, f64)>,
    /// Whether a value holds until the next.
    pub holds: bool,
}

const MOST_SERIES: usize = 8;
const WIDTH: i32 = 1000;
const PANEL_HEIGHT: i32 = 220;
const MOST_TICKS: usize = 8;
const LIMIT_WIDTH: i32 = 130;
const TICK: i32 = 5;
const GAP: i32 = 6;
const SAMPLE: i32 = 34;
/// Part of a range beyond its ends.
const PADDING: f64 = 0.05;

/// A linear axis with space beyond its values.
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, from_zero: bool, padding: f64) -> Self {
        let start = if from_zero { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let (low, high) = values.fold(start, |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return Self { low: 0.0, high: 1.0 };
        }
        let span = if high > low { high - low } else { high.abs().max(1.0) };
        let below = if from_zero { low } else { low - padding * span };
        Self { low: below, high: high.max(low + span * f64::EPSILON) + padding * span }
    }

    fn place(&self, value: f64, length: i32) -> i32 {
        ((value - self.low) / (self.high - self.low) * f64::from(length - 1)).round() as i32
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        let values = ticks::linear(self.low, self.high, MOST_TICKS, 0.0);
        let labels = units::tick_labels(&values);
        values.into_iter().zip(labels).collect()
    }
}

impl TimeSeriesChart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// When there are more series than can be told apart, or a figure is not finite.
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

    fn series(&self) -> impl Iterator<Item = &TimeSeries> {
        self.panels.iter().flat_map(|panel| &panel.series)
    }

    fn check(&self) -> Result<(), Error> {
        let count = self.series().count();
        if count > MOST_SERIES {
            let problem = format!("{count} series, expected at most {MOST_SERIES}");
            return Err(refuse(&self.title, problem, "leave some out"));
        }
        let points = self.series().flat_map(|series| &series.points).copied();
        let limits = self.panels.iter().flat_map(|panel| &panel.limits).map(|(limit, _)| (*limit, 0.0));
        if points.chain(limits).any(|(a, b)| !(a.is_finite() && b.is_finite())) {
            return Err(refuse(
                &self.title,
                "a figure is no finite number",
                "give no point where there is none",
            ));
        }
        Ok(())
    }

    fn sheet(&self) -> Result<Sheet, Error> {
        self.check()?;
        let times = self.series().flat_map(|series| &series.points).map(|point| point.0);
        let x = Axis::new(times, false, 0.0);
        let axes: Vec<Axis> = self.panels.iter().map(TimePanel::axis).collect();
        let labels = axes.iter().flat_map(Axis::ticks);
        let widest = labels.map(|(_, label)| lettering::width(&label, TEXT)).max().unwrap_or(0);
        let titles: Vec<Vec<String>> =
            self.panels.iter().map(|panel| lettering::wrap(&panel.y_label, PANEL_HEIGHT, TEXT)).collect();
        let title_lines = titles.iter().map(Vec::len).max().unwrap_or(0) as i32;
        let limited = self.panels.iter().any(|panel| !panel.limits.is_empty());
        let left = MARGIN + lettering::line(TEXT) * title_lines + GAP + widest + GAP + TICK;
        let right = MARGIN + if limited { LIMIT_WIDTH + GAP } else { GAP * 4 };
        let width = WIDTH - left - right;

        let mut sheet = Sheet::new(WIDTH, TEXT);
        sheet.heading(&self.title, &self.subtitle);
        let mut colour = 0;
        for ((panel, y), title) in self.panels.iter().zip(&axes).zip(titles) {
            let top = sheet.height + 2 * GAP;
            let bottom = top + PANEL_HEIGHT;
            let across = |time: f64| left + x.place(time, width);
            let down = |value: f64| bottom - 1 - y.place(value, PANEL_HEIGHT);
            for (time, _) in x.ticks() {
                sheet.fill((across(time), top), (1, PANEL_HEIGHT), GRID);
                sheet.fill((across(time), bottom), (1, TICK), INK);
            }
            for (value, label) in y.ticks() {
                sheet.fill((left, down(value)), (width, 1), GRID);
                sheet.fill((left - TICK, down(value)), (TICK, 1), INK);
                let label = Label::new(label, (left - TICK - GAP, down(value)), TEXT, INK);
                sheet.label(label.anchored(Across::End, Down::Middle));
            }
            sheet.fill((left, top), (1, PANEL_HEIGHT), INK);
            sheet.fill((left, bottom), (width, 1), INK);
            for (line, words) in (0..).zip(title) {
                let at = (MARGIN + lettering::line(TEXT) * line, top + PANEL_HEIGHT / 2);
                sheet.label(Label::new(words, at, TEXT, INK).anchored(Across::Middle, Down::Top).upwards());
            }
            paint_limits(&mut sheet, &panel.limits, (left, width), (top, bottom), down);
            for series in &panel.series {
                let places: Vec<(i32, i32)> =
                    series.path().map(|(time, value)| (across(time), down(value))).collect();
                for pair in places.windows(2).filter(|pair| pair[0] != pair[1]) {
                    paint_line(&mut sheet, [pair[0], pair[1]], colour);
                }
                colour += 1;
            }
            sheet.height = bottom + TICK;
        }
        sheet.height += GAP;
        for (time, label) in x.ticks() {
            let label = Label::new(label, (left + x.place(time, width), sheet.height), TEXT, INK);
            sheet.label(label.anchored(Across::Middle, Down::Top));
        }
        sheet.height += lettering::line(TEXT) + GAP;
        for line in lettering::wrap(&self.x_label, width, TEXT) {
            let at = (left + width / 2, sheet.height);
            sheet.label(Label::new(line, at, TEXT, INK).anchored(Across::Middle, Down::Top));
            sheet.height += lettering::line(TEXT);
        }
        sheet.height += 2 * GAP;
        let names: Vec<&str> = self.series().map(|series| series.name.as_str()).collect();
        legend::paint(&mut sheet, names.into_iter(), SAMPLE, |sheet, (x, y), entry| {
            paint_line(sheet, [(x, y), (x + SAMPLE, y)], entry);
        });
        sheet.height += MARGIN;
        Ok(sheet)
    }
}

/// Lines of limits, and their labels to the right, each below the one before where they would meet.
fn paint_limits(
    sheet: &mut Sheet,
    limits: &[(f64, String)],
    (left, width): (i32, i32),
    (top, bottom): (i32, i32),
    down: impl Fn(f64) -> i32,
) {
    let mut limits: Vec<&(f64, String)> = limits.iter().collect();
    limits.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut free = top;
    for (limit, label) in limits {
        let y = down(*limit);
        sheet.fill((left, y), (width, 1), INK);
        let lines = lettering::wrap(label, LIMIT_WIDTH, TEXT);
        let height = lettering::line(TEXT) * lines.len() as i32;
        let first = (y - height / 2).min(bottom - height).max(free);
        for (line, words) in (0..).zip(lines) {
            let at = (left + width + GAP, first + lettering::line(TEXT) * line);
            sheet.label(Label::new(words, at, TEXT, INK));
        }
        free = first + height;
    }
}

impl TimePanel {
    fn axis(&self) -> Axis {
        let values = self.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        Axis::new(values.chain(self.limits.iter().map(|(limit, _)| *limit)), self.from_zero, PADDING)
    }
}

impl TimeSeries {
    /// The points, with a corner between each two where a value holds until the next.
    fn path(&self) -> impl Iterator<Item = (f64, f64)> {
        let corner = |pair: &[(f64, f64)]| self.holds.then_some((pair[1].0, pair[0].1));
        let rest = self.points.windows(2).flat_map(move |pair| corner(pair).into_iter().chain([pair[1]]));
        self.points.first().copied().into_iter().chain(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tests::{assert_legible, labels};

    fn chart(count: usize) -> TimeSeriesChart {
        let series = |index: usize, holds| TimeSeries {
            name: format!("line {index}"),
            points: (0..=600)
                .map(|t| (f64::from(t) / 60.0, f64::from(t % 97) + 10.0 * index as f64))
                .collect(),
            holds,
        };
        let panel = |y_label: &str, series: Vec<TimeSeries>, from_zero| TimePanel {
            y_label: y_label.to_owned(),
            series,
            limits: vec![(50.0, "a limit with a long name".to_owned()), (51.0, "another".to_owned())],
            from_zero,
        };
        TimeSeriesChart {
            title: "Frame rate and temperatures".to_owned(),
            subtitle: "a scene on a GPU".to_owned(),
            x_label: "time, minutes".to_owned(),
            panels: vec![
                panel("frame rate, 1/s", vec![series(0, true)], true),
                panel(
                    "temperature, degrees Celsius",
                    (1..count).map(|index| series(index, false)).collect(),
                    false,
                ),
            ],
        }
    }

    #[test]
    fn every_label_has_its_place_and_axes_have_their_units() {
        let sheet = chart(6).sheet().expect("a chart");
        assert_legible(&sheet);
        let texts: Vec<&str> = labels(&sheet).iter().map(|label| label.text.as_str()).collect();
        for text in ["frame rate, 1/s", "temperature, degrees Celsius", "time, minutes", "line 5", "another"]
        {
            assert!(texts.contains(&text), "{text} in {texts:?}");
        }
        assert_eq!(chart(6).svg().expect("SVG"), chart(6).svg().expect("SVG"));
    }

    #[test]
    fn a_value_that_holds_goes_straight_and_then_up() {
        let series = TimeSeries { name: String::new(), points: vec![(0.0, 1.0), (2.0, 3.0)], holds: true };
        assert_eq!(series.path().collect::<Vec<_>>(), [(0.0, 1.0), (2.0, 1.0), (2.0, 3.0)]);
        let slanted = TimeSeries { holds: false, ..series };
        assert_eq!(slanted.path().count(), 2);
    }

    #[test]
    fn too_many_series_and_what_is_no_number_are_refused() {
        assert!(chart(9).svg().is_err());
        let mut broken = chart(3);
        broken.panels[0].series[0].points[3].1 = f64::NAN;
        assert!(broken.svg().expect_err("refused").to_string().contains("no finite number"));
        let empty = TimeSeriesChart { panels: vec![], ..chart(3) };
        assert!(empty.svg().is_ok());
    }
}
