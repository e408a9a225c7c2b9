//! Grouped bars.

use super::axis::Axis;
use super::{ABSENT, checked, palette, png, refuse};
use crate::error::Error;
use crate::picture::{
    Across, BACKGROUND, Down, FAINT, GRID, INK, Label, MARGIN, Rgb, SMALL, Sheet, TEXT, legend, lettering,
};
use crate::units;

/// Bars of several series, side by side for each group.
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// What is shown.
    pub title: String,
    /// Of what.
    pub subtitle: String,
    /// Name and unit of the values, such as "frame time (ms)".
    pub value_label: String,
    /// Names of the groups, such as scenes.
    pub groups: Vec<String>,
    /// The series, such as traversals; at most 16.
    pub series: Vec<Series>,
    /// How values become heights.
    pub scale: Scale,
}

/// Bars of one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// A value of 0 or more for each group; where there is none, a label says so.
    pub values: Vec<Option<f64>>,
}

/// How values become heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From 0.
    Linear,
    /// By powers of ten, for values that differ a hundredfold and more; none of them is 0.
    Log,
}

const LEAST_WIDTH: i32 = 1000;
const LEAST_PLOT: i32 = 360;
const LEAST_BAR: i32 = 18;
const MOST_BAR: i32 = 90;
/// Least space between groups.
const GROUP_GAP: i32 = 16;
const TICK: i32 = 5;
const GAP: i32 = 6;
const SWATCH: i32 = 14;
/// Lines of a group's name before it is written upwards.
const MOST_LINES: usize = 3;

/// A rectangle of the sheet.
#[derive(Clone, Copy)]
struct Plot {
    left: i32,
    top: i32,
    width: i32,
    height: i32,
}

impl Plot {
    fn bottom(self) -> i32 {
        self.top + self.height
    }
}

/// Places of groups and bars across the plot.
struct Grid {
    slot: f64,
    bar: i32,
    series: usize,
}

impl Grid {
    fn new(width: i32, groups: usize, series: usize) -> Self {
        let slot = f64::from(width) / groups as f64;
        let room = slot - f64::from(LEAST_BAR * series as i32);
        let gap = (slot * 0.15).min(room).max(f64::from(GROUP_GAP));
        let bar = (((slot - gap) / series as f64) as i32).min(MOST_BAR);
        Self { slot, bar, series }
    }

    fn middle(&self, group: usize) -> i32 {
        ((group as f64 + 0.5) * self.slot) as i32
    }

    fn bar_left(&self, group: usize, series: usize) -> i32 {
        self.middle(group) - self.bar * self.series as i32 / 2 + self.bar * series as i32
    }
}

impl BarChart {
    /// The chart as SVG.
    ///
    /// # Errors
    /// When there is nothing to draw, a series has not one value for each group, there are more series than can be told
    /// apart, or a value is negative, not finite, or 0 on a logarithmic scale.
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

    /// The values, after a check of everything.
    fn values(&self) -> Result<Vec<f64>, Error> {
        let refuse = |problem: String, remedy| Err(refuse(&self.title, problem, remedy));
        if self.series.len() > palette::MOST {
            let problem = format!("{} series, expected at most {}", self.series.len(), palette::MOST);
            return refuse(problem, "make groups of some of them");
        }
        for Series { name, values } in &self.series {
            let (found, expected) = (values.len(), self.groups.len());
            if found != expected {
                let problem = format!("series \"{name}\" has {found} values for {expected} groups");
                return refuse(problem, "give one value or its absence for each group");
            }
        }
        let all = self.series.iter().flat_map(|series| &series.values);
        all.clone().try_for_each(|&value| checked(&self.title, value, 0.0))?;
        let values: Vec<f64> = all.copied().flatten().collect();
        if values.is_empty() {
            return refuse("no figure to draw".into(), "leave out a chart of what is absent everywhere");
        }
        if self.scale == Scale::Log && values.contains(&0.0) {
            return refuse("0 has no place on a logarithmic scale".into(), "take a linear scale");
        }
        Ok(values)
    }

    /// What is written at a bar.
    fn figure(value: Option<f64>) -> String {
        value.map_or_else(|| ABSENT.to_owned(), units::short)
    }

