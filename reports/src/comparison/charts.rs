//! One chart for each counter that a comparison is about.

use super::{Comparison, Variant};
use crate::chart::{BarChart, MOST_SERIES, Scale, Series};
use crate::units;

/// What a chart shows.
struct Subject {
    /// Stem of the file's name.
    stem: &'static str,
    heading: &'static str,
    figure: Figure,
}

enum Figure {
    Counter(&'static str),
    /// A counter divided by the pixels of the frame; a list of rays has none.
    PerPixel(&'static str),
}

const fn counter(stem: &'static str, heading: &'static str, id: &'static str) -> Subject {
    Subject { stem, heading, figure: Figure::Counter(id) }
}

const SUBJECTS: [Subject; 10] = [
    counter("frames-per-second", "Frames / second", "fps"),
    counter("frame-time", "Frame time", "frame_time_ms"),
    Subject {
        stem: "node-fetches-per-pixel",
        heading: "Node fetches / pixel",
        figure: Figure::PerPixel("node_fetches"),
    },
    counter("node-fetches-per-ray", "Node fetches / ray", "node_fetches_per_ray"),
    counter("sp-memory-read", "SP memory read", "sp_memory_read_bytes"),
    counter("alu-per-fragment", "ALU / fragment", "alu_per_fragment"),
    counter("structure-bytes", "Size of the structure", "structure_bytes"),
    counter("dram-read", "DRAM read", "dram_read_bytes"),
    counter("l1-miss-ratio", "L1 miss ratio", "l1_miss_ratio"),
    counter("l2-miss-ratio", "L2 miss ratio", "l2_miss_ratio"),
];

/// Values that differ by this factor need a logarithmic scale.
const WIDE: f64 = 100.0;

impl Figure {
    fn id(&self) -> &'static str {
        match self {
            Self::Counter(id) | Self::PerPixel(id) => id,
        }
    }

    fn of(&self, variant: &Variant) -> Option<f64> {
        let number = variant.number(self.id())?;
        match self {
            Self::Counter(_) => Some(number),
            Self::PerPixel(_) => {
                let pixels =
                    f64::from(variant.report.inputs.width?) * f64::from(variant.report.inputs.height?);
                (pixels > 0.0).then(|| number / pixels)
            }
        }
    }
}

/// Which axes become groups and which one series.
struct Roles {
    groups: Vec<usize>,
    series: Option<usize>,
    constant: Vec<usize>,
}

/// In the order of their first appearance.
fn distinct(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    texts.for_each(|text| {
        if !distinct.contains(&text) {
            distinct.push(text);
        }
    });
    distinct
}

impl Comparison {
    /// A chart for each counter of interest that some variant has, and a stem for its file's name. The last axis with more
    /// than one value becomes the series, the others the groups; an axis with more values than a legend can tell apart
    /// becomes groups too. Of variants at the same place the first is shown.
    pub fn charts(&self) -> Vec<(String, BarChart)> {
        let roles = self.roles();
        let chart = |subject: &Subject| Some((subject.stem.to_owned(), self.chart(subject, &roles)?));
        SUBJECTS.iter().filter_map(chart).collect()
    }

    fn joined(&self, variant: &Variant, axes: &[usize]) -> String {
        axes.iter().map(|&axis| variant.value(axis)).collect::<Vec<_>>().join(", ")
    }

    fn roles(&self) -> Roles {
        let count = |axis| distinct(self.variants.iter().map(|variant| self.joined(variant, &[axis]))).len();
        let (varying, constant): (Vec<usize>, Vec<usize>) =
            (0..self.axes.len()).partition(|&axis| count(axis) > 1);
        let series = varying.iter().copied().rev().find(|&axis| count(axis) <= MOST_SERIES);
        let groups = varying.into_iter().filter(|&axis| Some(axis) != series).collect();
        Roles { groups, series, constant }
    }

    fn chart(&self, Subject { heading, figure, .. }: &Subject, roles: &Roles) -> Option<BarChart> {
        let numbers: Vec<f64> = self.variants.iter().filter_map(|variant| figure.of(variant)).collect();
        let max = numbers.iter().copied().reduce(f64::max)?;
        let min = numbers.iter().copied().fold(max, f64::min);
        let counter = self.variants.iter().find_map(|variant| variant.counter(figure.id()))?;
        let (size, scaled) = units::scale(&counter.unit, max);
        let unit = if scaled.is_empty() { counter.unit.as_str() } else { scaled };

        let group = |variant: &Variant| self.joined(variant, &roles.groups);
        let series = |variant: &Variant| roles.series.map_or("", |axis| variant.value(axis)).to_owned();
        let groups = distinct(self.variants.iter().map(group));
        let names = distinct(self.variants.iter().map(series));
        let value = |name: &str, of: &str| {
            let is = |variant: &&Variant| series(variant) == name && group(variant) == of;
            Some(figure.of(self.variants.iter().find(is)?)? / size)
        };
        let series = names.iter().map(|name| Series {
            name: name.clone(),
            values: groups.iter().map(|group| value(name, group)).collect(),
        });
        let series = series.collect();
        let constant = self.variants.first().map(|variant| self.joined(variant, &roles.constant));
        let constant = constant.filter(|text| !text.is_empty()).map(|text| format!("; {text}"));
        Some(BarChart {
            title: (*heading).to_owned(),
            subtitle: format!("{}{}", self.title, constant.unwrap_or_default()),
            value_label: format!("{heading} ({unit})"),
            groups,
            series,
            scale: if min > 0.0 && max / min >= WIDE { Scale::Log } else { Scale::Linear },
        })
    }
}
