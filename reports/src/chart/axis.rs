//! The value axis of bars: its range, ticks and their labels.

use super::bars::Scale;
use crate::picture::ticks;
use crate::units;

const MOST_TICKS: usize = 7;

/// A value axis.
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Axis {
    /// The axis of finite values, above 0 where it is logarithmic and otherwise at least 0.
    pub(super) fn new(scale: Scale, values: &[f64]) -> Self {
        let max = values.iter().copied().fold(0.0, f64::max);
        match scale {
            Scale::Linear => Self { scale, low: 0.0, high: if max > 0.0 { max } else { 1.0 } },
            Scale::Log => {
                let min = values.iter().copied().fold(f64::INFINITY, f64::min);
                // The shortest bar still shows, and equal bars are not all as short as that.
                let span = max.log10() - min.log10();
                let foot = (span / 50.0).max(0.18).max(1.0 - span);
                let below = 10_f64.powf(min.log10() - foot).max(f64::MIN_POSITIVE);
                let power = 10_f64.powf(below.log10().floor());
                let low = [5.0, 2.0, 1.0].map(|factor| factor * power).into_iter().find(|&low| low <= below);
                let low = low.unwrap_or(below);
                Self { scale, low, high: max }
            }
        }
    }

    /// Where a value stands, 0 to 1.
    pub(super) fn part(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value / self.high,
            Scale::Log => (value.log10() - self.low.log10()) / (self.high.log10() - self.low.log10()),
        }
    }

    /// Where ticks stand, and their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let (values, labels) = match self.scale {
            Scale::Linear => {
                let values = ticks::linear(self.low, self.high, MOST_TICKS, 0.0);
                let labels = units::tick_labels(&values);
                (values, labels)
            }
            Scale::Log => {
                let values = ticks::logarithmic(self.low, self.high, MOST_TICKS);
                let labels = values.iter().map(|&value| units::short(value)).collect();
                (values, labels)
            }
        };
        values.into_iter().map(|value| self.part(value)).zip(labels).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_axis_begins_at_0_and_ends_at_the_largest_value() {
        let axis = Axis::new(Scale::Linear, &[3.0, 12.0]);
        assert_eq!([0.0, 3.0, 12.0].map(|value| axis.part(value)), [0.0, 0.25, 1.0]);
        let labels: Vec<String> = axis.ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["0", "2", "4", "6", "8", "10", "12"]);
        assert_eq!(Axis::new(Scale::Linear, &[0.0]).part(0.0), 0.0);
    }

    #[test]
    fn a_logarithmic_axis_leaves_the_shortest_bar_some_height() {
        for values in [&[1.0, 1e6][..], &[7.0], &[1e-9, 1e12], &[100.0, 100.0], &[1e-300, 1e300]] {
            let axis = Axis::new(Scale::Log, values);
            let parts: Vec<f64> = values.iter().map(|&value| axis.part(value)).collect();
            assert!(parts[0] > 0.005 && parts[parts.len() - 1] == 1.0, "{values:?}: {parts:?}");
            let ticks = axis.ticks();
            assert!((2..=8).contains(&ticks.len()), "{values:?}: {ticks:?}");
            assert!(ticks.iter().all(|(part, _)| (0.0..=1.0).contains(part)), "{values:?}: {ticks:?}");
        }
    }
}
