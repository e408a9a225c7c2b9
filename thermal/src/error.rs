//! The one error of this crate: what is wrong, where, and what to do about it.

/// Why a description was refused, or a simulation could not go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A description of a phone that cannot be simulated.
    #[error("{file}{}: {key}{problem}; {remedy}", line.map(|line| format!(":{line}")).unwrap_or_default())]
    Config {
        /// The file's name, as the caller gave it.
        file: String,
        /// Line in it, from 1, where one is known.
        line: Option<usize>,
        /// The key at fault and a colon, or nothing.
        key: String,
        /// What was found and what was expected.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// A network, an input or a request without a meaning.
    #[error("{what}: {problem}; {remedy}")]
    Input {
        /// What was given.
        what: String,
        /// What was found and what was expected.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// The integration does not reach its end.
    #[error("{method} at {at_s} s: {problem}; use the exponential method, or a larger tolerance")]
    Stuck {
        /// The method.
        method: &'static str,
        /// Time reached, in seconds.
        at_s: f64,
        /// What happened.
        problem: String,
    },
}

impl Error {
    pub(crate) fn input(
        what: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Input { what: what.into(), problem: problem.into(), remedy: remedy.into() }
    }
}
