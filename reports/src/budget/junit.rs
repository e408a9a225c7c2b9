//! The results of a check as JUnit XML, which test views of CI services read.

use super::check::{Checked, CheckedFrame, Outcome, Row, Severity};
use super::table::{changed, figure};
use super::why;
use std::fmt::Write;

/// A suite for each frame, a test for each limit: failed where a hard one is broken, skipped where there is nothing to compare with. A broken soft limit is a test
/// that passes, with a warning in its output. The class of a test is its pass, or the frame.
///
/// The form is that of the schema of Jenkins' xUnit plugin, `junit-10.xsd`.
pub fn junit(checked: &Checked) -> String {
    let (tests, failures) = (checked.count(|_| true), checked.failures(Severity::Hard));
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites name=\"raybudget check\" tests=\"{tests}\" failures=\"{failures}\" errors=\"0\">\n"
    );
    for (index, frame) in checked.frames.iter().enumerate() {
        // What is stale as a whole is told once; the form has no place above suites.
        let whole = if index == 0 { checked.stale_baseline.as_slice() } else { &[] };
        suite(&mut out, frame, whole, checked.frames.len() > 1);
    }
    out.push_str("</testsuites>\n");
    out
}

fn suite(out: &mut String, frame: &CheckedFrame, stale_baseline: &[String], named: bool) {
    let name = if named { format!("{}: {}", frame.name, frame.title) } else { frame.title.clone() };
    let count = |is: &dyn Fn(&&Row) -> bool| frame.rows.iter().filter(is).count();
    let failures = count(&|row| row.outcome == Outcome::Fail && row.limit.severity == Severity::Hard);
    let skipped = count(&|row| row.outcome == Outcome::NotCompared);
    writeln!(
        out,
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"0\" skipped=\"{skipped}\">",
        escaped(&name),
        frame.rows.len()
    )
    .expect("a string takes every write");
    for row in &frame.rows {
        let limit = &row.limit;
        let name = format!("{} {} {}", limit.counter, limit.severity.name(), limit.rule.describe());
        let group = limit.group.as_ref().map(|group| format!(" group=\"{}\"", escaped(group)));
        write!(
            out,
            "    <testcase classname=\"{}\" name=\"{}\"{}>",
            escaped(limit.place()),
            escaped(&name),
            group.unwrap_or_default()
        )
        .expect("a string takes every write");
        out.push_str(&result(frame, row));
        out.push_str("</testcase>\n");
    }
    let stale: Vec<String> = frame
        .stale
        .iter()
        .chain(stale_baseline)
        .map(|sentence| format!("stale baseline: {sentence}"))
        .collect();
    if !stale.is_empty() {
        writeln!(out, "    <system-err>{}</system-err>", escaped(&stale.join("\n")))
            .expect("a string takes every write");
    }
    out.push_str("  </testsuite>\n");
}

/// What stands within a test.
fn result(frame: &CheckedFrame, row: &Row) -> String {
    let limit = &row.limit;
    let mut message = format!("{} {}, limit: {}", figure(row), row.unit, limit.rule.describe());
    let change = changed(row);
    if !change.is_empty() {
        write!(message, "; change {change}").expect("a string takes every write");
    }
    let reason = frame.reason(row).map(why::text).unwrap_or_default();
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
