//! What the tables of a comparison show, and how a difference is told.

use super::{Comparison, Variant};
use crate::counters::{Counter, Value};
use crate::units;

/// A counter that tables show.
pub(super) struct Column {
    pub(super) id: &'static str,
    pub(super) heading: &'static str,
}

/// The columns of the tables, before the deciding bound.
pub(super) const COLUMNS: [Column; 9] = [
    Column { id: "frame_time_ms", heading: "Frame Time" },
    Column { id: "fps", heading: "Frames / Second" },
    Column { id: "mrays_per_second", heading: "Mrays / Second" },
    Column { id: "node_fetches_per_ray", heading: "Node Fetches / Ray" },
    Column { id: "sp_memory_read_bytes", heading: "SP Memory Read" },
    Column { id: "alu_per_fragment", heading: "ALU / Fragment" },
    Column { id: "dram_read_bytes", heading: "DRAM Read" },
    Column { id: "energy_mj", heading: "Energy" },
    Column { id: "structure_bytes", heading: "Structure Bytes" },
];

pub(super) const BOUND: &str = "Deciding Bound";

/// What stands for a figure that there is not.
pub(super) const NONE: &str = "-";

/// One column of a table: all variants in one unit.
pub(super) struct Figures {
    /// The unit; empty where the heading says it.
    pub(super) unit: &'static str,
    /// The figure of each variant, and how it differs from the first; the difference is empty where there is none.
    pub(super) rows: Vec<[String; 2]>,
}

impl Comparison {
    /// A counter of all variants; none where no variant knows it.
    pub(super) fn figures(&self, id: &str) -> Option<Figures> {
        let unit =
            self.variants.iter().find_map(|variant| variant.counter(id)).map(|counter| &counter.unit)?;
        let numbers: Vec<Option<f64>> = self.variants.iter().map(|variant| variant.number(id)).collect();
        let largest = numbers.iter().flatten().fold(0.0, |largest: f64, number| largest.max(number.abs()));
        let (size, unit) = units::scale(unit, largest);
        let first = numbers.first().copied().flatten();
        let row = |(index, (variant, number)): (usize, (&Variant, &Option<f64>))| {
            let shown = match (variant.counter(id).map(|counter| &counter.value), number) {
                (Some(&Value::Count(count)), _) if size <= 1.0 => units::grouped(count),
                (_, Some(number)) => units::digits(number / size),
                (_, None) => NONE.to_owned(),
            };
            let ratio = ratio(*number, first).filter(|_| index > 0);
            [shown, ratio.map(|ratio| difference(ratio, variant.reach(id, ratio))).unwrap_or_default()]
        };
        let rows = self.variants.iter().zip(&numbers).enumerate().map(row).collect();
        Some(Figures { unit, rows })
    }

    /// Why figures of the tables are absent, in sentences.
    pub(crate) fn absences(&self) -> Vec<String> {
        let mut known: Vec<(&str, &str, Vec<String>)> = Vec::new();
        for Column { id, heading } in &COLUMNS {
            for variant in &self.variants {
                let Some(Counter { value: Value::Absent { reason }, .. }) = variant.counter(id) else {
                    continue;
                };
                let name = self.name(variant);
                match known.iter_mut().find(|(of, why, _)| of == heading && why == reason) {
                    Some((.., names)) => names.push(name),
                    None => known.push((heading, reason, vec![name])),
                }
            }
        }
        let all = self.variants.len();
        let sentence = |(heading, reason, names): (&str, &str, Vec<String>)| match names.len() {
            count if count == all => format!("{heading}: {reason}"),
            _ => format!("{heading} of {}: {reason}", names.join(", ")),
        };
        known.into_iter().map(sentence).collect()
    }
}

impl Variant {
    pub(super) fn counter(&self, id: &str) -> Option<&Counter> {
        self.report.counters.get(id)
    }

    pub(super) fn number(&self, id: &str) -> Option<f64> {
        self.counter(id)?.value.as_f64()
    }

    /// How far the interval of a ratio to the first variant reaches from it, where there is one.
    pub(crate) fn reach(&self, id: &str, ratio: f64) -> Option<f64> {
        self.ratios_ci95.get(id).map(|[low, high]| (ratio - low).max(high - ratio))
    }

    pub(super) fn deciding_bound(&self) -> &str {
        self.report.deciding_bound.as_deref().unwrap_or(NONE)
    }
}

/// A figure relative to the first; 1 where both are 0, none where only the first is.
pub(crate) fn ratio(number: Option<f64>, first: Option<f64>) -> Option<f64> {
    let (number, first) = (number?, first?);
    let ratio = if number == first { 1.0 } else { number / first };
    ratio.is_finite().then_some(ratio)
}

/// A ratio in words: percent of difference from half to double, a factor of three digits beyond; behind it how far it may be off.
pub(super) fn difference(ratio: f64, reach: Option<f64>) -> String {
    let percent = (ratio - 1.0) * 100.0;
    let points = |points: f64| {
        let decimals = if points.abs() < 9.95 { 1 } else { 0 };
        move |sign: bool| match sign {
            true => format!("{points:+.decimals$}"),
            false => format!("{points:.decimals$}"),
        }
    };
    let is_factor = !(0.5..2.0).contains(&ratio);
    let (shown, unit) = match ratio {
        1.0 => ("0".to_owned(), " %"),
        _ if is_factor => (format!("x{}", units::short(units::rounded(ratio, 2))), ""),
        _ => (points(percent)(true), " %"),
    };
    match reach.filter(|reach| *reach > 0.0) {
        None => shown + unit,
        Some(reach) if is_factor => format!("{shown} \u{b1}{}", units::short(units::rounded(reach, 1))),
        Some(reach) => format!("{shown} \u{b1}{}{unit}", points(100.0 * reach)(false)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_differences_are_percent_and_large_ones_factors() {
        let cases = [
            (1.0, "0 %"),
            (1.000_1, "+0.0 %"),
            (0.82, "-18 %"),
            (0.95, "-5.0 %"),
            (0.5, "-50 %"),
            (0.499, "x0.499"),
            (1.53, "+53 %"),
            (1.999, "+100 %"),
            (2.0, "x2"),
            (12.345_6, "x12.3"),
            (0.081_99, "x0.082"),
            (1234.5, "x1,230"),
            (0.0, "x0"),
        ];
        for (ratio, text) in cases {
            assert_eq!(difference(ratio, None), text);
        }
    }

    #[test]
    fn how_far_a_difference_may_be_off_stands_behind_it() {
        let cases = [
            (1.0, 0.0, "0 %"),
            (1.0, 0.002, "0 \u{b1}0.2 %"),
            (0.95, 0.000_1, "-5.0 \u{b1}0.0 %"),
            (0.68, 0.012, "-32 \u{b1}1.2 %"),
            (1.53, 0.25, "+53 \u{b1}25 %"),
            (0.25, 0.031, "x0.25 \u{b1}0.031"),
            (12.3, 1.7, "x12.3 \u{b1}1.7"),
        ];
        for (ratio, reach, text) in cases {
            assert_eq!(difference(ratio, Some(reach)), text);
        }
    }

    #[test]
    fn nothing_is_relative_to_what_is_absent_or_0() {
        assert_eq!(ratio(Some(3.0), Some(2.0)), Some(1.5));
        assert_eq!(ratio(Some(0.0), Some(0.0)), Some(1.0));
        assert_eq!(ratio(Some(3.0), Some(0.0)), None);
        assert_eq!(ratio(Some(3.0), None), None);
        assert_eq!(ratio(None, Some(3.0)), None);
    }
}
