//! The cases of the stability suite as text, Markdown, JSON and CSV.

use crate::text::Style;
use crate::units;
use serde_json::{Value, json};
use stability::{Case, Condition, Limit};
use std::fmt::Write;

macro_rules! line {
    ($out:expr) => { $out.push('\n') };
    ($out:expr, $($args:tt)*) => { writeln!($out, $($args)*).expect("a string takes every write") };
}

/// The columns of the CSV; `limit` is the largest value that `found` may have, or the smallest where `bound` is `at_least`.
pub const COLUMNS: [&str; 12] = [
    "id",
    "outcome",
    "found",
    "unit",
    "bound",
    "limit",
    "beyond",
    "condition",
    "condition_of",
    "residual",
    "statement",
    "why",
];

fn outcome(case: &Case) -> &'static str {
    if case.passes() { "pass" } else { "fail" }
}

/// As text: `outcome`, failures in capitals.
fn verb(case: &Case) -> &'static str {
    if case.passes() { "pass" } else { "FAIL" }
}

fn expected(case: &Case) -> String {
    match case.limit {
        Limit::AtMost(0.0) => "0".to_owned(),
        Limit::AtMost(limit) => format!("<= {}", units::short(limit)),
        Limit::AtLeast(limit) => format!(">= {}", units::short(limit)),
    }
}

fn small(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1e}"))
}

/// How many of the cases keep their limits.
fn summary(cases: &[Case]) -> String {
    let passed = cases.iter().filter(|case| case.passes()).count();
    format!("{passed} of {} cases keep their limits", cases.len())
}

/// A table of the cases, then what each states.
pub fn text(cases: &[Case], style: Style) -> String {
    let mut out = String::new();
    let width = cases.iter().map(|case| case.id.len()).max().unwrap_or(4);
    let heading = format!(
        "{:<width$}  {:>10}  {:>10}  {:>10}  {:>9}  {:>8}",
        "case", "expected", "found", "apart", "condition", "residual"
    );
    line!(out, "{}", style.bold(&heading));
    for case in cases {
        line!(
            out,
            "{:<width$}  {:>10}  {:>10}  {:>10}  {:>9}  {:>8}  {}",
            case.id,
            expected(case),
            units::short(case.found),
            units::short(case.beyond()),
            small(case.condition.map(|condition| condition.value)),
            small(case.residual),
            verb(case)
        );
    }
    line!(out);
    line!(out, "{}", style.bold("Cases"));
    for case in cases {
        line!(out, "{} ({}): {}", case.id, case.unit, case.statement);
        if let Some(Condition { what, .. }) = case.condition {
            line!(out, "    condition: {what}");
        }
        if !case.why.is_empty() {
            line!(out, "    {}", case.why);
        }
    }
    line!(out);
    line!(out, "{}", summary(cases));
    out
}

/// The table as Markdown, under a title.
pub fn markdown(title: &str, cases: &[Case]) -> String {
    let mut out = String::new();
    let cell = |text: &str| text.replace('|', "\\|");
    line!(out, "## {title}");
    line!(out);
    line!(
        out,
        "| case | statement | unit | expected | found | apart | condition | residual | limit | remarks |"
    );
    line!(out, "|---|---|---|---|---|---|---|---|---|---|");
    for case in cases {
        let condition =
            case.condition.map_or(String::new(), |Condition { what, value }| format!("{what}: {value:.1e}"));
        line!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            case.id,
            cell(&case.statement),
            case.unit,
            expected(case),
            units::short(case.found),
            units::short(case.beyond()),
            cell(&condition),
            small(case.residual),
            verb(case),
            cell(&case.why)
        );
    }
    line!(out);
    line!(out, "{}.", summary(cases));
    out
}

/// `run` is what the caller knows of the run. `ours` is what came out and `published` null: the limits are the project's own, or those of
/// theory. `error` is how far `ours` is beyond its limit, in the same unit; at most 0 where the case passes.
pub fn json_text(cases: &[Case], run: &Value) -> String {
    let row = |case: &Case| {
        let (bound, limit) = bound(case.limit);
        json!({
            "id": case.id,
            "statement": case.statement,
            "outcome": outcome(case),
            "ours": case.found,
            "published": null,
            "unit": case.unit,
            "expected": { bound: limit },
            "error": case.beyond(),
            "condition": case.condition.map(|Condition { what, value }| json!({ "what": what, "value": value })),
            "residual": case.residual,
            "why": case.why,
        })
    };
    let rows: Vec<Value> = cases.iter().map(row).collect();
    format!("{:#}\n", json!({ "rows": rows, "run": run }))
}

fn bound(limit: Limit) -> (&'static str, f64) {
    match limit {
        Limit::AtMost(limit) => ("at_most", limit),
        Limit::AtLeast(limit) => ("at_least", limit),
    }
}

/// One row for each case, with a heading.
pub fn csv_text(cases: &[Case]) -> String {
    let mut table = csv::Writer::from_writer(Vec::new());
    let rows = cases.iter().map(|case| {
        let (bound, limit) = bound(case.limit);
        let (condition, of) = case
            .condition
            .map_or_else(Default::default, |Condition { what, value }| (value.to_string(), what.to_owned()));
        [
            case.id.clone(),
            outcome(case).to_owned(),
            case.found.to_string(),
            case.unit.to_owned(),
            bound.to_owned(),
            limit.to_string(),
            case.beyond().to_string(),
            condition,
            of,
            case.residual.map_or(String::new(), |residual| residual.to_string()),
            case.statement.clone(),
            case.why.clone(),
        ]
    });
    for row in std::iter::once(COLUMNS.map(str::to_owned)).chain(rows) {
        table.write_record(row).expect("memory takes every record, and all have as many columns");
    }
    let bytes = table.into_inner().expect("memory takes every byte");
    String::from_utf8(bytes).expect("made of strings")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cases() -> [Case; 3] {
        [
            Case::none_of("a/lost", "nothing is lost", "rays", 0),
            Case::new("b/reach", "far enough", "exponent of 2", Limit::AtLeast(15.0), 12.0)
                .under("distance", 4096.0)
                .because("a|b"),
            Case::new("c/error", "near enough", "relative error", Limit::AtMost(1e-12), 3e-13)
                .with_residual(2e-16),
        ]
    }

    #[test]
    fn every_form_tells_what_was_expected_what_came_out_and_how_far_apart() {
        let plain = text(&cases(), Style::Plain);
        assert!(plain.contains("2 of 3 cases keep their limits"), "{plain}");
        let row = |id: &str| plain.lines().find(|line| line.starts_with(id)).unwrap_or_default().to_owned();
        assert!(row("b/reach").ends_with("FAIL") && row("b/reach").contains(">= 15"), "{plain}");
        assert!(row("c/error").ends_with("pass") && row("c/error").contains("2.0e-16"), "{plain}");
        assert!(markdown("Cases", &cases()).contains("a\\|b"));
        let json: Value =
            serde_json::from_str(&json_text(&cases(), &json!({ "quick": true }))).expect("JSON");
        let fail = &json["rows"][1];
        assert_eq!((&fail["outcome"], &fail["error"]), (&json!("fail"), &json!(3.0)));
        assert_eq!(fail["expected"]["at_least"], json!(15.0));
        assert_eq!(json["rows"][2]["residual"], json!(2e-16));
        let csv = csv_text(&cases());
        assert_eq!(csv.lines().count(), 4);
        assert!(csv.lines().nth(2).is_some_and(|row| row.starts_with("b/reach,fail,12,")), "{csv}");
    }
}
