//! Tables of aligned columns for a terminal.

use crate::text::Style;

/// Space between columns.
pub(crate) const GAP: usize = 2;

/// Cells of one width, headings first.
pub(crate) struct Column {
    pub(crate) width: usize,
    cells: Vec<String>,
}

impl Column {
    /// Cells that end at the right.
    pub(crate) fn figures(cells: Vec<String>) -> Self {
        Self::padded(cells, |cell, width| format!("{cell:>width$}"))
    }

    /// Cells that begin at the left.
    pub(crate) fn words(cells: Vec<String>) -> Self {
        Self::padded(cells, |cell, width| format!("{cell:<width$}"))
    }

    fn padded(cells: Vec<String>, pad: impl Fn(&str, usize) -> String) -> Self {
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        Self { width, cells: cells.into_iter().map(|cell| pad(&cell, width)).collect() }
    }
}

/// Columns side by side, all as long; the first `headings` rows stand out.
pub(crate) fn write_rows(out: &mut String, columns: &[&Column], headings: usize, style: Style) {
    for row in 0..columns.first().map_or(0, |column| column.cells.len()) {
        let cells: Vec<&str> = columns.iter().map(|column| column.cells[row].as_str()).collect();
        let line = cells.join(&" ".repeat(GAP));
        let line = line.trim_end();
        *out += &if row < headings && !line.is_empty() { style.bold(line) } else { line.to_owned() };
        out.push('\n');
    }
}
