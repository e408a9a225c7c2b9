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
    assert_eq!((&json["passed"], &json["frames"][0]["rows"][0]["value"]), (&false.into(), &fetches.into()));
    assert!(run("csv").stdout.contains("cornell,,fail,hard,node_fetches,,max 1,"));
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
    let foreign = dir.path().join("foreign.json");
    std::fs::write(&foreign, "{\"schema\": 1}").expect("a file in a temporary folder");
    refused(&good, &[foreign.to_str().expect("UTF-8")], &["foreign.json", "not a report"]);
}

#[test]
fn an_improvement_that_is_asked_for_is_there_or_not() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (old, before) = report(dir.path(), "old.json", "32x40");
    let (new, after) = report(dir.path(), "new.json", "32x32");
    let change = before - after;
    let run = |rule: &str, subject: &str, baseline: &str| {
        check(dir.path(), &limit(rule), &[subject, "--baseline", baseline]).code
    };
    let decrease = |least: u64| format!("hard = {{ min_decrease = {least} }}");
    assert_eq!(run(&decrease(change), &new, &old), Some(0));
    assert_eq!(run(&decrease(change + 1), &new, &old), Some(1));
    assert_eq!(run("hard = { min_decrease = \"1 %\" }", &new, &old), Some(0));
    assert_eq!(run("hard = { min_decrease = \"99 %\" }", &new, &old), Some(1));
    assert_eq!(run("hard = { min_increase = \"1 %\" }", &new, &old), Some(1));
    assert_eq!(run("hard = { min_increase = \"1 %\" }", &old, &new), Some(0));
    let without = check(dir.path(), &limit(&decrease(1)), &[&new]);
    assert_eq!(without.code, Some(0));
    assert!(without.stdout.contains("no baseline"), "{}", without.stdout);
    let wrong = check(dir.path(), &limit("hard = { min_decrease = -1 }"), &[&new]);
    assert!(
        wrong.stderr.contains("budget.toml:3") && wrong.stderr.contains("at least 0"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn a_broken_limit_says_which_parts_of_the_counter_changed() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (old, before) = report(dir.path(), "old.json", "32x32");
    let (new, after) = report(dir.path(), "new.json", "32x40");
    let budget = |counter: &str, rule: &str| format!("[[limit]]\ncounter = \"{counter}\"\n{rule}\n");
    let why = |counter: &str, rule: &str, more: &[&str]| {
        let args = [&[new.as_str(), "--why", "--format", "json"], more].concat();
        let ran = check(dir.path(), &budget(counter, rule), &args);
        assert_eq!(ran.code, Some(1), "{}", ran.stderr);
        let json: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON");
        json["frames"][0]["why"].as_array().expect("reasons").clone()
    };
    let against = ["--baseline", old.as_str()];
    let sum = |reasons: &[serde_json::Value], by: &str, figure: &str| -> f64 {
        let causes = reasons[0]["causes"].as_array().expect("causes");
        let of = causes.iter().filter(|cause| cause["by"] == by);
        of.map(|cause| cause[figure].as_f64().expect("a figure")).sum()
    };
    let fetches = why("node_fetches", "hard = { max_increase = 0 }", &against);
    assert_eq!(
        (sum(&fetches, "pass", "value"), sum(&fetches, "pass", "baseline")),
        (after as f64, before as f64)
    );
    // Of two ways to break a counter's limits, one reason; without a baseline, parts and no changes.
    let both = why("node_fetches", "soft = { max = 1 }\nhard = { max = 1 }", &[]);
    assert_eq!((both.len(), sum(&both, "pass", "value")), (1, after as f64));
    assert!(both[0]["causes"][0]["baseline"].is_null());
    let bytes = why("dram_read_bytes", "hard = { max = 1 }", &[]);
    assert!(sum(&bytes, "pass and buffer", "value") > 0.0, "{bytes:?}");
    let lines = why("l2_misses", "hard = { max = 1 }", &[]);
    assert!(lines[0]["causes"].to_string().contains(" in uche"), "{lines:?}");

    let args = [&[new.as_str(), "--why"], &against[..]].concat();
    let text = check(dir.path(), &budget("frame_time_ms", "hard = { max_increase = 0 }"), &args).stdout;
    assert!(text.contains("\nwhy frame_time_ms of the frame, in ms\n  "), "{text}");
    assert!(text.contains("  pass: ") && text.contains("  resource: ") && text.contains(" from "), "{text}");
    let kept = check(dir.path(), &limit("hard = { min = 1 }"), &[&new, "--why"]);
    assert!(kept.code == Some(0) && !kept.stdout.contains("why"), "{}", kept.stdout);
}

#[test]
fn results_are_told_in_the_forms_that_ci_services_read() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (report, _) = report(dir.path(), "r.json", "16x16");
    let budget =
        "[[limit]]\ncounter = \"node_fetches\"\nsoft = { max = 1 }\nhard = { max = 2, max_increase = 0 }\n";
    let run = |format: &str| {
        let ran = check(dir.path(), budget, &[&report, "--why", "--format", format]);
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(1), ""), "{format}");
        ran.stdout
    };
    let junit = run("junit");
    for part in [
        "<testsuites name=\"raybudget check\" tests=\"3\" failures=\"1\" errors=\"0\">",
        "<testcase classname=\"frame\" name=\"node_fetches hard max 2\"><failure type=\"hard\" message=\"",
        "<skipped message=\"there is no baseline\"/>",
        "<system-out>warning: ",
        "why node_fetches of the frame",
    ] {
        assert!(junit.contains(part), "no {part} in {junit}");
    }
    assert_eq!(junit.matches("<testcase ").count(), junit.matches("</testcase>").count());
    let github = run("github");
    let lines: Vec<&str> = github.lines().collect();
    let starts = [("::warning", 3), ("::error", 4), ("::notice", 4)];
    assert_eq!(lines.len(), starts.len(), "{github}");
    for (line, (command, of_budget)) in lines.iter().zip(starts) {
        assert!(line.starts_with(&format!("{command} file=")), "{line}");
        assert!(
            line.contains(&format!(
                "budget.toml,line={of_budget},title=raybudget node_fetches::node_fetches of the frame is "
            )),
            "{line}"
        );
    }
    let markdown = run("markdown");
    assert!(markdown.starts_with("## Budget broken: cornell on adreno-540, fragment\n"), "{markdown}");
    assert!(markdown.contains("| FAIL | `node_fetches` | frame | hard max 2 |"), "{markdown}");
    assert!(
        markdown.contains("3 limits: 1 hard broken, 1 soft broken, 1 not compared for want of a baseline."),
        "{markdown}"
    );
}

