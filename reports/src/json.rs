//! The JSON form, schema 1. Its JSON Schema is published as [`SCHEMA_TEXT`].

use crate::error::Error;
use crate::report::{Report, SCHEMA};
use serde::Deserialize;

/// The JSON Schema (draft 2020-12) of a report.
pub const SCHEMA_TEXT: &str = include_str!("../schema/report-1.schema.json");

/// The report as indented JSON with a final line feed.
pub fn write(report: &Report) -> String {
    let mut text = serde_json::to_string_pretty(report).expect("a report has string keys and finite numbers");
    text.push('\n');
    text
}

/// Reads a report that [`write()`] wrote; `file` names it in errors. Fields of later versions of schema 1 are passed over.
///
/// # Errors
/// When the text is not JSON, of another schema, or not complete.
pub fn read(text: &str, file: &str) -> Result<Report, Error> {
    #[derive(Deserialize)]
    struct Version {
        schema: u32,
    }
    const REMEDY: &str = "give a report as written by `raybudget profile --format json`";
    let refuse = |error: serde_json::Error| {
        let what = error.to_string();
        let what = what.rsplit_once(" at line ").map_or(what.as_str(), |(what, _)| what);
        match error.line() {
            0 => Error::new(file, format!("not a report: {what}"), REMEDY),
            line => Error::at_line(file, line, format!("not a report: {what}"), REMEDY),
        }
    };
    let Version { schema } = serde_json::from_str(text).map_err(refuse)?;
    if schema != SCHEMA {
        return Err(Error::new(
            file,
            format!("a report of schema {schema}, expected {SCHEMA}"),
            "profile again with this version",
        ));
    }
    serde_json::from_str(text).map_err(refuse)
}
