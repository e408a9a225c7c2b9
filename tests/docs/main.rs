//! Is the guide true? Every command of README.md and of docs/*.md is run, what they show is compared, and their links lead somewhere.
//!
//! A page is done from top to bottom in a folder of its own, pages beside each other:
//!
//! * A block `toml` or `yaml` that begins with a comment like `# budget.toml` becomes that file.
//! * A block `sh` is run by `sh -eu`; so are spans of code that begin with the name of a program and have an argument. A span with the name of a
//!   command alone, such as that of `raybudget profile`, is asked for its help. Frames are small there, see [`session`].
//! * A block `console` is run as it stands, and shows what comes out; a line `...` stands for lines that are not shown.
//! * The scripts of a block `yaml`, a workflow, are run by `bash -e`, as GitHub Actions does.
//!
//! Codes are 0 where nothing else is said: in a console by `echo $?`, behind a span by "(exit code 1". What is not run here stands in [`not_run`].
#![cfg(unix)]

mod keys;
mod links;
mod not_run;
mod page;
mod session;
mod shown;

use page::{Kind, Page};
use session::Session;
use std::path::Path;
use std::process::Command;

macro_rules! pages {
    ($($test:ident = $name:literal,)*) => {
        /// Pages with tests, by name.
        const PAGES: &[&str] = &[$($name),*];

        $(
            #[test]
            fn $test() {
                Session::of(&Page::read($name));
            }
        )*
    };
}

pages! {
    the_readme_is_true = "README.md",
    the_introduction_is_true = "docs/introduction.md",
    the_page_on_installing_is_true = "docs/install.md",
    the_page_on_the_first_profile_is_true = "docs/first-profile.md",
    the_page_on_reports_is_true = "docs/report.md",
    the_page_on_comparing_is_true = "docs/comparing.md",
    the_page_on_sweeps_is_true = "docs/sweeping.md",
    the_page_on_budgets_is_true = "docs/budgets.md",
    the_page_on_gpus_is_true = "docs/your-gpu.md",
    the_page_on_techniques_is_true = "docs/your-technique.md",
    the_page_on_accuracy_is_true = "docs/accuracy.md",
    the_page_on_the_trace_format_is_true = "docs/trace-format.md",
    the_page_of_counters_is_true = "docs/counters.md",
    the_contents_are_true = "docs/SUMMARY.md",
}

/// The page that ends with a change that breaks its budget.
const FIRST_BUDGET: &str = "docs/first-budget.md";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn pages() -> Vec<Page> {
    let names = PAGES.iter().copied().chain([FIRST_BUDGET]);
    names.map(Page::read).collect()
}

#[test]
fn a_change_that_breaks_the_budget_fails_the_workflow_and_is_annotated() {
    // The page runs the workflow once itself, where it must pass.
    let session = Session::of(&Page::read(FIRST_BUDGET));
    let ran = session.run_workflow();
    assert_eq!(ran.code, 1, "{}", ran.output);
    let annotation = |line: &str| line.starts_with("::error file=budget.toml,line=");
    assert!(ran.output.lines().any(annotation), "{}", ran.output);
}

#[test]
fn what_is_not_true_is_found() {
    let is_found = |text: &str| std::panic::catch_unwind(|| Session::of(&Page::of("page.md", text))).is_err();
    for text in [
        "```sh\nfalse\n```",
        "```console\n$ echo a\nb\n```",
        "```console\n$ false\n```",
        "```console\n$ false\n$ echo $?\n0\n```",
        "```\n$ ls\n```",
        "```\nraybudget list gpus\nsgrt\n```",
        "```toml\nmax = \n```",
        "```yaml\n- run: false\n```",
        "```fortran\n```",
        "`raybudget list weather`",
        "`raybudget weather`",
        "`raybudget verify weather`",
        "`raybudget list gpus` (exit code 1)",
        "`... --gpu sgrt`",
    ] {
        assert!(is_found(text), "{text}");
    }
    for text in [
        "```sh\ntrue\n```",
        "```console\n$ echo a\na\n```",
        "```console\n$ false\n$ echo $?\n1\n```",
        "```yaml\n- run: |\n    false || true\n    true\n```",
        "`raybudget list gpus`, `raybudget list`",
        "`raybudget check scene.obj --budget none.toml; exit 1` (exit code 1)",
    ] {
        assert!(!is_found(text), "{text}");
    }
}

#[test]
fn every_page_has_a_test() {
    let mut found: Vec<String> = vec!["README.md".to_owned()];
    for file in std::fs::read_dir(root().join("docs")).expect("a folder") {
        let name = file.expect("a file").file_name().into_string().expect("UTF-8");
        if name.ends_with(".md") {
            found.push(format!("docs/{name}"));
        }
    }
    found.sort();
    let mut tested: Vec<&str> = PAGES.iter().copied().chain([FIRST_BUDGET]).collect();
    tested.sort_unstable();
    assert_eq!(found, tested);
}

#[test]
fn every_link_leads_somewhere() {
    pages().iter().for_each(links::check);
}

#[test]
fn every_chapter_is_in_the_contents_once() {
    let contents = Page::read("docs/SUMMARY.md");
    let mut listed = links::targets(&contents);
    listed.sort_unstable();
    let mut chapters: Vec<String> = pages().into_iter().map(|page| page.name).collect();
    chapters.retain(|name| name != "README.md" && name != "docs/SUMMARY.md");
    chapters.sort();
    let chapters: Vec<&str> = chapters.iter().filter_map(|name| name.strip_prefix("docs/")).collect();
    assert_eq!(listed, chapters);
}

#[test]
fn what_is_not_run_is_on_a_page() {
    not_run::check(&pages());
}

#[test]
fn the_page_of_counters_is_that_of_the_program() {
    let printed = help(&["list", "counters", "--format", "markdown"]);
    let page = std::fs::read_to_string(root().join("docs/counters.md")).expect("a page");
    assert!(printed == page, "run: raybudget list counters --format markdown > docs/counters.md");
}

#[test]
fn every_option_that_a_page_names_is_one_of_the_program() {
    let mut helps = String::new();
    for command in [
        "profile",
        "render",
        "stereo",
        "trace",
        "replay",
        "compare",
        "whatif",
        "sweep",
        "check",
        "cache",
        "list",
        "verify claims",
        "verify accuracy",
        "verify hardware",
        "verify stability",
        "verify thermal",
    ] {
        let mut words: Vec<&str> = command.split(' ').collect();
        words.push("--help");
        helps += &help(&words);
    }
    let of_program = |option: &str| {
        let is_end = |c: char| !(c.is_ascii_alphanumeric() || c == '-');
        helps.match_indices(option).any(|(at, _)| helps[at + option.len()..].starts_with(is_end))
    };
    for page in pages() {
        for item in &page.items {
            let Kind::Code { text, .. } = &item.kind else { continue };
            for option in
                text.split([' ', '=']).filter(|word| text.starts_with("--") && word.starts_with("--"))
            {
                assert!(of_program(option), "{}: there is no {option}", page.place(item));
            }
        }
    }
}

fn help(args: &[&str]) -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_raybudget")).args(args).output().expect("the program starts");
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}
