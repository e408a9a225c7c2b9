//! Whether the figures of a case satisfy a rule, by how much, and how to say so.

use super::model::{Metric, Variant};
use super::rule::{Bound, Condition, Direction, End, Rule};
use crate::units::digits;

/// Figures on their limit keep it, although their quotient is rounded.
const ROUNDING: f64 = 1e-12;

/// A rule held against the figures of one case.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    /// How far the figures are on the right side of the limit.
    margin: f64,
    /// The figures.
    pub(super) figures: String,
    /// Relative error against the paper's figure.
    pub(super) error: Option<f64>,
}

impl Finding {
    pub(super) fn holds(&self) -> bool {
        self.margin >= -ROUNDING
    }

    /// By how much it holds, for comparison with other cases of the same rule.
    pub(super) fn margin(&self) -> f64 {
        self.margin
    }
}

/// By how much `b` exceeds `a`.
fn advantage(a: f64, b: f64) -> f64 {
    match (a > 0.0, b > 0.0) {
        (true, _) => b / a - 1.0,
        (false, true) => f64::INFINITY,
        (false, false) => 0.0,
    }
}

fn along(direction: Direction, first: f64, last: f64) -> f64 {
    match direction {
        Direction::Rising => advantage(first, last),
        Direction::Falling => advantage(last, first),
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn smallest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

impl Rule {
    /// Holds the columns of a case, or their means, against the rule; `place` names where they are from.
    pub(super) fn judge(&self, columns: &[f64], place: &str) -> Finding {
        let plain = |margin: f64, figures: String| Finding { margin, figures, error: None };
        match self {
            Self::Number { metric, of, to, within, .. } => {
                let error = columns[0] / columns[1] - 1.0;
                let over = to.as_ref().map_or(String::new(), |to| format!(" / {}", to.name));
                let figures = format!(
                    "{metric} of {}{over} on {place}: {} against {} published ({})",
                    of.name,
                    digits(columns[0]),
                    digits(columns[1]),
                    percent(error)
                );
                Finding { margin: within - error.abs(), figures, error: Some(error) }
            }
            Self::Order { metric, ascending, effect } => {
                let mut rest = columns;
                let mut groups = Vec::new();
                for group in ascending {
                    let (now, later) = rest.split_at(group.len());
                    groups.push(now);
                    rest = later;
                }
                let steps = groups.windows(2).map(|pair| advantage(largest(pair[0]), smallest(pair[1])));
                let step = smallest(&steps.collect::<Vec<_>>());
                plain(step - effect, self.chain(metric, columns, place, step))
            }
            Self::Extreme { metric, end, effect, .. } => {
                let beyond = match end {
                    End::Least => advantage(columns[0], smallest(&columns[1..])),
                    End::Most => advantage(largest(&columns[1..]), columns[0]),
                };
                plain(beyond - effect, self.chain(metric, columns, place, beyond))
            }
            Self::Similar { metric, of, to, ratio: [low, high] } => plain(
                (columns[0] - low).min(high - columns[0]),
                format!("{metric} of {} / {} on {place}: {}", of.name, to.name, digits(columns[0])),
            ),
            Self::Correlation { x, y, sign, least, .. } => plain(
                columns[0] * sign.factor() - least,
                format!("rank correlation of {x} and {y} on {place}: {:+.2}", columns[0]),
            ),
            Self::Strongest { x, than, y, sign, effect, .. } => {
                let others: Vec<f64> = columns[1..].iter().map(|other| other * sign.factor()).collect();
                let named: Vec<String> = (std::iter::once(x).chain(than).zip(columns))
                    .map(|(metric, correlation)| format!("{metric} {correlation:+.2}"))
                    .collect();
                plain(
                    columns[0] * sign.factor() - largest(&others).max(0.0) - effect,
                    format!("rank correlations with {y} on {place}: {}", named.join(", ")),
                )
            }
            Self::Trend { metric, along: settings, direction, effect } => {
                let steps = columns.windows(2).map(|pair| along(*direction, pair[0], pair[1]));
                let whole = along(*direction, columns[0], columns[columns.len() - 1]);
                let margin = smallest(&steps.collect::<Vec<_>>()).min(whole - effect);
                let named = named(&settings.iter().collect::<Vec<_>>(), columns);
                plain(margin, format!("{metric} on {place}: {}", named.join(", ")))
            }
            Self::Shift { metric, of, to, from, direction, effect } => plain(
                along(*direction, columns[0], columns[1]) - effect,
                format!(
                    "{metric} of {} / {}: {} on {from}, {} on {place}",
                    of.name,
                    to.name,
                    digits(columns[0]),
                    digits(columns[1])
                ),
            ),
            Self::Contrast { metric, of, to, lower, higher, effect } => {
                let (low, high) = columns.split_at(lower.len());
                let by = advantage(largest(low), smallest(high));
                let parts = lower.iter().chain(higher).zip(columns);
                let named: Vec<String> = parts
                    .map(|(condition, &value)| format!("{} {}", condition.name, digits(value)))
                    .collect();
                plain(
                    by - effect,
                    format!(
                        "{metric} of {} / {} on {place}: {} against {} ({})",
                        of.name,
                        to.name,
                        named[..lower.len()].join(", "),
                        named[lower.len()..].join(", "),
                        percent(by)
                    ),
                )
            }
            Self::Swap { metric, across, effect } => {
                let (by, best) = swap(across, columns);
                plain(by - effect, format!("least {metric} on {place}: {best} ({})", percent(by)))
            }
            Self::Property { metric, of, bound } => {
                let margin = match bound {
                    Bound::Equals(value) => -(columns[0] - value).abs(),
                    Bound::AtLeast(least) => columns[0] - least,
                    Bound::AtMost(most) => most - columns[0],
                };
                plain(margin, format!("{metric} of {} on {place}: {}", of.name, digits(columns[0])))
            }
            Self::Untestable { reason } => plain(f64::NEG_INFINITY, reason.clone()),
        }
    }

    /// The variants by rising figure, and by how much the order holds.
    fn chain(&self, metric: &Metric, columns: &[f64], place: &str, by: f64) -> String {
        let mut named: Vec<(f64, &str)> = self
            .variants()
            .iter()
            .zip(columns)
            .map(|(variant, &value)| (value, variant.name.as_str()))
            .collect();
        named.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut text = format!("{metric} on {place}: ");
        for (index, (value, name)) in named.iter().enumerate() {
            text += match index.checked_sub(1).map(|before| named[before].0 < *value) {
                None => "",
                Some(true) => " < ",
                Some(false) => " = ",
            };
            text += &format!("{name} {}", digits(*value));
        }
        format!("{text} ({})", percent(by))
    }

    /// What the rule asks for.
    pub(super) fn wanted(&self) -> String {
        let by = |effect: &f64| format!("by at least {}", percent(*effect));
        match self {
            Self::Number { within, .. } => {
                format!("at most {} off", percent(*within).trim_start_matches('+'))
            }
            Self::Order { ascending, effect, .. } => {
                let groups: Vec<String> = ascending
                    .iter()
                    .map(|group| {
                        let names: Vec<&str> = group.iter().map(|variant| variant.name.as_str()).collect();
                        if names.len() == 1 {
                            names[0].to_owned()
                        } else {
                            format!("{{{}}}", names.join(", "))
                        }
                    })
                    .collect();
                format!("{} {}", groups.join(" < "), by(effect))
            }
            Self::Extreme { end: End::Least, of, effect, .. } => format!("{} least {}", of.name, by(effect)),
            Self::Extreme { end: End::Most, of, effect, .. } => format!("{} most {}", of.name, by(effect)),
            Self::Similar { ratio: [low, high], .. } if low == high => format!("{low}"),
            Self::Similar { ratio: [low, high], .. } => format!("{low} to {high}"),
            Self::Correlation { sign, least, .. } => format!("{:+} or beyond", least * sign.factor()),
            Self::Strongest { x, effect, .. } => format!("{x} strongest by at least {effect}"),
            Self::Trend { direction, effect, .. } => {
                format!("{} at every step, {}", name(*direction), by(effect))
            }
            Self::Shift { direction, effect, .. } => format!("{} {}", name(*direction), by(effect)),
            Self::Contrast { effect, lower, higher, .. } => {
                let names = |conditions: &[Condition]| -> String {
                    conditions.iter().map(|condition| condition.name.as_str()).collect::<Vec<_>>().join(", ")
                };
                format!("{{{}}} < {{{}}} {}", names(lower), names(higher), by(effect))
            }
            Self::Swap { effect, .. } => {
                format!("different ones, each better at home than the other {}", by(effect))
            }
            Self::Property { bound: Bound::Equals(value), .. } => format!("exactly {value}"),
            Self::Property { bound: Bound::AtLeast(least), .. } => format!("at least {least}"),
            Self::Property { bound: Bound::AtMost(most), .. } => format!("at most {most}"),
            Self::Untestable { .. } => "a measurement that decides it".to_owned(),
        }
    }
}

/// By how much two platforms disagree most on what is best, and the best of each.
fn swap(across: &[Condition], columns: &[f64]) -> (f64, String) {
    let width = across.first().map_or(1, |condition| condition.among.len());
    let rows: Vec<&[f64]> = columns.chunks(width).collect();
    let best = |row: &[f64]| (0..row.len()).min_by(|&a, &b| row[a].total_cmp(&row[b])).unwrap_or(0);
    let bests: Vec<usize> = rows.iter().map(|row| best(row)).collect();
    let by = rows.iter().zip(&bests).enumerate().flat_map(|(place, (row, &mine))| {
        let others = rows.iter().zip(&bests).skip(place + 1);
        others.map(move |(other, &theirs)| {
            advantage(row[mine], row[theirs]).min(advantage(other[theirs], other[mine]))
        })
    });
    let named = across
        .iter()
        .zip(&rows)
        .zip(&bests)
        .map(|((condition, row), &mine)| format!("{} {}", condition.among[mine].name, digits(row[mine])));
    (largest(&by.collect::<Vec<_>>()), named.collect::<Vec<_>>().join(", "))
}

fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::Rising => "rising",
        Direction::Falling => "falling",
    }
}

fn named(variants: &[&Variant], columns: &[f64]) -> Vec<String> {
    variants
        .iter()
        .zip(columns)
        .map(|(variant, &value)| format!("{} {}", variant.name, digits(value)))
        .collect()
}

/// A relative difference in percent, with its sign.
pub(super) fn percent(relative: f64) -> String {
    if relative.is_infinite() {
        return "from 0".to_owned();
    }
    let percent = relative * 100.0;
    let decimals = if percent.abs() >= 10.0 || (percent - percent.round()).abs() < 1e-6 { 0 } else { 2 };
    format!("{percent:+.decimals$} %")
}