#[test]
fn accepted_figures_are_a_baseline_that_can_be_reviewed() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (old, before) = report(dir.path(), "old.json", "32x32");
    let (new, after) = report(dir.path(), "new.json", "32x40");
    let accepted = dir.path().join("accepted.toml");
    let path = accepted.to_str().expect("UTF-8");
    let compared = limit(&format!("hard = {{ max_increase = {} }}", after - before));

    // The first run has no baseline, which is no error.
    let first = check(dir.path(), &compared, &[&old, "--baseline", path]);
    assert_eq!(first.code, Some(0));
    assert!(
        first.stderr.contains("there is no such baseline") && first.stdout.contains("no baseline"),
        "{}",
        first.stderr
    );

    assert_eq!(check(dir.path(), &compared, &[&old, "--accept", path]).code, Some(0));
    let text = std::fs::read_to_string(&accepted).expect("a text");
    assert!(
        text.contains(&format!("node_fetches = {before}\n"))
            && text.contains("[cornell.passes.\"primary rays\"]"),
        "{text}"
    );
    assert!(text.len() < 2500 && !text.contains("dram_read_bytes"), "{} bytes: {text}", text.len());
    let again = dir.path().join("again.toml");
    check(dir.path(), &compared, &[&old, "--accept", again.to_str().expect("UTF-8")]);
    assert_eq!(std::fs::read_to_string(&again).expect("a text"), text, "the same bytes each time");

    let run =
        |rule: &str, subject: &str| check(dir.path(), &limit(rule), &[subject, "--baseline", path, "--why"]);
    let same = run("hard = { max_increase = 0 }", &old);
    assert_eq!((same.code, same.stderr.as_str()), (Some(0), ""), "{}", same.stdout);
    let at = format!("hard = {{ max_increase = {} }}", after - before);
    assert_eq!(run(&at, &new).code, Some(0));
    let beyond = run(&format!("hard = {{ max_increase = {} }}", after - before - 1), &new);
    assert_eq!(beyond.code, Some(1));
    assert!(beyond.stdout.contains("  pass: primary rays: "), "{}", beyond.stdout);
    assert!(
        beyond.stderr.contains("stale baseline: inputs.height is 32 in the baseline and 40 here"),
        "{}",
        beyond.stderr
    );

    std::fs::write(&accepted, format!("weather = 3\n{text}")).expect("a file");
    let broken = check(dir.path(), &compared, &[&new, "--baseline", path]);
    assert_eq!(broken.code, Some(2));
    assert!(
        broken.stderr.contains("accepted.toml:") && broken.stderr.contains("--accept"),
        "{}",
        broken.stderr
    );
}

