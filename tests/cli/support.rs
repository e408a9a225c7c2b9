//! Running the program and looking at what came out.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A small frame: quick, and with partly filled tiles at two edges.
pub(crate) const SMALL: [&str; 2] = ["--size", "40x36"];

/// What a folder of a report holds.
pub(crate) const REPORT_FILES: [&str; 9] = [
    "counters.csv",
    "divergence.png",
    "dram-lines.png",
    "loaded-bytes.png",
    "node-fetches.png",
    "report.html",
    "report.json",
    "report.txt",
    "timeline.json",
];

/// What a run left behind.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs `raybudget` with these arguments.
pub(crate) fn raybudget<S: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = S>) -> Ran {
    finish(command().args(args))
}

/// The program, ready for arguments.
pub(crate) fn command() -> Command {
    assert_cmd::cargo::cargo_bin_cmd!("raybudget")
}

/// Runs a command to its end.
pub(crate) fn finish(command: &mut Command) -> Ran {
    let output = command.output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Ran { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

impl Ran {
    /// The result of a run that went well and had nothing to say but its result.
    pub(crate) fn ok(self) -> String {
        assert_eq!((self.code, self.stderr.as_str()), (Some(0), ""), "{}", self.stdout);
        self.stdout
    }

    /// The result as JSON.
    pub(crate) fn json(self) -> Value {
        serde_json::from_str(&self.ok()).expect("JSON")
    }

    /// The result as JSON of a run that went well and had something to say besides; and what that was.
    pub(crate) fn json_with_warning(self) -> (Value, String) {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        assert!(self.stderr.starts_with("warning: "), "{}", self.stderr);
        (serde_json::from_str(&self.stdout).expect("JSON"), self.stderr)
    }

    /// The error of a run that was refused: one message, nothing on standard output.
    pub(crate) fn refused(self) -> String {
        assert_eq!((self.code, self.stdout.as_str()), (Some(2), ""), "{}", self.stderr);
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        assert_eq!(self.stderr.matches("error:").count(), 1, "{}", self.stderr);
        self.stderr
    }
}

/// A report without what the run cost: the part that follows from the inputs alone.
pub(crate) fn without_run(report: &Value) -> Value {
    let mut report = report.clone();
    report.as_object_mut().expect("a report").remove("run").expect("run figures");
    report
}

/// A folder that goes when the test ends.
pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Writes a file into the folder.
pub(crate) fn file(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("a file in a temporary folder");
    path
}

/// Names of what is in a folder, sorted.
pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A path as an argument.
pub(crate) fn arg(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}