    fn sheet(&self) -> Result<Sheet, Error> {
        let values = self.values()?;
        let axis = Axis::new(self.scale, &values);
        let ticks = axis.ticks();
        let figures = self.series.iter().flat_map(|series| &series.values);
        let figure_width =
            figures.map(|&value| lettering::width(&Self::figure(value), SMALL)).max().unwrap_or(0);
        let tick_width = ticks.iter().map(|(_, label)| lettering::width(label, TEXT)).max().unwrap_or(0);
        let titles = lettering::wrap(&self.value_title(), LEAST_PLOT, TEXT);
        let left = MARGIN + lettering::line(TEXT) * titles.len() as i32 + GAP + tick_width + GAP + TICK;
        let least_slot = (LEAST_BAR * self.series.len() as i32 + GROUP_GAP).max(lettering::line(TEXT) + GAP);
        let width = (LEAST_WIDTH - left - MARGIN).max(least_slot * self.groups.len() as i32);
        let grid = Grid::new(width, self.groups.len(), self.series.len());
        let upwards = figure_width + 4 > grid.bar;
        let headroom = GAP + if upwards { figure_width + GAP } else { lettering::line(SMALL) };

        let mut sheet = Sheet::new(left + width + MARGIN, TEXT);
        sheet.heading(&self.title, &self.subtitle);
        let plot = Plot { left, top: sheet.height + GAP, width, height: LEAST_PLOT + headroom };
        paint_axis(&mut sheet, plot, headroom, &ticks, &titles);
        for (index, series) in self.series.iter().enumerate() {
            for (group, &value) in series.values.iter().enumerate() {
                let x = plot.left + grid.bar_left(group, index);
                let part = value.map_or(0.0, |value| axis.part(value));
                let height = (part * f64::from(LEAST_PLOT)).round() as i32;
                paint_bar(&mut sheet, (x, plot.bottom() - height), (grid.bar, height), index);
                let colour = if value.is_some() { INK } else { FAINT };
                let at = (x + grid.bar / 2, plot.bottom() - height - GAP);
                sheet.label(figure_label(Self::figure(value), at, upwards, colour));
            }
        }
        sheet.fill((plot.left, plot.bottom()), (plot.width, 1), INK);
        sheet.height = plot.bottom() + GAP;
        self.paint_groups(&mut sheet, plot, &grid);
        let names = self.series.iter().map(|series| series.name.as_str());
        legend::paint(&mut sheet, names, SWATCH, |sheet, (x, y), index| {
            paint_bar(sheet, (x, y - SWATCH / 2), (SWATCH, SWATCH), index);
        });
        if self.series.iter().any(|series| series.values.contains(&None)) {
            sheet.paragraph(&format!("{ABSENT}: there is no such figure."), TEXT, FAINT);
        }
        sheet.height += MARGIN;
        Ok(sheet)
    }

    fn value_title(&self) -> String {
        match self.scale {
            Scale::Linear => self.value_label.clone(),
            Scale::Log => format!("{}, logarithmic scale", self.value_label),
        }
    }

    /// Names of the groups below the plot: in lines where they fit, otherwise upwards.
    fn paint_groups(&self, sheet: &mut Sheet, plot: Plot, grid: &Grid) {
        let room = grid.slot as i32 - GAP;
        let wrapped: Vec<Vec<String>> =
            self.groups.iter().map(|name| lettering::wrap(name, room, TEXT)).collect();
        let words_fit = self
            .groups
            .iter()
            .flat_map(|name| name.split_whitespace())
            .all(|word| lettering::width(word, TEXT) <= room);
        let lines = wrapped.iter().map(Vec::len).max().unwrap_or(0);
        let top = sheet.height;
        if words_fit && lines <= MOST_LINES {
            for (group, lines) in wrapped.into_iter().enumerate() {
                for (line, text) in (0..).zip(lines) {
                    let at = (plot.left + grid.middle(group), top + lettering::line(TEXT) * line);
                    sheet.label(Label::new(text, at, TEXT, INK).anchored(Across::Middle, Down::Top));
                }
            }
            sheet.height += lettering::line(TEXT) * lines as i32;
        } else {
            for (group, name) in self.groups.iter().enumerate() {
                let at = (plot.left + grid.middle(group), top);
                let label = Label::new(name.as_str(), at, TEXT, INK).anchored(Across::End, Down::Middle);
                sheet.label(label.upwards());
            }
            let longest = self.groups.iter().map(|name| lettering::width(name, TEXT)).max();
            sheet.height += longest.unwrap_or(0);
        }
        sheet.height += 2 * GAP;
    }
}

fn paint_axis(sheet: &mut Sheet, plot: Plot, headroom: i32, ticks: &[(f64, String)], titles: &[String]) {
    for (part, label) in ticks {
        let y = plot.bottom() - (part * f64::from(plot.height - headroom)).round() as i32;
        sheet.fill((plot.left, y), (plot.width, 1), GRID);
        sheet.fill((plot.left - TICK, y), (TICK, 1), INK);
        let label = Label::new(label.as_str(), (plot.left - TICK - GAP, y), TEXT, INK);
        sheet.label(label.anchored(Across::End, Down::Middle));
    }
    sheet.fill((plot.left, plot.top), (1, plot.height), INK);
    for (line, title) in (0..).zip(titles) {
        let at = (MARGIN + lettering::line(TEXT) * line, plot.top + plot.height / 2);
        sheet.label(Label::new(title.as_str(), at, TEXT, INK).anchored(Across::Middle, Down::Top).upwards());
    }
}

/// A bar, or a swatch of the legend, in the colour and pattern of its series.
fn paint_bar(sheet: &mut Sheet, (x, y): (i32, i32), (width, height): (i32, i32), series: usize) {
    if height <= 0 {
        return;
    }
    let (colour, striped) = palette::colour(series);
    sheet.fill((x, y), (width, height), colour);
    if striped {
        for below in (2..height - 2).step_by(6) {
            sheet.fill((x, y + below), (width, 2.min(height - below)), BACKGROUND);
        }
    }
    sheet.frame((x, y), (width, height), INK);
}

/// The figure above a bar whose top is at `at`.
fn figure_label(figure: String, (x, y): (i32, i32), upwards: bool, colour: Rgb) -> Label {
    if upwards {
        Label::new(figure, (x, y), SMALL, colour).anchored(Across::Start, Down::Middle).upwards()
    } else {
        Label::new(figure, (x, y - SMALL / 2), SMALL, colour).anchored(Across::Middle, Down::Middle)
    }
}

#[cfg(test)]
mod tests;
