//! Commands of the pages that no test runs.

use crate::page::{Kind, Page};

/// How they begin, and why. Checks of the model are another matter, see [`is_of_ci`].
const NOT_RUN: [(&str, &str); 5] = [
    ("cargo install", "it builds for minutes, and installs"),
    ("cargo test", "it is what runs this test"),
    ("git ", "there is nowhere to clone from or to push to"),
    (
        "python3 ",
        "a machine with Rust alone has none; tests/cli/bring_your_own.rs runs it where there is one",
    ),
    ("mdbook ", "it is not a part of a Rust toolchain; .ci/run builds the book"),
];

/// Whether a command is among them.
pub(crate) fn is_listed(command: &str) -> bool {
    NOT_RUN.iter().any(|(start, _)| command.trim_start().starts_with(start))
}

/// Whether it is a check of the model, which takes a release build: `.ci/run` has it, in the quick form.
pub(crate) fn is_of_ci(command: &str) -> bool {
    let Some(check) = command.strip_prefix("raybudget verify ") else {
        return false;
    };
    let ci = std::fs::read_to_string(crate::root().join(".ci/run")).expect(".ci/run");
    assert!(
        ci.contains(&format!("raybudget verify {check} --quick")),
        ".ci/run does not run '{command} --quick'"
    );
    true
}

/// A script without the lines that are such commands.
pub(crate) fn without(script: &str) -> String {
    script.lines().filter(|line| !is_listed(line)).map(|line| format!("{line}\n")).collect()
}

/// Panics where one is on no page any more.
pub(crate) fn check(pages: &[Page]) {
    for (start, reason) in NOT_RUN {
        assert!(!reason.is_empty());
        let is_used = pages.iter().flat_map(|page| &page.items).any(|item| match &item.kind {
            Kind::Block { text, .. } => text.lines().any(|line| {
                let line = line.trim_start();
                let line = line.strip_prefix("- run: ").or(line.strip_prefix("$ ")).unwrap_or(line);
                line.starts_with(start)
            }),
            Kind::Code { text, .. } => text.starts_with(start),
            Kind::Heading(_) | Kind::Link(_) => false,
        });
        assert!(is_used, "no page has a command '{start}' any more");
    }
}
