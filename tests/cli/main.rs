//! Does the command line do what it says: results, files, exit codes, refusals?

mod bad_input;
mod cache;
mod determinism;
mod outputs;
mod results;
mod support;
