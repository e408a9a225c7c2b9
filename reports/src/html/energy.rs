//! What the frame's energy is made of.

use super::markup::{Cell, Column, Escaped, Group, Table, bar};
use crate::report::{Energy, EnergyCause};
use crate::units;

pub(super) fn write(energy: Option<&Energy>) -> String {
    let Some(Energy { process, volts, volts_from, celsius, causes }) = energy else { return String::new() };
    let mut causes: Vec<&EnergyCause> = causes.iter().collect();
    causes.sort_by(|a, b| b.mj.total_cmp(&a.mj));
    let part = |(series, cause): (usize, &&EnergyCause)| {
        let EnergyCause { cause, mj, share, .. } = cause;
        (series, format!("{cause}: {} mJ, {:.1} %", units::digits(*mj), 100.0 * share), *share)
    };
    let bar = bar(
        "Parts of the frame's energy, as in the table below",
        &causes.iter().enumerate().map(part).collect::<Vec<_>>(),
    );
    let row = |(series, cause): (usize, &&EnergyCause)| {
        let EnergyCause { cause, mj, share, domain, boundary, tag } = cause;
        let figures = [Cell::name(cause, series), Cell::number(*mj), Cell::per_cent(*share)];
        figures.into_iter().chain([domain, boundary, tag].map(|word| Cell::Words(word.clone()))).collect()
    };
    let words = ["domain", "boundary", "figure"].map(Column::words);
    let table = Table {
        label: "Causes of the frame's energy".to_owned(),
        columns: [Column::words("cause"), Column::figures("mJ"), Column::figures("%")]
            .into_iter()
            .chain(words)
            .collect(),
        groups: vec![Group { title: None, rows: causes.iter().enumerate().map(row).collect() }],
        filter: false,
    };
    let process = Escaped(process);
    let origin = Escaped(volts_from);
    format!("<p>{process}, {volts:.3} V of its {origin}, {celsius} degrees Celsius.</p>\n{bar}{table}")
}
