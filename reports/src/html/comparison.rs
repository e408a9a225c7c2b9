//! A comparison as a page.

use super::markup::{Cell, Column, Escaped, Group, Table, sentences};
use super::{Chart, chart, page};
use crate::comparison::{AttributedPart, Attribution, Comparison, Variant, ratio};
use crate::counters::Value;
use gpumodel::{COUNTERS, CounterInfo};

/// Variants whose counters stand side by side; the CSV has those of any number.
const MOST_BESIDE: usize = 12;

/// The page, with charts below the tables.
pub fn comparison(comparison: &Comparison, charts: &[Chart]) -> String {
    let sections = [
        ("figures", "Figures", figures(comparison)),
        ("attribution", "What the differences are made of", attribution(comparison)),
        ("counters", "Counters", counters(comparison)),
        ("charts", "Charts", charts.iter().map(chart).collect()),
        ("errors", "Remarks, errors, absent figures", honesty(comparison)),
    ];
    let facts = [
        format!("{} variants", comparison.variants.len()),
        format!("by {}", comparison.axes.join(", ")),
        "differences are from the first".to_owned(),
    ];
    let facts: String = facts.iter().map(|fact| format!("<li>{}</li>", Escaped(fact))).collect();
    let title = Escaped(&comparison.title);
    let heading = format!("<header><h1>{title}</h1>\n<ul class=\"facts\">{facts}</ul></header>\n");
    page(&comparison.title, &heading, &sections)
}

fn honesty(comparison: &Comparison) -> String {
    let list = |title: &str, all: &[String]| sentences(title, all.iter().map(String::as_str));
    list("Remarks", &comparison.remarks)
        + &list("How far the figures may be off", &comparison.errors())
        + &list("Absent", &comparison.absences())
}

/// One row for each variant.
fn figures(comparison: &Comparison) -> String {
    let known: Vec<(&CounterInfo, &str)> = comparison
        .shown()
        .filter_map(|(id, heading)| Some((COUNTERS.iter().find(|info| info.id == id)?, heading)))
        .filter(|(info, _)| comparison.variants.iter().any(|variant| number(variant, info.id).is_some()))
        .collect();
    let axes = comparison.axes.iter().map(|axis| Column::words(axis));
    let figures = known.iter().flat_map(|(_, heading)| [Column::figures(heading), Column::figures("%")]);
    let row = |variant: &Variant| {
        let places = (0..comparison.axes.len())
            .map(|axis| Cell::Words(variant.values.get(axis).cloned().unwrap_or_default()));
        let figures = known
            .iter()
            .flat_map(|(info, _)| [figure(variant, info.id), change(comparison, variant, info.id)]);
        let bound = variant.report.deciding_bound.clone().unwrap_or_default();
        places.chain(figures).chain([Cell::Words(bound)]).collect()
    };
    let table = Table {
        label: "Figures".to_owned(),
        columns: axes.chain(figures).chain([Column::words("Deciding Bound")]).collect(),
        groups: vec![Group { title: None, rows: comparison.variants.iter().map(row).collect() }],
        filter: comparison.variants.len() > 8,
    };
    table.to_string()
}

/// The parts of each variant's differences.
fn attribution(comparison: &Comparison) -> String {
    let group = |variant: &Variant| {
        let made = comparison.attributions(variant);
        let rows = made.iter().flat_map(|made| made.parts.iter().filter_map(|part| part_row(made, part)));
        let rows: Vec<Vec<Cell>> = rows.collect();
        (!rows.is_empty()).then(|| Group { title: Some(comparison.name(variant)), rows })
    };
    let groups: Vec<Group> = comparison.variants.iter().skip(1).filter_map(group).collect();
    if groups.is_empty() {
        return String::new();
    }
    let figures = ["first", "here", "change, %", "points of the total"].map(Column::figures);
    let table = Table {
        label: "What the differences are made of".to_owned(),
        columns: ["part", "of"].map(Column::words).into_iter().chain(figures).collect(),
        groups,
        filter: true,
    };
    table.to_string()
}

/// Of a part that changed.
fn part_row(made: &Attribution, part: &AttributedPart) -> Option<Vec<Cell>> {
    let points = made.points(part).filter(|points| *points != 0.0)?;
    let shown = |figure: f64| Cell::counter(&Value::Real(figure), made.unit);
    let change = ratio(Some(part.after), Some(part.before));
    Some(vec![
        Cell::Words(part.name.clone()),
        Cell::Words(made.what.to_owned()),
        shown(part.before),
        shown(part.after),
        change
            .map_or_else(|| Cell::Absent("the first has none".to_owned()), |ratio| signed(ratio - 1.0, None)),
        signed(points / 100.0, None),
    ])
}

/// All counters of the frame, variants side by side.
fn counters(comparison: &Comparison) -> String {
    let variants = &comparison.variants;
    if variants.len() > MOST_BESIDE {
        return format!("<p>Those of {} variants are in comparison.csv.</p>\n", variants.len());
    }
    let mut groups: Vec<Group> = Vec::new();
    for info in
        COUNTERS.iter().filter(|info| variants.iter().any(|variant| number(variant, info.id).is_some()))
    {
        let cells = variants.iter().enumerate().flat_map(|(index, variant)| {
            let change = (index > 0).then(|| change(comparison, variant, info.id));
            std::iter::once(figure(variant, info.id)).chain(change)
        });
        let row = std::iter::once(Cell::counter_name(info)).chain(cells).collect();
        Group::add(&mut groups, info.group, row);
    }
    let heads = variants.iter().enumerate().flat_map(|(index, variant)| {
        let change = (index > 0).then(|| Column::figures("%"));
        std::iter::once(Column::figures(&comparison.name(variant))).chain(change)
    });
    let columns = std::iter::once(Column::words("counter")).chain(heads).collect();
    Table { label: "Counters".to_owned(), columns, groups, filter: true }.to_string()
}

fn number(variant: &Variant, id: &str) -> Option<f64> {
    variant.report.counters.get(id)?.value.as_f64()
}

fn figure(variant: &Variant, id: &str) -> Cell {
    match variant.report.counters.get(id) {
        Some(counter) => Cell::counter(&counter.value, &counter.unit),
        None => Cell::Absent("the report has no such counter".to_owned()),
    }
}

/// The difference from the first variant in percent.
fn change(comparison: &Comparison, variant: &Variant, id: &str) -> Cell {
    let first = comparison.variants.first().and_then(|first| number(first, id));
    match ratio(number(variant, id), first) {
        Some(ratio) => signed(ratio - 1.0, variant.reach(id, ratio)),
        None => Cell::Absent("there is nothing to compare with".to_owned()),
    }
}

/// A difference in percent, as a part of 1, and how far it may be off.
fn signed(part: f64, reach: Option<f64>) -> Cell {
    let value = 100.0 * part;
    let (mut shown, mut exact) = (format!("{value:+.1}"), format!("{value} %"));
    if let Some(points) = reach.filter(|reach| *reach > 0.0).map(|reach| 100.0 * reach) {
        shown += &format!(" \u{b1}{points:.1}");
        exact += &format!(" \u{b1} {points}");
    }
    Cell::Figure { shown, unit: None, value, exact }
}
