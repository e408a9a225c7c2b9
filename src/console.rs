//! What is printed: results on standard output, everything else on standard error.

use anyhow::anyhow;
use reports::text::Style;
use std::io::{ErrorKind, IsTerminal, Write};

/// Whoever read standard output has had enough: a success.
#[derive(Debug)]
pub(crate) struct StdoutClosed;

impl std::fmt::Display for StdoutClosed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("standard output was closed")
    }
}

impl std::error::Error for StdoutClosed {}

/// Prints a result.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => anyhow::Error::new(StdoutClosed),
        _ => anyhow!("standard output: cannot write: {error}; free space, or redirect it elsewhere"),
    })
}

/// Whether results may hold terminal escapes: only on a terminal, and not if NO_COLOR is set (<https://no-color.org>).
pub(crate) fn style() -> Style {
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if std::io::stdout().is_terminal() && !no_color { Style::Ansi } else { Style::Plain }
}

/// Says how far long work is, on a terminal.
pub(crate) fn status(text: &str) {
    if std::io::stderr().is_terminal() {
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

/// Says what the user should know although the work goes on.
pub(crate) fn warn(text: &str) {
    // Nothing is left to tell if standard error is gone.
    let _ = writeln!(std::io::stderr(), "warning: {text}");
}

/// Says why the work ended.
pub(crate) fn error(error: &anyhow::Error) {
    let _ = writeln!(std::io::stderr(), "error: {error}");
}
