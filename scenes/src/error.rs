//! The one error of this crate: where, what was expected, and what to do.

use std::fmt;

/// Why a scene could not be loaded: the file, the line where there is one, the problem, and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Error {
    place: String,
    line: Option<u64>,
    problem: String,
    remedy: String,
}

impl Error {
    pub(crate) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Error { place: place.into(), line: None, problem: problem.into(), remedy: remedy.into() }
    }

    /// The same error with the line (counted from 1) it was found on; 0 means before the first line.
    pub(crate) fn at_line(mut self, line: u64) -> Self {
        self.line = (line > 0).then_some(line);
        self
    }

    /// The file, or the name of the input that was refused.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// The line of the file, counted from 1, where the format has lines.
    pub fn line(&self) -> Option<u64> {
        self.line
    }

    /// What was found and what was expected instead.
    pub fn problem(&self) -> &str {
        &self.problem
    }

    /// What the user can do about it.
    pub fn remedy(&self) -> &str {
        &self.remedy
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}; {}", self.place, self.problem, self.remedy),
            None => write!(f, "{}: {}; {}", self.place, self.problem, self.remedy),
        }
    }
}
