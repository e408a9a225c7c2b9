//! The crate's error.

/// Why a report or a budget was refused. Messages name the file, the line where there is one, what was expected and
/// the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {remedy}")]
pub struct Error {
    place: String,
    problem: String,
    remedy: String,
}

impl Error {
    pub(crate) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }

    /// At a line, counted from 1.
    pub(crate) fn at_line(
        file: &str,
        line: usize,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::new(format!("{file}:{line}"), problem, remedy)
    }
}
