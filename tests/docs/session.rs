//! Running the commands of a page, in a folder with the files that it speaks of.

use crate::not_run;
use crate::page::{Kind, Page};
use crate::shown;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Programs that a page's commands call; a span or a plain block that begins with one of these is a command.
const PROGRAMS: [&str; 5] = ["raybudget", "cargo", "git", "mdbook", "rustup"];

/// Stands for `raybudget` in spans and scripts, so that a page takes seconds: frames without a `--size` have 64x64 pixels. Consoles, whose output is
/// shown, are of `raybudget` itself.
const SMALL: &str = r#"#!/bin/sh
[ $# -gt 0 ] || exec "$RAYBUDGET" profile --size 64x64 -o raybudget-out
more=
case " $* " in
    *" --size "* | *" --help "* | *" --rays "*) ;;
    *)
        case "$1 ${2-}" in
            "check "*.json | "check --budget" | "compare "*.json) ;;
            "profile "* | "trace "* | "render "* | "stereo "* | "compare "* | "check "*) more="--size 64x64" ;;
        esac
        ;;
esac
exec "$RAYBUDGET" "$@" $more
"#;

const WHOLE: &str = "#!/bin/sh\nexec \"$RAYBUDGET\" \"$@\"\n";

/// `cargo run --release` builds `raybudget` and runs it; here it is built.
const CARGO: &str = "#!/bin/sh\n[ \"$1 $2\" = \"run --release\" ] || exit 127\nshift 2\n[ \"${1-}\" != -- ] || shift\nexec raybudget \"$@\"\n";

/// A page at work.
pub(crate) struct Session {
    folder: TempDir,
    tools: TempDir,
    workflow: Option<String>,
}

/// Which `raybudget` a command gets.
#[derive(Clone, Copy)]
enum Frames {
    Small,
    Whole,
}

/// What a command left behind.
pub(crate) struct Ran {
    pub(crate) code: i32,
    /// Standard output and standard error, as on a terminal.
    pub(crate) output: String,
}

impl Session {
    /// Does all that a page says, from its first line to its last; panics where something does not come out as it says.
    pub(crate) fn of(page: &Page) -> Self {
        let mut session = Self { folder: folder(), tools: tools(), workflow: None };
        for item in &page.items {
            let place = page.place(item);
            match &item.kind {
                Kind::Block { language, text } => session.block(&place, language, text),
                Kind::Code { text, after } => session.span(&place, text, after),
                Kind::Heading(_) | Kind::Link(_) => {}
            }
        }
        session
    }

    /// Does what the page's workflow does; ends at the first step that fails.
    pub(crate) fn run_workflow(&self) -> Ran {
        let workflow = self.workflow.as_ref().expect("the page has a workflow");
        let mut all = Ran { code: 0, output: String::new() };
        for step in steps(workflow) {
            let step = not_run::without(&step);
            let ran = self.run(&["bash", "-e", "-c", &step], Frames::Small);
            all.output += &ran.output;
            all.code = ran.code;
            if all.code != 0 {
                break;
            }
        }
        all
    }

    fn block(&mut self, place: &str, language: &str, text: &str) {
        let is_command =
            |line: &str| ["$"].iter().chain(&PROGRAMS).any(|start| line.starts_with(&format!("{start} ")));
        match language {
            "console" => self.console(place, text),
            "sh" => self.script(place, text),
            "" if !text.contains("$ ") && text.lines().all(is_command) => self.script(place, text),
            "" | "text" | "c" => {
                let has_commands = text.lines().any(is_command);
                assert!(!has_commands, "{place}: a block with commands and what they show is a ```console");
            }
            "toml" => {
                if let Err(error) = text.parse::<toml::Table>() {
                    panic!("{place}: {error}");
                }
                self.file(text);
            }
            "yaml" => {
                self.file(text);
                self.workflow = Some(text.to_owned());
                let Ran { code, output } = self.run_workflow();
                assert_eq!(code, 0, "{place}: the workflow fails:\n{output}");
            }
            _ => panic!("{place}: a block of '{language}', of which this test does not know what to do"),
        }
    }

    /// Writes a block whose first line is a comment with the name of a file.
    fn file(&self, text: &str) {
        let name = text.lines().next().and_then(|line| line.strip_prefix("# "));
        let Some(name) = name.filter(|name| !name.contains(' ') && name.contains('.')) else {
            return;
        };
        let path = self.folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }

    fn script(&self, place: &str, text: &str) {
        let script = not_run::without(text);
        let ran = self.run(&["sh", "-eu", "-c", &script], Frames::Small);
        assert_eq!(ran.code, 0, "{place}: these commands fail:\n{script}\n{}", ran.output);
    }

