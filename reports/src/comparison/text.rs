//! The comparison as tables for a terminal: one row for each variant; columns that do not fit into a line go into a
//! further table. Below stands why figures are absent.

use super::Comparison;
use super::figures::{BOUND, COLUMNS};
use crate::text::{LINE_WIDTH, Style, sentences};

/// Space between columns.
const GAP: usize = 2;

/// Cells of one width, headings first.
struct Column {
    width: usize,
    cells: Vec<String>,
}

impl Column {
    fn new(cells: Vec<String>, left: bool) -> Self {
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        let pad = |cell: String| if left { format!("{cell:<width$}") } else { format!("{cell:>width$}") };
        Self { width, cells: cells.into_iter().map(pad).collect() }
    }
}

/// The whole comparison as text with a final line feed.
pub fn write(comparison: &Comparison, style: Style) -> String {
    let named = |name: &str, cells: &mut dyn Iterator<Item = String>| {
        Column::new([name.to_owned(), String::new()].into_iter().chain(cells).collect(), true)
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
        for row in 0..variants.len() + 2 {
            let cells: Vec<&str> =
                axes.iter().chain(table).map(|column| column.cells[row].as_str()).collect();
            let line = cells.join(&" ".repeat(GAP));
            let line = line.trim_end();
            out += &if row < 2 && !line.is_empty() { style.bold(line) } else { line.to_owned() };
            out.push('\n');
        }
    }
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
    Some(Column::new(heads.into_iter().chain(figures.rows.iter().map(cell)).collect(), false))
}
