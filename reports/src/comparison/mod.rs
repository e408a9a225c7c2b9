//! Reports that differ along named axes, side by side: which traversal, which layout, which GPU.
//!
//! [`text`] is for the terminal, [`markdown`] for documents, [`csv_table`] and [`json`] for programs, and
//! [`Comparison::charts`] for eyes. Differences are relative to the first variant. The table of values beside a chart is the
//! CSV.

mod charts;
pub mod csv_table;
mod figures;
pub mod json;
pub mod markdown;
pub mod text;

use crate::report::Report;

/// Reports and what distinguishes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub title: String,
    /// Names of what varies, such as "scene", "traversal", "layout".
    pub axes: Vec<String>,
    /// The variants; the others are told relative to the first.
    pub variants: Vec<Variant>,
}

/// One of the reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its place on each of the axes, in their order. A missing one is shown empty, and one too many is not shown.
    pub values: Vec<String>,
    /// Its report.
    pub report: Report,
}

impl Variant {
    /// Its place on an axis.
    fn value(&self, axis: usize) -> &str {
        self.values.get(axis).map_or("", String::as_str)
    }
}

impl Comparison {
    /// The place of a variant on all axes, in words.
    fn name(&self, variant: &Variant) -> String {
        (0..self.axes.len()).map(|axis| variant.value(axis)).collect::<Vec<_>>().join(" ")
    }
}
