//! What the frame time is made of, and its lower bounds.

use super::markup::{Cell, Column, Group, Table, bar};
use crate::report::{Bound, Report, TimePart};
use crate::units;

pub(super) fn write(report: &Report) -> String {
    let (bar, parts) = stack(&report.stack);
    let bounds = bounds(&report.bounds, report.deciding_bound.as_deref());
    match (parts.is_empty(), bounds.is_empty()) {
        (true, true) => String::new(),
        _ => format!("{bar}<div class=\"beside\">{parts}{bounds}</div>\n"),
    }
}

/// A bar and a table of the parts, the largest first.
fn stack(parts: &[TimePart]) -> (String, String) {
    let all: f64 = parts.iter().map(|part| part.seconds).sum();
    if all <= 0.0 {
        return (String::new(), String::new());
    }
    let mut parts: Vec<&TimePart> = parts.iter().collect();
    parts.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let segment = |(series, part): (usize, &&TimePart)| {
        let share = part.seconds / all;
        let sentence =
            format!("{}: {} ms, {:.1} %", part.name, units::digits(part.seconds * 1e3), 100.0 * share);
        (series, sentence, share)
    };
    let segments: Vec<_> = parts.iter().enumerate().map(segment).collect();
    let row = |(series, part): (usize, &&TimePart)| {
        vec![
            Cell::name(&part.name, series),
            Cell::number(part.seconds * 1e3),
            Cell::per_cent(part.seconds / all),
        ]
    };
    let table = Table {
        label: "Parts of the frame time".to_owned(),
        columns: vec![
            Column::words("what warps use or wait for"),
            Column::figures("ms"),
            Column::figures("%"),
        ],
        groups: vec![Group { title: None, rows: parts.iter().enumerate().map(row).collect() }],
        filter: false,
    };
    (bar("Parts of the frame time, as in the table below", &segments), table.to_string())
}

fn bounds(bounds: &[Bound], deciding: Option<&str>) -> String {
    if bounds.is_empty() {
        return String::new();
    }
    let row = |bound: &Bound| {
        let about = if deciding == Some(&bound.name) { "decides" } else { "" };
        vec![
            Cell::Words(bound.name.clone()),
            Cell::number(bound.seconds * 1e3),
            Cell::Words(about.to_owned()),
        ]
    };
    let table = Table {
        label: "Lower bounds of the frame time".to_owned(),
        columns: vec![Column::words("lower bound"), Column::figures("ms"), Column::words("")],
        groups: vec![Group { title: None, rows: bounds.iter().map(row).collect() }],
        filter: false,
    };
    table.to_string()
}
