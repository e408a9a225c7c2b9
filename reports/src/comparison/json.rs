//! The comparison as JSON, schema 1: each variant with its whole report. Its JSON Schema is published as [`SCHEMA_TEXT`].

use super::{Attribution, Comparison};
use crate::report::Report;
use serde::Serialize;
use std::collections::BTreeMap;

/// Version of the JSON form. It changes when a field changes its meaning or goes; new fields keep it.
pub const SCHEMA: u32 = 1;

/// The JSON Schema (draft 2020-12) of a comparison. It refers to that of a report as `report-1.schema.json`.
pub const SCHEMA_TEXT: &str = include_str!("../../schema/comparison-1.schema.json");

#[derive(Serialize)]
struct Raw<'a> {
    schema: u32,
    /// Program and version of the first report; null without one.
    tool: Option<&'a str>,
    title: &'a str,
    axes: &'a [String],
    remarks: &'a [String],
    variants: Vec<RawVariant<'a>>,
}

#[derive(Serialize)]
struct RawVariant<'a> {
    values: Vec<&'a str>,
    /// Of what the differences from the first variant are made.
    attributions: Vec<Attribution>,
    /// As [`Variant::ratios_ci95`](super::Variant::ratios_ci95); absent without.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    ratios_ci95: &'a BTreeMap<String, [f64; 2]>,
    report: &'a Report,
}

/// The comparison as indented JSON with a final line feed.
pub fn write(comparison: &Comparison) -> String {
    let Comparison { title, axes, variants, remarks } = comparison;
    let raw = Raw {
        schema: SCHEMA,
        tool: variants.first().map(|variant| variant.report.tool.as_str()),
        title,
        axes,
        remarks,
        variants: variants
            .iter()
            .map(|variant| RawVariant {
                values: (0..axes.len()).map(|axis| variant.value(axis)).collect(),
                attributions: comparison.attributions(variant),
                ratios_ci95: &variant.ratios_ci95,
                report: &variant.report,
            })
            .collect(),
    };
    let mut text = serde_json::to_string_pretty(&raw).expect("a report has string keys and finite numbers");
    text.push('\n');
    text
}
