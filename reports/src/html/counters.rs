//! Counters by group, with what each means; ours, and those of the maker's profiler.

use super::markup::{Cell, Column, Escaped, Group, Table, folded};
use crate::counters::{Counter, Counters, Fidelity, Value};
use crate::report::Report;
use crate::text::{absent_sentences, margin, vendor_view};
use crate::vendor::{Formula, Profiler, VendorCounter, VendorInfo, VendorView};
use gpumodel::{COUNTERS, CounterInfo};

pub(super) fn write(report: &Report) -> String {
    let mut groups: Vec<Group> = Vec::new();
    for info in COUNTERS {
        let Some(row) = row(info, report) else { continue };
        Group::add(&mut groups, info.group, row);
    }
    let table = Table {
        label: "Counters".to_owned(),
        columns: columns(report, is_sample(report)),
        groups,
        filter: true,
    };
    let vendor =
        vendor_view(report).map_or(String::new(), |(view, profiler)| vendor(report, view, &profiler));
    let absent: String = absent_sentences(report)
        .iter()
        .map(|(title, reasons)| folded(title, reasons.iter().map(String::as_str)))
        .collect();
    format!("{table}{vendor}{absent}")
}

/// Only the figures of a sample may be off.
fn is_sample(report: &Report) -> bool {
    report.run.fidelity == Fidelity::Sampled
}

fn columns(report: &Report, with_margin: bool) -> Vec<Column> {
    let margin = with_margin.then(|| Column::words("95 %"));
    let passes = report.passes.iter().map(|pass| Column::figures(&pass.name));
    [Column::words("counter"), Column::figures("frame")].into_iter().chain(margin).chain(passes).collect()
}

/// Of a counter that the frame has.
fn row(info: &CounterInfo, report: &Report) -> Option<Vec<Cell>> {
    let counter = report.counters.get(info.id)?;
    counter.value.as_f64()?;
    let name = Cell::counter_name(info);
    let of = |counters: &Counters| match counters.get(info.id) {
        Some(Counter { value, unit, .. }) => Cell::counter(value, unit),
        None => Cell::Absent("a pass has no such counter".to_owned()),
    };
    let margin = is_sample(report).then(|| Cell::Words(margin(counter)));
    let passes = report.passes.iter().map(|pass| of(&pass.counters));
    Some([name, of(&report.counters)].into_iter().chain(margin).chain(passes).collect())
}

fn vendor(report: &Report, view: &VendorView, profiler: &Profiler) -> String {
    let row = |info: &VendorInfo| {
        let VendorCounter { value, unit, formula } = view.counters.get(&info.name)?;
        value.as_f64()?;
        let known = match &info.formula {
            Formula::Known(formula) => Some(formula.text().to_owned()),
            Formula::Absent { .. } => None,
        };
        let about = [
            ("Meaning", Some(info.definition.clone())),
            ("Formula", formula.clone().or(known)),
            ("Unit", Some(unit.clone())),
            ("Source", Some(info.source.clone())),
        ];
        let about =
            about.into_iter().filter_map(|(what, text)| Some((what, text.filter(|text| !text.is_empty())?)));
        let name = Cell::Name { name: info.name.clone(), about: about.collect(), series: None };
        let passes = view.passes.iter().map(|pass| match pass.counters.get(&info.name).copied().flatten() {
            Some(figure) => Cell::counter(&of_pass(value, figure), unit),
            None => Cell::Absent("the pass does not have it".to_owned()),
        });
        Some([name, Cell::counter(value, unit)].into_iter().chain(passes).collect())
    };
    let group = |title: &str| Group {
        title: Some(title.to_owned()),
        rows: profiler.counters.iter().filter(|info| info.group == title).filter_map(row).collect(),
    };
    let groups = profiler.groups().into_iter().map(group).filter(|group| !group.rows.is_empty());
    let table = Table {
        label: format!("Counters as {} names them", profiler.name),
        columns: columns(report, false),
        groups: groups.collect(),
        filter: true,
    };
    format!("<h3>As {} names them</h3>\n{table}", Escaped(&profiler.name))
}

/// A count of the frame is one of its passes too.
fn of_pass(of_frame: &Value, figure: f64) -> Value {
    match of_frame {
        Value::Count(_) if figure.fract() == 0.0 => Value::Count(figure as u64),
        _ => Value::Real(figure),
    }
}