    /// A code other than 0 is shown by `echo $?`.
    fn console(&self, place: &str, text: &str) {
        let mut previous = 0;
        for (command, shown) in commands(place, text) {
            if not_run::is_listed(command) {
                continue;
            }
            let shows_code = command == "echo $?";
            assert!(shows_code || previous == 0, "{place}: before '{command}' something failed");
            let command = format!("(exit {previous}); {command}");
            let ran = self.run(&["sh", "-c", &command], Frames::Whole);
            previous = ran.code;
            let actual: Vec<&str> = ran.output.lines().collect();
            assert!(
                shown.is_empty() || shown::matches(&shown, &actual),
                "{place}: {command}\nshows other than\n{}",
                ran.output
            );
        }
        assert_eq!(
            previous, 0,
            "{place}: the last command fails, and the page does not say so with 'echo $?'"
        );
    }

    fn span(&self, place: &str, text: &str, after: &str) {
        assert!(!text.starts_with("... "), "{place}: `{text}` is no whole command");
        let words: Vec<&str> = text.split(' ').collect();
        if words.len() < 2
            || !PROGRAMS.contains(&words[0])
            || not_run::is_listed(text)
            || not_run::is_of_ci(text)
        {
            return;
        }
        let is_name = words.len() == 2 && words[0] == "raybudget";
        let command = if is_name { format!("{text} --help") } else { text.to_owned() };
        let ran = self.run(&["sh", "-c", &command], Frames::Small);
        let expected = i32::from(after.starts_with(" (exit code 1"));
        assert_eq!(ran.code, expected, "{place}: {command}\n{}", ran.output);
    }

    fn run(&self, command: &[&str], frames: Frames) -> Ran {
        let tools = self.tools.path().join(match frames {
            Frames::Small => "small",
            Frames::Whole => "whole",
        });
        let mut path = tools.into_os_string();
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        let (reader, writer) = std::io::pipe().expect("a pipe");
        let mut child = Command::new(command[0])
            .args(&command[1..])
            .current_dir(self.folder.path())
            .env("PATH", path)
            .env("RAYBUDGET", env!("CARGO_BIN_EXE_raybudget"))
            .env("GITHUB_STEP_SUMMARY", self.folder.path().join("summary.md"))
            .stdin(Stdio::null())
            .stdout(writer.try_clone().expect("a pipe"))
            .stderr(writer)
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", command[0]));
        let output = std::io::read_to_string(reader).expect("UTF-8");
        let code = child.wait().expect("it ends").code().expect("no signal ends it");
        Ran { code, output }
    }
}

/// Commands of a console, and the lines that it shows of each.
fn commands<'a>(place: &str, text: &'a str) -> Vec<(&'a str, Vec<&'a str>)> {
    let mut commands: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in text.lines() {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(command), _) => commands.push((command, Vec::new())),
            (None, Some((_, shown))) => shown.push(line),
            (None, None) => panic!("{place}: a console begins with a command"),
        }
    }
    commands
}

/// Scripts of the steps of a workflow of GitHub Actions: `run: COMMAND`, or `run: |` and lines that stand farther right.
fn steps(workflow: &str) -> Vec<String> {
    let mut steps = Vec::new();
    let mut lines = workflow.lines().peekable();
    while let Some(line) = lines.next() {
        let key = line.trim_start().trim_start_matches("- ");
        let Some(script) = key.strip_prefix("run: ") else { continue };
        if script != "|" {
            steps.push(script.to_owned());
            continue;
        }
        let indent = line.len() - key.len();
        let mut script = String::new();
        while let Some(line) = lines.next_if(|line| line.len() - line.trim_start().len() > indent) {
            script += line.trim_start();
            script.push('\n');
        }
        steps.push(script);
    }
    steps
}

/// What a page takes for granted: somebody's scene and files, and those of the repository.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let root = crate::root();
    for name in ["configs", "tracer"] {
        std::os::unix::fs::symlink(root.join(name), folder.path().join(name)).expect("a link");
    }
    std::fs::create_dir(folder.path().join("docs")).expect("a folder");
    let files = root.join("tests/docs/files");
    for file in std::fs::read_dir(&files).unwrap_or_else(|error| panic!("{}: {error}", files.display())) {
        let file = file.expect("a file");
        std::fs::copy(file.path(), folder.path().join(file.file_name())).expect("a copy");
    }
    std::fs::copy(root.join("configs/energy.toml"), folder.path().join("my-energy.toml")).expect("a copy");
    for (page, name) in [("docs/your-gpu.md", "my-gpu.toml"), ("docs/your-technique.md", "my-technique.toml")]
    {
        let page = Page::read(page);
        let text = page.file(name).unwrap_or_else(|| panic!("{}: no {name}", page.name));
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// Folders for PATH.
fn tools() -> TempDir {
    let tools = tempfile::tempdir().expect("a temporary folder");
    for (folder, raybudget) in [("small", SMALL), ("whole", WHOLE)] {
        let folder = tools.path().join(folder);
        std::fs::create_dir(&folder).expect("a folder");
        for (name, script) in [("raybudget", raybudget), ("cargo", CARGO)] {
            let path = folder.join(name);
            std::fs::write(&path, script).expect("a script");
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("a mode");
        }
    }
    tools
}
