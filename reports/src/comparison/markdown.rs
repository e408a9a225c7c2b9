//! The comparison as a Markdown table: one row for each variant, differences in parentheses. Below stands why figures are
//! absent.

use super::Comparison;
use super::figures::{BOUND, COLUMNS, Figures};

/// The comparison as Markdown with a final line feed.
pub fn write(comparison: &Comparison) -> String {
    let columns: Vec<(&str, Figures)> =
        COLUMNS.iter().filter_map(|column| Some((column.heading, comparison.figures(column.id)?))).collect();
    let heads = columns.iter().map(|(heading, figures)| match figures.unit {
        "" => (*heading).to_owned(),
        unit => format!("{heading} ({unit})"),
    });
    let axes = comparison.axes.iter().map(|axis| escaped(axis));
    let heads: Vec<String> = axes.chain(heads).chain([BOUND.to_owned()]).collect();
    let rules = (0..heads.len()).map(|column| {
        let right = (comparison.axes.len()..heads.len() - 1).contains(&column);
        if right { "---:" } else { "---" }.to_owned()
    });
    let mut out =
        format!("## {}\n\n{}{}", escaped(&comparison.title), line(&heads), line(&rules.collect::<Vec<_>>()));
    for (index, variant) in comparison.variants.iter().enumerate() {
        let axes = (0..comparison.axes.len()).map(|axis| escaped(variant.value(axis)));
        let figures = columns.iter().map(|(_, figures)| match &figures.rows[index] {
            [figure, difference] if difference.is_empty() => figure.clone(),
            [figure, difference] => format!("{figure} ({difference})"),
        });
        out += &line(&axes.chain(figures).chain([escaped(variant.deciding_bound())]).collect::<Vec<_>>());
    }
    list(
        &mut out,
        "What the differences from the first are made of; in brackets, percent of its total",
        &comparison.attributed(),
    );
    list(&mut out, "Remarks", &comparison.remarks);
    list(&mut out, "How far the figures may be off", &comparison.errors());
    list(&mut out, "Absent", &comparison.absences());
    out
}

fn list(out: &mut String, title: &str, sentences: &[String]) {
    if !sentences.is_empty() {
        *out += &format!("\n{title}:\n\n");
        sentences.iter().for_each(|sentence| *out += &format!("- {}\n", escaped(sentence)));
    }
}

fn line(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// Text that ends no cell and opens no tag.
pub(crate) fn escaped(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    text.replace('\\', "\\\\").replace('|', "\\|").replace('<', "&lt;")
}
