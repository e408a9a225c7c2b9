//! Reports that differ along named axes, side by side: which traversal, which layout, which GPU.
//!
//! [`text`] is for the terminal, [`markdown`] for documents, [`html::comparison`](crate::html::comparison) for a browser, [`csv_table`] and
//! [`json`] for programs, and [`Comparison::charts`] for eyes. Differences are relative to the first variant;
//! [`Comparison::attributions`] says of what they are made. The table of values beside a chart is the
//! CSV.

mod attribution;
mod charts;
pub mod csv_table;
mod figures;
pub mod json;
pub mod markdown;
pub mod text;

use crate::report::{Inputs, Report};
use crate::within::Within;
use std::collections::BTreeMap;

pub use attribution::{AttributedPart, Attribution};
pub(crate) use figures::ratio;

/// Reports and what distinguishes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub title: String,
    /// Names of what varies, such as "scene", "traversal", "layout".
    pub axes: Vec<String>,
    /// The variants; the others are told relative to the first.
    pub variants: Vec<Variant>,
    /// What else is to be said, in sentences.
    pub remarks: Vec<String>,
}

/// One of the reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its place on each of the axes, in their order. A missing one is shown empty, and one too many is not shown.
    pub values: Vec<String>,
    /// Its report.
    pub report: Report,
    /// Where both are samples of the same tiles, how many times as large its counters are as the first's: the ends of intervals of 95 %, by
    /// counter. They are far narrower than those of the counters, as chance does the same to both.
    pub ratios_ci95: BTreeMap<String, [f64; 2]>,
}

/// Inputs in words, without hashes.
fn told(inputs: &Inputs) -> Vec<(String, String)> {
    let Ok(serde_json::Value::Object(fields)) = serde_json::to_value(inputs) else {
        unreachable!("inputs are a struct of plain fields");
    };
    let word = |value: serde_json::Value| match value {
        serde_json::Value::String(text) => text,
        serde_json::Value::Array(values) => values
            .iter()
            .map(|value| value.to_string().trim_matches('"').to_owned())
            .collect::<Vec<_>>()
            .join(" "),
        serde_json::Value::Null => String::new(),
        other => other.to_string(),
    };
    fields.into_iter().filter(|(key, _)| key != "hashes").map(|(key, value)| (key, word(value))).collect()
}

impl Variant {
    /// Its place on an axis.
    fn value(&self, axis: usize) -> &str {
        self.values.get(axis).map_or("", String::as_str)
    }
}

impl Comparison {
    /// Of finished reports, each with a name: beside it stand the inputs in which they differ.
    pub fn of_reports(reports: Vec<(String, Report)>) -> Self {
        let inputs: Vec<Vec<(String, String)>> =
            reports.iter().map(|(_, report)| told(&report.inputs)).collect();
        let mut keys: Vec<&String> = Vec::new();
        for (key, _) in inputs.iter().flatten() {
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        let value = |inputs: &[(String, String)], key: &str| {
            inputs.iter().find(|(known, _)| known == key).map(|(_, value)| value.clone()).unwrap_or_default()
        };
        let differs = |key: &&String| inputs.iter().any(|each| value(each, key) != value(&inputs[0], key));
        keys.retain(|key| differs(key));
        let keys: Vec<String> = keys.into_iter().cloned().collect();
        let variant = |((name, report), inputs): ((String, Report), &Vec<(String, String)>)| {
            let values = keys.iter().map(|key| value(inputs, key));
            let values = std::iter::once(name).chain(values).collect();
            Variant { values, report, ratios_ci95: BTreeMap::new() }
        };
        Self {
            title: format!("{} reports", reports.len()),
            axes: std::iter::once("report".to_owned())
                .chain(keys.iter().map(|key| key.replace('_', "-")))
                .collect(),
            variants: reports.into_iter().zip(&inputs).map(variant).collect(),
            remarks: Vec::new(),
        }
    }

    /// Ids and headings of the counters that tables show.
    pub(crate) fn shown(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        figures::COLUMNS.iter().map(|column| (column.id, column.heading))
    }

    /// How far the figures may be off, in sentences.
    pub(crate) fn errors(&self) -> Vec<String> {
        let sampled = self.variants.iter().any(|variant| !variant.ratios_ci95.is_empty());
        let of_changes = sampled.then(|| {
            "Differences from the first are known as far as stands behind \u{b1}, in points: intervals of 95 %, narrower than those of the \
             figures, as the frames are sampled by the same tiles."
                .to_owned()
        });
        let within =
            Within::told(self.variants.iter().filter_map(|variant| variant.report.run.within.as_ref()));
        within.into_iter().chain(of_changes).collect()
    }

    /// The place of a variant on all axes, in words.
    pub(crate) fn name(&self, variant: &Variant) -> String {
        (0..self.axes.len()).map(|axis| variant.value(axis)).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(gpu: &str, layout: &str) -> Report {
        let text = format!(
            r#"{{"schema": 1, "tool": "raybudget 0.1.0", "left_out": [],
                "inputs": {{"scene": "s", "gpu": "{gpu}", "accel": "bvh", "traversal": "stack", "layout": "{layout}",
                    "technique": "fragment", "width": 1, "height": 1, "seed": null,
                    "hashes": {{"scene": "0", "gpu": "{gpu}", "costs": "0"}}, "triangles": 1, "ray_sets": ["primary", "shadow"],
                    "sah_costs": [3.0, 1.5], "short_stack": 0, "trail_bits": null}},
                "run": {{"wall_s": 0.0, "peak_rss_bytes": null, "fidelity": "replay", "sampled_fraction": 1.0, "threads": 1}},
                "counters": {{}}, "passes": []}}"#
        );
        crate::json::read(&text, "made").expect("a report")
    }

    #[test]
    fn beside_the_names_of_reports_stand_the_inputs_in_which_they_differ() {
        let named = |name: &str, gpu, layout| (name.to_owned(), report(gpu, layout));
        let two = Comparison::of_reports(vec![named("main", "a", "padded"), named("branch", "b", "split")]);
        assert_eq!(two.axes, ["report", "gpu", "layout"]);
        assert_eq!(two.variants[1].values, ["branch", "b", "split"]);
        let same = Comparison::of_reports(vec![named("main", "a", "padded"), named("branch", "a", "padded")]);
        assert_eq!(same.axes, ["report"]);
    }
}
