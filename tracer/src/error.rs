//! The crate's error.

use std::io;
use std::path::PathBuf;

/// Why a structure could not be built, or a trace not written or read. Messages name the file, the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The options contradict each other or the scene.
    #[error("{0}")]
    Options(String),
    /// A file could not be opened, read or written.
    #[error("{path}: {action} failed: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done.
        action: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// A trace or ray file is not what it should be.
    #[error("{path}: byte {offset}: {problem}; {remedy}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Where in the file the trouble was seen, in bytes from its start.
        offset: u64,
        /// What was expected and what was there.
        problem: String,
        /// What to do about it.
        remedy: &'static str,
    },
}
