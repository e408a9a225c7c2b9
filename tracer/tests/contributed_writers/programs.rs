//! The writers' programs, built and run.

use std::ffi::OsStr;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A program of each writer whose language is there.
pub(crate) struct Programs {
    pub(crate) folder: TempDir,
    pub(crate) all: Vec<Program>,
}

/// A program and how it is started.
pub(crate) struct Program {
    pub(crate) name: &'static str,
    start: Vec<std::ffi::OsString>,
}

impl Programs {
    /// Those of the sources `name.c` and `name.py`, or of the one that there is.
    pub(crate) fn new(name: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/contributed_writers").join(name);
        let mut all = Vec::new();
        if source.with_extension("c").exists() && is_there("cc", "--version") {
            let built = folder.path().join(name);
            compile(&source.with_extension("c"), &built);
            all.push(Program { name: "c", start: vec![built.into()] });
        }
        // Of an older Python the annotations are no syntax.
        if source.with_extension("py").exists()
            && is_there("python3", "-cimport sys; sys.exit(sys.version_info < (3, 9))")
        {
            let start = vec!["python3".into(), "-B".into(), source.with_extension("py").into()];
            all.push(Program { name: "python", start });
        }
        Self { folder, all }
    }
}

fn is_there(program: &str, argument: &str) -> bool {
    let run = Command::new(program).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = run.is_ok_and(|status| status.success());
    if !there {
        eprintln!("skipped: {program} is not there or too old");
    }
    there
}

fn compile(source: &Path, built: &Path) {
    let flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-o"];
    let output = Command::new("cc").args(flags).arg(built).arg(source).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

impl Program {
    /// What it prints, or with exit code 1 its error.
    pub(crate) fn run(&self, arguments: &[&OsStr], input: impl AsRef<[u8]>) -> Result<String, String> {
        let mut running = Command::new(&self.start[0])
            .args(&self.start[1..])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let input = input.as_ref();
        let mut pipe = running.stdin.take().expect("a pipe");
        // A program that refuses early closes it; what it says comes below.
        let _ = std::thread::scope(|scope| {
            let written = scope.spawn(move || pipe.write_all(input));
            written.join().expect("no panic")
        });
        let output = running.wait_with_output().expect("it ends");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        match output.status.code() {
            Some(0) => Ok(stdout),
            Some(1) if !stderr.contains("Traceback") => Err(stderr),
            code => panic!("{} ended with {code:?}: {stderr}", self.name),
        }
    }
}
