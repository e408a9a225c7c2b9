//! The results of a check as JUnit XML, which test views of CI services read.

use super::check::{Checked, Outcome, Row, Severity};
use super::table::{changed, figure};
use super::why::{self, Why};
use crate::report::Report;
use std::fmt::Write;

/// One suite, a test for each limit: failed where a hard one is broken, skipped where there is nothing to compare with. A broken soft limit is a test that passes,
/// with a warning in its output.
pub fn junit(checked: &Checked, reasons: &[Why], report: &Report) -> String {
    let inputs = &report.inputs;
    let suite = format!("{} on {}, {}", inputs.scene, inputs.gpu, inputs.technique);
    let (tests, failures) = (checked.rows.len(), checked.failures(Severity::Hard));
    let skipped = checked.rows.iter().filter(|row| row.outcome == Outcome::NotCompared).count();
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites name=\"raybudget check\" tests=\"{tests}\" failures=\"{failures}\" errors=\"0\">\n  \
         <testsuite name=\"{}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"0\" skipped=\"{skipped}\">\n",
        escaped(&suite)
    );
    for row in &checked.rows {
        let limit = &row.limit;
        let name = format!("{} {} {}", limit.counter, limit.severity.name(), limit.rule.describe());
        write!(out, "    <testcase classname=\"{}\" name=\"{}\">", escaped(limit.place()), escaped(&name))
            .expect("a string takes every write");
        out.push_str(&result(row, reasons));
        out.push_str("</testcase>\n");
    }
    let stale: Vec<String> =
        checked.stale.iter().map(|sentence| format!("stale baseline: {sentence}")).collect();
    if !stale.is_empty() {
        writeln!(out, "    <system-err>{}</system-err>", escaped(&stale.join("\n")))
            .expect("a string takes every write");
    }
    out.push_str("  </testsuite>\n</testsuites>\n");
    out
}

/// What stands within a test.
fn result(row: &Row, reasons: &[Why]) -> String {
    let limit = &row.limit;
    let mut message = format!("{} {}, limit: {}", figure(&row.value), row.unit, limit.rule.describe());
    let change = changed(row);
    if !change.is_empty() {
        write!(message, "; change {change}").expect("a string takes every write");
    }
    let of_limit = |reason: &&Why| reason.counter == limit.counter && reason.pass == limit.pass;
    let reason = reasons.iter().find(of_limit).map(why::text).unwrap_or_default();
    match (row.outcome, limit.severity) {
        (Outcome::Pass, _) => String::new(),
        (Outcome::NotCompared, _) => "<skipped message=\"there is no baseline\"/>".to_owned(),
        (Outcome::Fail, Severity::Hard) => {
            format!("<failure type=\"hard\" message=\"{}\">{}</failure>", escaped(&message), escaped(&reason))
        }
        (Outcome::Fail, Severity::Soft) => {
            format!("<system-out>{}</system-out>", escaped(&format!("warning: {message}{reason}")))
        }
    }
}

/// Text of an element or an attribute; what XML 1.0 has no character for is left out.
fn escaped(text: &str) -> String {
    let allowed = |letter: &char| {
        !letter.is_control() && !matches!(letter, '\u{FFFE}' | '\u{FFFF}')
            || matches!(letter, '\t' | '\n' | '\r')
    };
    let mut out = String::with_capacity(text.len());
    for letter in text.chars().filter(allowed) {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            '\t' => out.push_str("&#9;"),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_place_and_has_no_character_that_xml_lacks() {
        assert_eq!(escaped("a<b>&\"c\"\n\u{1}\u{FFFF}ü"), "a&lt;b&gt;&amp;&quot;c&quot;&#10;ü");
    }
}
