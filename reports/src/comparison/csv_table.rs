//! The comparison as CSV in long form: one row for each variant and counter of the frame.

use super::figures::ratio;
use super::{Comparison, Variant};
use crate::counters::{Counter, Value};

/// The columns after those of the axes. `value` is empty exactly where `absent` gives the reason; `relative` is the value
/// divided by that of the first variant, and empty where one of the two is absent or only the first is 0; `relative_low` and
/// `relative_high` are the ends of its interval of 95 %, where both were sampled by the same tiles.
pub const COLUMNS: [&str; 7] = ["id", "unit", "value", "relative", "absent", "relative_low", "relative_high"];

/// The comparison as CSV with a heading.
pub fn write(comparison: &Comparison) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let heading = comparison.axes.iter().map(String::as_str).chain(COLUMNS);
    let first = comparison.variants.first();
    let rows = comparison.variants.iter().flat_map(|variant| {
        variant.report.counters.iter().map(move |(id, counter)| {
            let axes = (0..comparison.axes.len()).map(|axis| variant.value(axis).to_owned());
            axes.chain(cells(id, counter, (variant, first))).collect::<Vec<String>>()
        })
    });
    for row in std::iter::once(heading.map(str::to_owned).collect()).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

fn cells(id: &str, counter: &Counter, (variant, first): (&Variant, Option<&Variant>)) -> [String; 7] {
    let (value, absent) = match &counter.value {
        Value::Count(count) => (count.to_string(), String::new()),
        Value::Real(real) => (real.to_string(), String::new()),
        Value::Absent { reason } => (String::new(), reason.clone()),
    };
    let relative = ratio(counter.value.as_f64(), first.and_then(|first| first.number(id)));
    let relative = relative.map(|ratio| ratio.to_string()).unwrap_or_default();
    let [low, high] = match variant.ratios_ci95.get(id) {
        Some(ends) => ends.map(|end| end.to_string()),
        None => [String::new(), String::new()],
    };
    [id.to_owned(), counter.unit.clone(), value, relative, absent, low, high]
}
