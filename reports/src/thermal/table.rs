//! Errors of the integrators as tables.

use crate::text::Style;
use serde_json::{Value, json};
use stability::{Thermal, WorkPoint};
use std::fmt::Write;
use thermal::{Method, Steps};

const COLUMNS: [&str; 6] = ["method", "steps_by", "value", "error_k", "seconds", "steps"];

/// What decides the steps, and how much of it, in K or seconds.
fn steps(point: &WorkPoint) -> (&'static str, f64) {
    match point.steps {
        Steps::Tolerance(kelvin) => ("tolerance", kelvin),
        Steps::Fixed(seconds) => ("length", seconds),
    }
}

/// A line for each point.
pub fn text(thermal: &Thermal, style: Style) -> String {
    let mut out = style.bold(&format!("Error against run time: {}", thermal.problem));
    let heading = format!(
        "{:<12} {:<10} {:>8} {:>10} {:>10} {:>9}",
        "method", "steps by", "K or s", "error, K", "ms", "steps"
    );
    writeln!(out, "\n{}", style.bold(&heading)).expect("a string takes every write");
    for point in &thermal.points {
        let (by, value) = steps(point);
        let error = point.error.map_or_else(|| "unstable".to_owned(), |error| format!("{error:.1e}"));
        let ms = 1e3 * point.seconds;
        writeln!(
            out,
            "{:<12} {by:<10} {value:>8.0e} {error:>10} {ms:>10.3} {:>9}",
            point.method.name(),
            point.taken
        )
        .expect("a string takes every write");
    }
    writeln!(out, "{}", fastest(thermal)).expect("a string takes every write");
    out
}

/// The methods by the least time for an error, which depends on how busy the machine is and so decides nothing.
fn fastest(thermal: &Thermal) -> String {
    let times = Method::ALL.map(|method| (method, thermal.least_seconds(method)));
    let listed = times.map(|(method, seconds)| format!("{} {:.3} ms", method.name(), 1e3 * seconds));
    let first = times.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(method, _)| *method);
    let default = Method::default();
    let verdict = if first == Some(default) { "is the fastest" } else { "is not the fastest" };
    format!(
        "Least time for an error of {} K: {}; the default, {}, {verdict} in this run.",
        Thermal::COMPARED_AT,
        listed.join(", "),
        default.name()
    )
}

/// The points as JSON; `error_k` is null where steps were too long for the method.
pub fn json(thermal: &Thermal) -> Value {
    let point = |point: &WorkPoint| {
        let (by, value) = steps(point);
        json!({
            "method": point.method.name(),
            "steps_by": by,
            "value": value,
            "error_k": point.error,
            "seconds": point.seconds,
            "steps": point.taken,
        })
    };
    json!({ "problem": thermal.problem, "points": thermal.points.iter().map(point).collect::<Vec<_>>() })
}

/// One row for each point, with a heading.
pub fn csv_text(thermal: &Thermal) -> String {
    let rows = thermal.points.iter().map(|point| {
        let (by, value) = steps(point);
        [
            point.method.name().to_owned(),
            by.to_owned(),
            value.to_string(),
            point.error.map_or_else(String::new, |error| error.to_string()),
            point.seconds.to_string(),
            point.taken.to_string(),
        ]
    });
    crate::csv_rows::text(COLUMNS, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thermal::Method;

    #[test]
    fn a_method_that_was_unstable_says_so_and_has_no_error() {
        let point =
            |steps, error| WorkPoint { method: Method::Explicit, steps, error, seconds: 0.25, taken: 7 };
        let points = vec![point(Steps::Tolerance(1e-3), Some(2e-4)), point(Steps::Fixed(1.0), None)];
        let thermal = Thermal { cases: Vec::new(), points, problem: "a phone".to_owned() };
        let plain = text(&thermal, Style::Plain);
        assert!(
            plain.contains("unstable") && plain.contains("2.0e-4") && plain.contains("250.000"),
            "{plain}"
        );
        assert_eq!(json(&thermal)["points"][1]["error_k"], Value::Null);
        let csv = csv_text(&thermal);
        assert_eq!(csv.lines().nth(1), Some("explicit,tolerance,0.001,0.0002,0.25,7"), "{csv}");
        assert_eq!(csv.lines().nth(2), Some("explicit,length,1,,0.25,7"));
    }
}
