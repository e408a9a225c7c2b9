//! The crate's error.

use crate::config::Gpu;

/// Why a configuration was refused or a trace could not be replayed. Messages name the file, the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A configuration file is not what it should be.
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
    /// The trace contradicts itself, or holds what this replay cannot do.
    #[error("trace of '{scene}': {problem}; {remedy}")]
    Trace {
        /// Scene that the trace's header names.
        scene: String,
        /// What was found and what was expected.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// A kernel asks for what the GPU does not have.
    #[error("kernel: {problem}; {remedy}")]
    Kernel {
        /// What was found and what was expected.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// Rays or hits cannot be ordered like that.
    #[error("order of rays: {problem}; {remedy}")]
    Ordering {
        /// What was found and what was expected.
        problem: String,
        /// What to do about it.
        remedy: String,
    },
    /// The time of a frame has no solution.
    #[error(
        "time under contention on {gpu}: {problem}; correct the figures of the GPU's description that are far from any hardware's, or use --fidelity timed"
    )]
    Network {
        /// The GPU's name.
        gpu: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// The trace could not be read or made.
    #[error(transparent)]
    Source(#[from] tracer::Error),
}

impl Error {
    /// The memory of `gpu` cannot be as described.
    pub(crate) fn dram(gpu: &Gpu, error: &cachesim::Error) -> Self {
        Self::Config {
            file: gpu.name().to_owned(),
            line: None,
            key: "dram: ".to_owned(),
            problem: error.to_string(),
            remedy: "correct [dram]".to_owned(),
        }
    }
}
