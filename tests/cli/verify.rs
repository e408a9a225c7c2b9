//! `raybudget verify claims`: are all statements listed, and each miss explained?

use crate::support::{arg, file, folder, names_in, raybudget};
use serde_json::Value;
use std::fs;

#[test]
fn every_statement_is_listed_in_order_and_every_miss_says_why() {
    let dir = folder();
    let out = dir.path().join("out");
    let args = ["verify", "claims", "--paper", "A", "--quick", "--format", "json", "-o", arg(&out)];
    let (verdicts, warning) = raybudget(args).json_with_warning();
    assert!(warning.contains("built-in scenes stand in"), "{warning}");
    let rows = verdicts["rows"].as_array().expect("rows");
    let ids: Vec<&str> = rows.iter().map(|row| row["id"].as_str().expect("an id")).collect();
    assert_eq!(ids, (1..=50).map(|number| format!("A{number}")).collect::<Vec<_>>());
    for row in rows {
        let outcome = row["outcome"].as_str().expect("an outcome");
        assert!(["reproduced", "not_reproduced", "untestable"].contains(&outcome), "{row}");
        assert!(row["statement"].as_str().is_some_and(|statement| !statement.is_empty()), "{row}");
        let why = row["why"].as_str().expect("a reason");
        assert!(outcome == "reproduced" || !why.is_empty(), "{row}");
    }
    let run = &verdicts["run"];
    for (role, stand_in) in
        [("cornell", "cornell"), ("buddha", "figure"), ("fairy", "stadium"), ("sponza", "atrium")]
    {
        assert_eq!(run["scenes"][role], stand_in, "{run}");
    }
    for figure in ["wall_s", "traces", "replays", "threads"] {
        assert!(run[figure].as_f64() > Some(0.0), "{figure} in {run}");
    }

    let names = names_in(&out);
    for name in ["claims.csv", "claims.json", "claims.md"] {
        assert!(names.iter().any(|found| found == name), "{name} in {names:?}");
    }
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a text file");
    assert_eq!(serde_json::from_str::<Value>(&read("claims.json")).expect("JSON")["rows"], verdicts["rows"]);
    let csv = read("claims.csv");
    for id in ids {
        assert!(csv.lines().any(|line| line.starts_with(&format!("{id},,"))), "{id} in the CSV");
    }
    let charts: Vec<&str> = names.iter().filter_map(|name| name.strip_suffix(".svg")).collect();
    assert!(charts.len() >= 7, "counterparts of the paper's charts: {names:?}");
    for chart in charts {
        let svg = read(&format!("{chart}.svg"));
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "{chart}");
    }
    for name in names.iter().filter(|name| name.ends_with(".png")) {
        assert!(fs::read(out.join(name)).expect("a file").starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
    }
}

#[test]
fn papers_and_folders_that_there_are_not_are_refused() {
    let dir = folder();
    let out = dir.path().join("out");
    let no_folder = file(&dir, "scene.obj", "v 0 0 0\n");
    for (args, expected) in [
        (&["--paper", "Z"][..], "--paper Z: no such paper; use one of: A"),
        (&["--paper", "a"], "--paper a: no such paper"),
        (&["--paper", "A", "--scenes", arg(&no_folder)], "not a folder"),
        (&["--paper", "A", "--scenes", "no-such-folder"], "not a folder"),
    ] {
        let message = raybudget(["verify", "claims", "-o", arg(&out)].iter().chain(args)).refused();
        assert!(message.contains(expected), "{args:?}: {message}");
        assert!(!out.exists(), "{args:?}");
    }
    let without = raybudget(["verify", "claims"]);
    assert_eq!(without.code, Some(2));
    assert!(without.stderr.contains("--paper"), "{}", without.stderr);
}
