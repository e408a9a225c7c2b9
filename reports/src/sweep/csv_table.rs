//! A sweep as a table of columns of one type each: one row for each point.

use super::{Sweep, SweptPoint, front};
use crate::counters::Value;
use crate::csv_rows;
use crate::within::Within;
use gpumodel::COUNTERS;

/// A column; every cell that is not empty is of its type.
struct Column<'a> {
    name: &'a str,
    kind: Kind,
    unit: &'a str,
    meaning: String,
    cells: Vec<Option<String>>,
}

/// What a column holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Integer,
    Real,
    Boolean,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Integer => "integer",
            Self::Real => "real",
            Self::Boolean => "boolean",
        }
    }

    /// The narrowest that all cells have.
    fn of(cells: &[&str]) -> Self {
        if cells.iter().all(|cell| cell.parse::<i64>().is_ok()) {
            Self::Integer
        } else if cells.iter().all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite)) {
            Self::Real
        } else {
            Self::Text
        }
    }
}

/// One row for each point: its hash, its options, whether it is on the Pareto front, why it failed, how far figures may be off, and all
/// counters of the frame. An empty cell is an option that is not set, or a figure that the point's file gives the reason for.
pub fn write(sweep: &Sweep) -> String {
    let columns = columns(sweep);
    let mut table = csv::Writer::from_writer(Vec::new());
    let heading: Vec<&str> = columns.iter().map(|column| column.name).collect();
    table.write_record(&heading).expect("memory takes every record");
    for row in 0..sweep.points.len() {
        let cells = columns.iter().map(|column| column.cells[row].as_deref().unwrap_or_default());
        table.write_record(cells).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

/// What the columns of [`write()`] are, in their order: name, type, unit, meaning.
pub fn columns_text(sweep: &Sweep) -> String {
    let row = |column: &Column<'_>| {
        [
            column.name.to_owned(),
            column.kind.name().to_owned(),
            column.unit.to_owned(),
            column.meaning.clone(),
        ]
    };
    csv_rows::text(["name", "type", "unit", "meaning"], columns(sweep).iter().map(row))
}

fn columns(sweep: &Sweep) -> Vec<Column<'_>> {
    let points = &sweep.points;
    let column = |name, kind, unit, meaning: &str, cell: &dyn Fn(&SweptPoint) -> Option<String>| Column {
        name,
        kind,
        unit,
        meaning: meaning.to_owned(),
        cells: points.iter().map(cell).collect(),
    };
    let on_front = front(sweep);
    let mut columns =
        vec![column("point", Kind::Text, "", "hash of the inputs; stem of its file", &|point| {
            Some(point.id.clone())
        })];
    for (option, name) in sweep.options.iter().enumerate() {
        let set: Vec<&str> = points.iter().filter_map(|point| point.values[option].as_deref()).collect();
        let meaning = "option of raybudget profile, or figure of the GPU";
        columns.push(column(name, Kind::of(&set), "", meaning, &|point| point.values[option].clone()));
    }
    let flags = (0..points.len()).map(|index| Some(on_front.contains(&index).to_string()));
    columns.push(Column {
        name: "pareto",
        kind: Kind::Boolean,
        unit: "",
        meaning: "no point is as good in every objective and better in one".to_owned(),
        cells: flags.collect(),
    });
    columns.push(column("failure", Kind::Text, "", "why the point has no figures", &|point| {
        point.outcome.as_ref().err().cloned()
    }));
    let error = |part: fn(f64, f64) -> f64| {
        move |point: &SweptPoint| match point.outcome.as_ref().ok()?.within.as_ref()? {
            Within::Known { frame_time, dram_bytes, .. } => Some(part(*frame_time, *dram_bytes).to_string()),
            Within::Unknown { .. } => None,
        }
    };
    let meaning = "how far the figure may be from the simulated one, at most";
    columns.push(column("frame_time_error", Kind::Real, "ratio", meaning, &error(|time, _| time)));
    columns.push(column("dram_bytes_error", Kind::Real, "ratio", meaning, &error(|_, bytes| bytes)));
    for info in COUNTERS {
        let value = |point: &SweptPoint| match &point.outcome.as_ref().ok()?.counters.get(info.id)?.value {
            Value::Absent { .. } => None,
            value => Some(value.clone()),
        };
        let present: Vec<Value> = points.iter().filter_map(value).collect();
        if present.is_empty() {
            continue;
        }
        let counts = present.iter().all(|value| matches!(value, Value::Count(_)));
        let kind = if counts { Kind::Integer } else { Kind::Real };
        columns.push(column(info.id, kind, info.unit, info.formula, &|point| {
            value(point).map(|value| match value {
                Value::Count(count) => count.to_string(),
                Value::Real(real) => real.to_string(),
                Value::Absent { .. } => unreachable!("these were left out"),
            })
        }));
    }
    columns
}

/// The Pareto front: the varying options and the objectives of its points, as the table has them.
pub fn front_text(sweep: &Sweep) -> String {
    let (options, on_front) = (sweep.varying(), front(sweep));
    let mut table = csv::Writer::from_writer(Vec::new());
    let names = options.iter().map(|&option| sweep.options[option].as_str());
    let objectives = sweep.objectives.iter().map(|objective| objective.counter.as_str());
    let heading: Vec<&str> = std::iter::once("point").chain(names).chain(objectives).collect();
    table.write_record(heading).expect("memory takes every record");
    for point in on_front.into_iter().map(|index| &sweep.points[index]) {
        let values = options.iter().map(|&option| point.values[option].clone().unwrap_or_default());
        let figures = sweep.objectives.iter().map(|objective| {
            point.number(&objective.counter).map(|number| number.to_string()).unwrap_or_default()
        });
        let row: Vec<String> = std::iter::once(point.id.clone()).chain(values).chain(figures).collect();
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}
