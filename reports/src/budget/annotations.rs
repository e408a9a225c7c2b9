//! The results of a check as workflow commands of GitHub Actions, which annotate the lines of the budget file.

use super::check::{Checked, Outcome, Severity};
use super::table::{changed, figure};
use super::why;
use std::fmt::Write;

/// An error for each broken hard limit, a warning for each broken soft one, a notice for what was not compared. The budget's file is called as it
/// was given; reasons stand in the messages.
pub fn annotations(checked: &Checked) -> String {
    let file = checked.file.as_str();
    let mut out = String::new();
    for (frame, row) in checked.rows() {
        let command = match (row.outcome, row.limit.severity) {
            (Outcome::Pass, _) => continue,
            (Outcome::Fail, Severity::Hard) => "error",
            (Outcome::Fail, Severity::Soft) => "warning",
            (Outcome::NotCompared, _) => "notice",
        };
        let limit = &row.limit;
        let of_frame = if checked.frames.len() > 1 { format!("{}: ", frame.name) } else { String::new() };
        let mut message =
            format!("{of_frame}{} of the {} is {} {}", limit.counter, limit.place(), figure(row), row.unit);
        match row.outcome {
            Outcome::NotCompared => message.push_str(", and there is no baseline"),
            _ => write!(message, ", limit: {}", limit.rule.describe()).expect("a string takes every write"),
        }
        let change = changed(row);
        if !change.is_empty() {
            write!(message, "; change {change}").expect("a string takes every write");
        }
        if let Some(reason) = frame.reason(row) {
            message.push_str(why::text(reason).trim_end());
        }
        writeln!(
            out,
            "::{command} file={},line={},title=raybudget {}::{}",
            property(file),
            limit.line,
            property(&limit.counter),
            data(&message)
        )
        .expect("a string takes every write");
    }
    for sentence in checked.stale() {
        writeln!(out, "::warning file={},title=stale baseline::{}", property(file), data(&sentence))
            .expect("a string takes every write");
    }
    out
}

/// As the runner unescapes a message.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// As the runner unescapes a property.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_end_a_command_or_begin_another() {
        assert_eq!(data("5 %\n::error::x"), "5 %25%0A::error::x");
        assert_eq!(property("a,b:c%"), "a%2Cb%3Ac%25");
    }
}