#[test]
fn a_sample_will_do_where_it_decides_and_all_tiles_are_replayed_where_it_does_not() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let budget = |rule: &str| format!("[[limit]]\ncounter = \"alu_operations\"\n{rule}\n");
    let frame = ["atrium", "--size", "768x768", "--format", "csv"];
    let sampling = [&frame[..], &["--sample", "25%", "--seed", "1"]].concat();
    let operations = |ran: &Ran| -> u64 {
        let row = ran.stdout.lines().nth(1).expect("a row");
        row.split(',').nth(7).expect("a figure").parse().expect("a whole number")
    };
    let whole = check(dir.path(), &budget("hard = { max = 1 }"), &frame);
    assert_eq!((whole.code, whole.stderr.as_str()), (Some(1), ""), "{}", whole.stdout);
    let exact = operations(&whole);

    let far = check(dir.path(), &budget("hard = { max = 1 }"), &sampling);
    assert_eq!((far.code, far.stderr.as_str()), (Some(1), ""), "{}", far.stdout);
    assert_ne!(operations(&far), exact, "it is of a sample");
    let near = budget(&format!("hard = {{ max = {} }}", exact + 1));
    let asked = check(dir.path(), &near, &sampling);
    assert_eq!(asked.stdout, check(dir.path(), &near, &frame).stdout, "all tiles were replayed");
    assert_eq!((asked.code, asked.stderr.as_str()), (Some(0), ""));
    // What takes no samples is replayed as before.
    for other in [
        ["cornell", "--technique", "hybrid"],
        ["chess", "--technique", "reflections-hybrid"],
        ["cornell", "--fidelity", "timed"],
    ] {
        let frame = [&other[..], &["--size", "32x32"]].concat();
        let sampling = [&frame[..], &["--sample", "6%"]].concat();
        let [asked, whole] = [sampling, frame].map(|args| check(dir.path(), &near, &args));
        assert_eq!((asked.code, &asked.stdout), (whole.code, &whole.stdout), "{}", asked.stderr);
    }
}

#[test]
fn what_a_finished_sample_leaves_open_is_told_and_it_is_no_baseline() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let report = dir.path().join("r.json");
    let args = ["profile", "atrium", "--size", "768x768", "--sample", "25%", "--format", "json"];
    let profile = raybudget().args(args).output().expect("the program starts");
    std::fs::write(&report, &profile.stdout).expect("a file");
    let text: serde_json::Value = serde_json::from_slice(&profile.stdout).expect("JSON");
    let reads = text["counters"]["dram_read_bytes"]["value"].as_u64().expect("a count");
    let report = report.to_str().expect("UTF-8");
    let budget = format!("[[limit]]\ncounter = \"dram_read_bytes\"\nhard = {{ max = {reads} }}\n");
    let open = check(dir.path(), &budget, &[report]);
    assert_eq!(open.code, Some(0), "{}", open.stderr);
    assert_eq!(
        open.stderr,
        "warning: atrium: the sample leaves open whether the limit on dram_read_bytes is kept; replay the whole frame\n"
    );
    let accepted = dir.path().join("accepted.toml");
    let accepted = accepted.to_str().expect("UTF-8");
    for (args, told) in [
        (&[report, "--accept", accepted][..], "atrium: figures of a sample are no baseline"),
        (&[report, "--sample", "6%"], "a finished report has no tiles to sample"),
        (&["--sample", "6%", "--accept", accepted], "cannot be used with"),
        (&["--seed", "6"], "--sample"),
        (&["--sample", "200%"], "--sample 200%"),
    ] {
        let refused = check(dir.path(), &budget, args);
        assert_eq!(refused.code, Some(2), "{args:?}: {}", refused.stdout);
        assert!(refused.stderr.contains(told), "{args:?}: {}", refused.stderr);
    }
    assert!(!Path::new(accepted).exists());
}
