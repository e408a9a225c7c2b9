//! The model beside what was published, as bars.

use super::file::Kind;
use super::verdict::RowVerdict;
use crate::chart::{BarChart, Scale, Series};

/// Charts by what the rows measure, with names for their files; `judge` is the rung whose figures the verdicts hold.
pub fn charts(verdicts: &[RowVerdict], judge: &str) -> Vec<(&'static str, BarChart)> {
    let all: [(&str, &str, &str, &[Kind], &str); 4] = [
        ("latency", "Latency", "time of a load (ns)", &[Kind::Latency], "ns"),
        ("bandwidth", "Bandwidth", "bytes per second (GB/s)", &[Kind::Bandwidth], "GB/s"),
        ("power", "Power", "power of one supply of the memory (mW)", &[Kind::Power], "mW"),
        (
            "slowdown",
            "Slowdown",
            "time over the simpler pattern's",
            &[Kind::Bandwidth, Kind::Ratio, Kind::Divergence],
            "x",
        ),
    ];
    let chart = |title: &str, label: &str, kinds: &[Kind], unit: &str| {
        let rows: Vec<&RowVerdict> = verdicts
            .iter()
            .filter(|verdict| kinds.contains(&verdict.kind) && verdict.ours.text.ends_with(unit))
            .filter(|verdict| verdict.ours.value > 0.0)
            .collect();
        let others = rows.first().map_or(0, |row| row.others.len());
        let mut series = vec![
            Series {
                name: "published".to_owned(),
                values: rows.iter().map(|row| Some(row.published.as_ref()?.value)).collect(),
            },
            Series {
                name: format!("model, {judge}"),
                values: rows.iter().map(|row| Some(row.ours.value)).collect(),
            },
        ];
        for other in 0..others {
            series.push(Series {
                name: format!("model, {}", rows[0].others[other].0),
                values: rows.iter().map(|row| Some(row.others.get(other)?.1.value)).collect(),
            });
        }
        let star = |row: &RowVerdict| if row.inputs.is_empty() { "" } else { " *" };
        BarChart {
            title: format!("{title}: published measurements and the model"),
            subtitle: "Rows with a star are inputs of their preset.".to_owned(),
            value_label: label.to_owned(),
            groups: rows.iter().map(|row| format!("{}{}", row.id, star(row))).collect(),
            series,
            scale: Scale::Log,
        }
    };
    let drawn =
        all.into_iter().map(|(stem, title, label, kinds, unit)| (stem, chart(title, label, kinds, unit)));
    drawn.filter(|(_, chart)| !chart.groups.is_empty()).collect()
}
