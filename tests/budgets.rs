//! Does `raybudget check` pass what is within a budget, fail what is beyond it, and refuse what is no budget?

use assert_cmd::Command;
use std::path::Path;

struct Ran {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

fn check(folder: &Path, budget: &str, args: &[&str]) -> Ran {
    let path = folder.join("budget.toml");
    std::fs::write(&path, budget).expect("a file in a temporary folder");
    let output =
        raybudget().arg("check").arg("--budget").arg(&path).args(args).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Ran { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

fn raybudget() -> Command {
    assert_cmd::cargo::cargo_bin_cmd!("raybudget")
}

/// Writes the report of a small frame and returns its path and a counter of it.
fn report(folder: &Path, name: &str, size: &str) -> (String, u64) {
    let output = raybudget()
        .args(["profile", "cornell", "--size", size, "--format", "json"])
        .output()
        .expect("the program starts");
    let path = folder.join(name);
    std::fs::write(&path, &output.stdout).expect("a file in a temporary folder");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let fetches = report["counters"]["node_fetches"]["value"].as_u64().expect("a count");
    (path.to_str().expect("UTF-8").to_owned(), fetches)
}

fn limit(rule: &str) -> String {
    format!("[[limit]]\ncounter = \"node_fetches\"\n{rule}\n")
}

#[test]
fn a_frame_at_its_limit_passes_and_one_fetch_beyond_fails() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (report, fetches) = report(dir.path(), "r.json", "32x32");
    for subject in [&[report.as_str()][..], &["cornell", "--size", "32x32"]] {
        let at = check(dir.path(), &limit(&format!("hard = {{ max = {fetches} }}")), subject);
        assert_eq!((at.code, at.stderr.as_str()), (Some(0), ""), "{}", at.stdout);
        assert!(at.stdout.contains("0 hard broken"), "{}", at.stdout);
        let beyond = check(dir.path(), &limit(&format!("hard = {{ max = {} }}", fetches - 1)), subject);
        assert_eq!((beyond.code, beyond.stderr.as_str()), (Some(1), ""), "{}", beyond.stdout);
        assert!(
            beyond.stdout.contains("FAIL") && beyond.stdout.contains("1 hard broken"),
            "{}",
            beyond.stdout
        );
    }
}

#[test]
fn a_broken_soft_limit_warns_and_passes() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (report, _) = report(dir.path(), "r.json", "16x16");
    let ran = check(dir.path(), &limit("soft = { max = 1 }"), &[&report]);
    assert_eq!(ran.code, Some(0));
    assert!(ran.stdout.contains("warn") && ran.stdout.contains("1 soft broken"), "{}", ran.stdout);
}

#[test]
fn a_baseline_bounds_the_change_and_a_stale_one_is_told() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (old, before) = report(dir.path(), "old.json", "32x32");
    let (new, after) = report(dir.path(), "new.json", "32x40");
    let change = after - before;
    let run = |rule: &str| check(dir.path(), &limit(rule), &[&new, "--baseline", &old]);
    let at = run(&format!("hard = {{ max_increase = {change} }}"));
    assert_eq!(at.code, Some(0), "{}", at.stdout);
    assert!(
        at.stderr.contains("stale baseline: inputs.height is 32 in the baseline and 40 here"),
        "{}",
        at.stderr
    );
    assert_eq!(run(&format!("hard = {{ max_increase = {} }}", change - 1)).code, Some(1));
    assert_eq!(run("hard = { max_increase = \"1 %\" }").code, Some(1));
    assert_eq!(run("hard = { max_increase = \"100 %\" }").code, Some(0));
    let without = check(dir.path(), &limit("hard = { max_increase = 0 }"), &[&new]);
    assert_eq!(without.code, Some(0));
    assert!(without.stdout.contains("not compared"), "{}", without.stdout);
}

#[test]
fn the_results_can_be_had_as_json_and_csv() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (report, fetches) = report(dir.path(), "r.json", "16x16");
    let run = |format| check(dir.path(), &limit("hard = { max = 1 }"), &[&report, "--format", format]);
    let json: serde_json::Value = serde_json::from_str(&run("json").stdout).expect("JSON");
    assert_eq!((&json["passed"], &json["rows"][0]["value"]), (&false.into(), &fetches.into()));
    assert!(run("csv").stdout.contains("fail,hard,node_fetches,,max 1,"));
    assert_eq!(run("csv").code, Some(1));
}

#[test]
fn what_cannot_be_checked_is_an_error_and_not_a_failure() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (report, _) = report(dir.path(), "r.json", "16x16");
    let refused = |budget: &str, args: &[&str], expected: &[&str]| {
        let ran = check(dir.path(), budget, args);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{}", ran.stderr);
        expected.iter().for_each(|part| assert!(ran.stderr.contains(part), "{part}: {}", ran.stderr));
    };
    let good = limit("hard = { max = 1 }");
    refused(
        "[[limit]]\ncounter = \"nodes\"\nhard = { max = 1 }\n",
        &[&report],
        &["budget.toml:2", "list counters"],
    );
    refused(&limit("hard = { max = 1 }\nnote = 3"), &[&report], &["budget.toml:4", "note"]);
    refused(
        "[[limit]]\ncounter = \"texture_memory_read_bytes\"\nhard = { max = 1 }\n",
        &[&report],
        &["budget.toml:3", "texture_memory_read_bytes is absent", "no texture"],
    );
    refused(&good, &["no.json"], &["no.json: cannot open"]);
    refused(&good, &[&report, "--size", "8x8"], &["takes no options"]);
    refused(&good, &[&report, "--baseline", "no.json"], &["no.json: cannot open"]);
    let foreign = dir.path().join("foreign.json");
    std::fs::write(&foreign, "{\"schema\": 1}").expect("a file in a temporary folder");
    refused(&good, &[foreign.to_str().expect("UTF-8")], &["foreign.json", "not a report"]);
}
