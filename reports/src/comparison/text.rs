//! The comparison as tables for a terminal: one row for each variant; columns that do not fit into a line go into a
//! further table. Below stands of what differences are made, and why figures are absent.

use super::Comparison;
use super::figures::{BOUND, COLUMNS};
use crate::columns::{Column, GAP, write_rows};
use crate::text::{LINE_WIDTH, Style, sentences};

/// Sentences that tell of what differences are made.
const MOST_ATTRIBUTED: usize = 60;

/// The whole comparison as text with a final line feed.
pub fn write(comparison: &Comparison, style: Style) -> String {
    let named = |name: &str, cells: &mut dyn Iterator<Item = String>| {
        Column::words([name.to_owned(), String::new()].into_iter().chain(cells).collect())
    };
    let variants = &comparison.variants;
    let axis = |(axis, name): (usize, &String)| {
        named(name, &mut variants.iter().map(|variant| variant.value(axis).to_owned()))
    };
    let axes: Vec<Column> = comparison.axes.iter().enumerate().map(axis).collect();
    let figures = COLUMNS.iter().filter_map(|column| figure_column(comparison, column.id, column.heading));
    let bounds = named(BOUND, &mut variants.iter().map(|variant| variant.deciding_bound().to_owned()));

    let indent: usize = axes.iter().map(|column| column.width + GAP).sum();
    let mut tables: Vec<Vec<Column>> = Vec::new();
    let mut room = 0;
    for column in figures.chain([bounds]) {
        match tables.last_mut() {
            Some(table) if column.width <= room => {
                room = room.saturating_sub(column.width + GAP);
                table.push(column);
            }
            _ => {
                room = LINE_WIDTH.saturating_sub(indent + column.width + GAP);
                tables.push(vec![column]);
            }
        }
    }
    let mut out = format!("{}\n", style.bold(&comparison.title));
    for table in &tables {
        out.push('\n');
        write_rows(&mut out, &axes.iter().chain(table).collect::<Vec<_>>(), 2, style);
    }
    let mut attributed = comparison.attributed();
    if attributed.len() > MOST_ATTRIBUTED {
        attributed = vec!["JSON and HTML say it of each variant; these are too many.".to_owned()];
    }
    let title = "What the differences from the first are made of; in brackets, percent of its total";
    sentences(&mut out, title, &attributed, style);
    sentences(&mut out, "Remarks", &comparison.remarks, style);
    sentences(&mut out, "How far the figures may be off", &comparison.errors(), style);
    sentences(&mut out, "Absent", &comparison.absences(), style);
    out
}

/// Heading, unit, and the figures with their differences, aligned.
fn figure_column(comparison: &Comparison, id: &str, heading: &str) -> Option<Column> {
    let figures = comparison.figures(id)?;
    let width = |part: usize| figures.rows.iter().map(|row| row[part].chars().count()).max().unwrap_or(0);
    let widths = [width(0), width(1)];
    let cell = |[figure, difference]: &[String; 2]| match widths[1] {
        0 => format!("{figure:>width$}", width = widths[0]),
        _ => format!("{figure:>0$} {difference:>1$}", widths[0], widths[1]),
    };
    let heads = [heading.to_owned(), figures.unit.to_owned()];
    Some(Column::figures(heads.into_iter().chain(figures.rows.iter().map(cell)).collect()))
}
