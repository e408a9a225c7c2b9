//! The one error of this crate: what is wrong, where, and what to do about it.

use std::fmt;

/// Why a description of caches or DRAM, or a file of addresses, was refused.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A description of cache levels that cannot be simulated.
    #[error("{place}: {problem}; {remedy}")]
    Levels {
        /// File, line and level, as far as known.
        place: Box<Place>,
        /// What is wrong and what was expected.
        problem: String,
        /// What to change.
        remedy: String,
    },
    /// A file of addresses that cannot be understood.
    #[error("{place}: {problem}; {remedy}")]
    Addresses {
        /// File and line or byte offset.
        place: Box<Place>,
        /// What is wrong and what was expected.
        problem: String,
        /// What to change.
        remedy: String,
    },
    /// A description of DRAM that cannot be simulated.
    #[error("{place}: {key}{problem}; {remedy}")]
    Dram {
        /// The file, or what else was described, and the line, as far as known.
        place: Box<Place>,
        /// The figure, followed by ": ", or empty.
        key: String,
        /// What is wrong and what was expected.
        problem: String,
        /// What to change.
        remedy: String,
    },
    /// A file of addresses that cannot be read.
    #[error("{place}: cannot read: {source}")]
    Read {
        /// File and line or byte offset reached.
        place: Box<Place>,
        /// The operating system's reason.
        source: std::io::Error,
    },
}

/// Where in an input something is: each part is absent when unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file's name as the user gave it.
    pub file: Option<String>,
    /// The line in the file, from 1.
    pub line: Option<u64>,
    /// The byte offset in a binary file, from 0.
    pub byte: Option<u64>,
    /// The `[[level]]` table, from 1, with its name where it has one.
    pub level: Option<(usize, Option<String>)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, byte, level } = self;
        f.write_str(file.as_deref().unwrap_or("cache levels"))?;
        if let Some(line) = line {
            write!(f, ":{line}")?;
        }
        if let Some(byte) = byte {
            write!(f, ": byte {byte}")?;
        }
        match level {
            Some((number, Some(name))) => write!(f, ": [[level]] {number} ({name})"),
            Some((number, None)) => write!(f, ": [[level]] {number}"),
            None => Ok(()),
        }
    }
}

impl Error {
    pub(crate) fn levels(place: Place, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Levels { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }

    pub(crate) fn addresses(place: Place, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Addresses { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }
}
