//! A matrix of figures over two parameters, coloured.

use super::{ABSENT, checked, png, refuse};
use crate::error::Error;
use crate::picture::{
    Across, BACKGROUND, ColourBar, Down, FAINT, GRID, INK, Label, MARGIN, Sheet, TEXT, lettering, ramp, ticks,
};
use crate::units;

/// A figure for each pair of two parameters, printed on its colour. The scale is linear, from the least to the largest.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixChart {
    /// What is shown.
    pub title: String,
    /// Of what.
    pub subtitle: String,
    /// Name of the parameter across, such as "Ct".
    pub x_label: String,
    /// Name of the parameter down, such as "Ci".
    pub y_label: String,
    /// Name and unit of the figures, such as "frame time (ms)".
    pub value_label: String,
    /// Values of the parameter across, from the left.
    pub xs: Vec<String>,
    /// Values of the parameter down, from the top.
    pub ys: Vec<String>,
    /// A row of figures for each of `ys`; where there is none, a label says so.
    pub values: Vec<Vec<Option<f64>>>,
}

const LEAST_WIDTH: i32 = 560;
const CELL_HEIGHT: i32 = 34;
const LEAST_CELL: i32 = 60;
const LEAST_BAR: i32 = 160;
const GAP: i32 = 6;

/// Range of the figures.
#[derive(Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// Where a figure stands, 0 to 1; equal figures stand at 0.
    fn part(self, value: f64) -> f64 {
        if self.high > self.low { (value - self.low) / (self.high - self.low) } else { 0.0 }
    }

    fn bar(self, unit: &str, height: i32) -> ColourBar {
        let values = ticks::linear(self.low, self.high, 6, 0.0);
        let labels = units::tick_labels(&values);
        let round = values.into_iter().map(|value| self.part(value)).zip(labels);
        let low = [(0.0, units::short(self.low))];
        let high = (self.high > self.low).then(|| (1.0, units::short(self.high)));
        ColourBar::new(unit, height, TEXT, round, low.into_iter().chain(high))
    }
}

impl MatrixChart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// When there is nothing to draw, the figures are not a row of `xs` for each of `ys`, or one is not finite.
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

    fn range(&self) -> Result<Range, Error> {
        let (across, down) = (self.xs.len(), self.ys.len());
        if self.values.len() != down || self.values.iter().any(|row| row.len() != across) {
            return Err(refuse(
                &self.title,
                format!("the figures are not {down} rows of {across}"),
                "give one figure or its absence for each pair",
            ));
        }
        let all = self.values.iter().flatten();
        all.clone().try_for_each(|&value| checked(&self.title, value, f64::NEG_INFINITY))?;
        let values: Vec<f64> = all.copied().flatten().collect();
        if values.is_empty() {
            let remedy = "leave out a chart of what is absent everywhere";
            return Err(refuse(&self.title, "no figure to draw", remedy));
        }
        let (infinite, least) = (f64::INFINITY, f64::NEG_INFINITY);
        Ok(Range {
            low: values.iter().copied().fold(infinite, f64::min),
            high: values.iter().copied().fold(least, f64::max),
        })
    }

    fn sheet(&self) -> Result<Sheet, Error> {
        let range = self.range()?;
        let width_of = |text: &String| lettering::width(text, TEXT);
        let figures: Vec<Vec<String>> = self
            .values
            .iter()
            .map(|row| {
                row.iter().map(|value| value.map_or_else(|| ABSENT.to_owned(), units::short)).collect()
            })
            .collect();
        let figure_width = figures.iter().flatten().map(width_of).max().unwrap_or(0);
        let cell = LEAST_CELL.max(figure_width + 2 * GAP);
        let x_width = self.xs.iter().map(width_of).max().unwrap_or(0);
        let y_width = self.ys.iter().map(width_of).max().unwrap_or(0);
        let (columns, rows) = (self.xs.len() as i32, self.ys.len() as i32);
        let body = CELL_HEIGHT * rows;
        let bar = range.bar(&self.value_label, body.max(LEAST_BAR));
        let y_title = lettering::wrap(&self.y_label, body.max(LEAST_BAR), TEXT);
        let left = MARGIN + lettering::line(TEXT) * y_title.len() as i32 + GAP + y_width + GAP;
        let right = left + cell * columns;
        let bar_left = right + 2 * MARGIN;

        let mut sheet = Sheet::new((bar_left + bar.width() + MARGIN).max(LEAST_WIDTH), TEXT);
        sheet.heading(&self.title, &self.subtitle);
        let top = sheet.height + GAP + bar.unit_height();
        bar.paint(&mut sheet, bar_left, top);
        for (line, text) in (0..).zip(y_title) {
            let at = (MARGIN + lettering::line(TEXT) * line, top + body.max(LEAST_BAR) / 2);
            sheet.label(Label::new(text, at, TEXT, INK).anchored(Across::Middle, Down::Top).upwards());
        }
        for (row, (name, values)) in self.ys.iter().zip(&self.values).enumerate() {
            let y = top + CELL_HEIGHT * row as i32;
            let label = Label::new(name.as_str(), (left - GAP, y + CELL_HEIGHT / 2), TEXT, INK);
            sheet.label(label.anchored(Across::End, Down::Middle));
            for (column, (&value, figure)) in values.iter().zip(&figures[row]).enumerate() {
                let at = (left + cell * column as i32, y);
                paint_cell(&mut sheet, at, (cell, CELL_HEIGHT), value.map(|value| range.part(value)), figure);
            }
        }
        sheet.height = top + body + GAP;
        let upwards = x_width + GAP > cell;
        for (column, name) in self.xs.iter().enumerate() {
            let at = (left + cell * column as i32 + cell / 2, sheet.height);
            let label = Label::new(name.as_str(), at, TEXT, INK);
            sheet.label(match upwards {
                true => label.anchored(Across::End, Down::Middle).upwards(),
                false => label.anchored(Across::Middle, Down::Top),
            });
        }
        sheet.height += if upwards { x_width } else { lettering::line(TEXT) } + GAP;
        if lettering::width(&self.x_label, TEXT) <= cell * columns {
            let at = (left + cell * columns / 2, sheet.height);
            let label = Label::new(self.x_label.as_str(), at, TEXT, INK);
            sheet.label(label.anchored(Across::Middle, Down::Top));
            sheet.height = (sheet.height + lettering::line(TEXT)).max(top + LEAST_BAR);
        } else {
            // Wider than the matrix: below its bar too.
            sheet.height = sheet.height.max(top + LEAST_BAR + GAP);
            sheet.paragraph(&self.x_label, TEXT, INK);
        }
        sheet.height += GAP;
        if self.values.iter().flatten().any(Option::is_none) {
            sheet.paragraph(&format!("{ABSENT}: there is no such figure."), TEXT, FAINT);
        }
        sheet.height += MARGIN;
        Ok(sheet)
    }
}

