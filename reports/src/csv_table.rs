//! Counters as CSV: one row for each counter of the frame (empty `pass`) and of each pass.

use crate::counters::{Counter, Value};
use crate::report::Report;
use crate::units;

/// The columns. `value` is empty exactly where `absent` gives the reason.
pub const COLUMNS: [&str; 9] =
    ["id", "name", "pass", "value", "unit", "ci95_low", "ci95_high", "from", "absent"];

/// The report's counters as CSV with a heading.
pub fn write(report: &Report) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let frame = report.counters.iter().map(|(id, counter)| ("", id, counter));
    let passes = report
        .passes
        .iter()
        .flat_map(|pass| pass.counters.iter().map(|(id, counter)| (pass.name.as_str(), id, counter)));
    let rows = frame.chain(passes).map(|(pass, id, counter)| row(pass, id, counter));
    for row in std::iter::once(COLUMNS.map(str::to_owned)).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

fn row(pass: &str, id: &str, counter: &Counter) -> [String; 9] {
    let name = units::counter_info(id).map_or(id, |info| info.name);
    let (value, absent) = match &counter.value {
        Value::Count(count) => (count.to_string(), String::new()),
        Value::Real(real) => (real.to_string(), String::new()),
        Value::Absent { reason } => (String::new(), reason.clone()),
    };
    let [low, high] = match counter.ci95 {
        Some(ci95) => ci95.map(|end| end.to_string()),
        None => Default::default(),
    };
    let text = str::to_owned;
    [
        text(id),
        text(name),
        text(pass),
        value,
        counter.unit.clone(),
        low,
        high,
        text(counter.from.name()),
        absent,
    ]
}