/// A cell at `part` of the scale.
fn paint_cell(
    sheet: &mut Sheet,
    (x, y): (i32, i32),
    (width, height): (i32, i32),
    part: Option<f64>,
    figure: &str,
) {
    let (colour, ink) = match part.map(ramp::colour) {
        None => (BACKGROUND, FAINT),
        Some(colour) if ramp::lightness(colour) > 55.0 => (colour, INK),
        Some(colour) => (colour, BACKGROUND),
    };
    sheet.fill((x, y), (width, height), colour);
    sheet.frame((x, y), (width, height), GRID);
    let label = Label::new(figure, (x + width / 2, y + height / 2), TEXT, ink);
    sheet.label(label.anchored(Across::Middle, Down::Middle));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tests::{assert_legible, labels};

    fn chart(across: usize, down: usize, value: impl Fn(usize, usize) -> Option<f64>) -> MatrixChart {
        MatrixChart {
            title: "Frame time over the SAH costs".into(),
            subtitle: "crytek_sponza on adreno-540".into(),
            x_label: "Ct".into(),
            y_label: "Ci".into(),
            value_label: "frame time (ms)".into(),
            xs: (0..across).map(|x| format!("{}", 0.5 * x as f64)).collect(),
            ys: (0..down).map(|y| format!("{}", 0.25 * y as f64)).collect(),
            values: (0..down).map(|y| (0..across).map(|x| value(x, y)).collect()).collect(),
        }
    }

    #[test]
    fn no_label_is_clipped_or_meets_another_whatever_the_size_of_the_chart() {
        for (across, down) in [(1, 1), (2, 1), (1, 9), (8, 8), (24, 16)] {
            for factor in [1e-9, 1.0, 12_345.678, 1e12] {
                let value = |x: usize, y: usize| (x + y != 3).then_some(factor * (3 + x * y) as f64);
                let mut chart = chart(across, down, value);
                assert_legible(&chart.sheet().expect("a chart"));
                chart.xs = chart.xs.iter().map(|x| format!("{x} and a longer name")).collect();
                chart.x_label = "a name that is much wider than a matrix of one column and its bar".into();
                chart.y_label = chart.x_label.clone();
                assert_legible(&chart.sheet().expect("a chart"));
            }
        }
    }

    #[test]
    fn every_cell_prints_its_figure_and_absent_ones_say_so() {
        let sheet = chart(2, 2, |x, y| (x + y < 2).then_some((10 * x + y) as f64)).sheet().expect("a chart");
        let texts: Vec<&str> = labels(&sheet).iter().map(|label| label.text.as_str()).collect();
        for text in ["0", "1", "10", "n/a", "Ct", "Ci", "frame time (ms)"] {
            assert!(texts.contains(&text), "{text} is not among {texts:?}");
        }
    }

    #[test]
    fn the_least_figure_has_the_first_colour_and_the_largest_the_last() {
        let svg = chart(3, 1, |x, _| Some(x as f64)).svg().expect("a chart");
        let fill = |part| {
            let [red, green, blue] = ramp::colour(part);
            format!("height=\"{CELL_HEIGHT}\" opacity=\"1\" fill=\"#{red:02X}{green:02X}{blue:02X}\"")
        };
        for part in [0.0, 0.5, 1.0] {
            assert_eq!(svg.matches(&fill(part)).count(), 1, "{part}");
        }
    }

    #[test]
    fn equal_and_negative_figures_are_drawn_and_others_refused() {
        assert!(chart(2, 2, |_, _| Some(4.0)).png().is_ok());
        assert!(chart(2, 2, |x, _| Some(-(x as f64))).png().is_ok());
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = chart(2, 2, |_, _| Some(value)).svg().expect_err("no figure");
            assert!(error.to_string().contains("finite"), "{error}");
        }
        assert!(chart(2, 2, |_, _| None).svg().is_err());
        let mut odd = chart(2, 2, |_, _| Some(1.0));
        odd.values[1].pop();
        assert!(odd.svg().expect_err("a short row").to_string().contains("2 rows of 2"));
    }

    #[test]
    fn the_same_chart_gives_the_same_bytes() {
        let chart = chart(4, 3, |x, y| Some((x * y) as f64));
        assert_eq!((chart.svg(), chart.png()), (chart.svg(), chart.png()));
    }
}
