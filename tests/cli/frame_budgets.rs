//! Budgets that name their frames: which limits are for which, baselines of several, and what CI services read.

use crate::support::{Ran, arg, file, folder, raybudget};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

/// Two scenes on two GPUs, with limits for all, for one scene, for one GPU, for one technique and for one frame.
const BUDGET: &str = r#"
[base]
size = "24x16"

[[frame]]
name = "box & light"
scene = "cornell"

[[frame]]
name = "pot in a unit"
scene = "teapot"
gpu = "mali-g715"
accel = "wide-bvh"

[[frame]]
name = "pot, computed"
scene = "teapot"
technique = "compute"

[[limit]]
counter = "node_fetches"
group = "work"
hard = { max_increase = 0 }

[[limit]]
counter = "frame_time_ms"
scene = "teapot"
group = "time"
hard = { max = 100 }

[[limit]]
counter = "dram_read_bytes"
gpu = "mali-g715"
soft = { max = 1 }

[[limit]]
counter = "rays"
technique = "compute"
hard = { min = 1 }

[[limit]]
counter = "primitive_tests"
frame = "box & light"
pass = "primary rays"
group = "work"
soft = { max = 1 }
"#;

fn checked(folder: &TempDir, budget: &str, args: &[&str]) -> Ran {
    let path = file(folder, "budget.toml", budget);
    raybudget(["check", "--budget", arg(&path)].into_iter().chain(args.iter().copied()))
}

fn rows(json: &Value) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap_or("-").to_owned();
    let frames = json["frames"].as_array().expect("frames");
    let row = |frame: &Value, row: &Value| {
        [&frame["frame"], &row["group"], &row["counter"], &row["outcome"]].map(text).join(" / ")
    };
    let rows = |frame: &Value| -> Vec<String> {
        frame["rows"].as_array().expect("rows").iter().map(|each| row(frame, each)).collect()
    };
    frames.iter().flat_map(rows).collect()
}

#[test]
fn each_limit_is_held_against_the_frames_that_it_is_for() {
    let folder = folder();
    let json = checked(&folder, BUDGET, &["--format", "json"]).json();
    assert_eq!(
        rows(&json),
        [
            "box & light / work / node_fetches / not_compared",
            "box & light / work / primitive_tests / fail",
            "pot in a unit / work / node_fetches / not_compared",
            "pot in a unit / time / frame_time_ms / pass",
            "pot in a unit / - / dram_read_bytes / fail",
            "pot, computed / work / node_fetches / not_compared",
            "pot, computed / time / frame_time_ms / pass",
            "pot, computed / - / rays / pass",
        ]
    );
    assert_eq!((&json["hard_failures"], &json["soft_failures"]), (&0.into(), &2.into()));
    let text = checked(&folder, BUDGET, &["--why"]).ok();
    assert!(text.contains("8 limits: 0 hard broken, 2 soft broken, 3 not compared"), "{text}");
    assert!(text.contains("; broken by group: work 1 of 4\n"), "{text}");
    assert!(
        text.contains(
            "\nbox & light (cornell on adreno-540, fragment)\nwhy primitive_tests of the primary rays"
        ),
        "{text}"
    );
    let broken = checked(&folder, &BUDGET.replace("max = 100", "max = 1e-9"), &["--format", "github"]);
    assert_eq!(broken.code, Some(1));
    let errors = broken.stdout.lines().filter(|line| line.starts_with("::error ")).count();
    assert_eq!(errors, 2, "{}", broken.stdout);
    assert!(broken.stdout.contains("::pot in a unit: frame_time_ms of the frame is "), "{}", broken.stdout);
}

#[test]
fn a_verdict_is_the_same_on_any_number_of_threads_in_every_form() {
    let folder = folder();
    let budget = BUDGET.replace("max = 100", "max = 1e-9");
    for format in ["text", "json", "csv", "markdown", "junit", "github"] {
        let run = |threads: &str| {
            let ran = checked(&folder, &budget, &["--why", "--format", format, "--threads", threads]);
            (ran.code, ran.stdout)
        };
        let one = run("1");
        assert_eq!(one, run("2"), "{format}");
        assert_eq!(one.0, Some(1), "{format}");
    }
}

#[test]
fn figures_of_several_frames_are_accepted_and_held_against_by_name() {
    let folder = folder();
    let baseline = folder.path().join("baseline.toml");
    checked(&folder, BUDGET, &["--accept", arg(&baseline)]).ok();
    let against = ["--baseline", arg(&baseline), "--format", "json"];
    let same = checked(&folder, BUDGET, &against).json();
    assert!(rows(&same).iter().filter(|row| row.contains("node_fetches")).all(|row| row.ends_with("pass")));

    let other = BUDGET.replace("accel = \"wide-bvh\"", "accel = \"wide-bvh\"\nnode-format = \"full-4\"");
    let changed = checked(&folder, &other, &against);
    assert!(
        changed.stderr.contains("stale baseline: pot in a unit: inputs.node_format is"),
        "{}",
        changed.stderr
    );

    let renamed = checked(&folder, &BUDGET.replace("pot, computed", "new"), &against);
    assert_eq!(renamed.code, Some(0));
    for part in [
        "stale baseline: new: the baseline has no such frame",
        "the baseline has a frame 'pot, computed', the budget has none",
    ] {
        assert!(renamed.stderr.contains(part), "no {part} in {}", renamed.stderr);
    }
    let json: Value = serde_json::from_str(&renamed.stdout).expect("JSON");
    assert!(rows(&json).contains(&"new / work / node_fetches / not_compared".to_owned()));
    assert_eq!(
        json["stale"],
        serde_json::json!(["the baseline has a frame 'pot, computed', the budget has none"])
    );

    let more = BUDGET
        .replace("counter = \"rays\"", "counter = \"primitive_tests_per_ray\"")
        .replace("hard = { min = 1 }", "hard = { max_increase = 1 }");
    let lacking = checked(&folder, &more, &against);
    assert!(
        lacking.stderr.contains("pot, computed: the baseline has no figure of primitive_tests_per_ray"),
        "{}",
        lacking.stderr
    );

    let text = fs::read_to_string(&baseline).expect("a text");
    let absurd = file(&folder, "absurd.toml", text.replacen("node_fetches = ", "node_fetches = nan # ", 1));
    let refused = checked(&folder, BUDGET, &["--baseline", arg(&absurd)]);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains("node_fetches of 'box & light' is no finite number"),
        "{}",
        refused.stderr
    );
}

#[test]
fn accepted_figures_take_the_place_of_no_other_file() {
    let folder = folder();
    let budget = folder.path().join("budget.toml");
    let ran = checked(&folder, BUDGET, &["--accept", arg(&budget)]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("no file of accepted figures, and would be lost"), "{}", ran.stderr);
    assert_eq!(fs::read_to_string(&budget).expect("a text"), BUDGET);
}

#[test]
fn lines_of_a_level_s_counter_are_those_of_that_level() {
    let folder = folder();
    let budget = "[[limit]]\ncounter = \"l2_misses\"\nhard = { max = 0 }\n";
    let args = ["teapot", "--gpu", "mali-g715", "--size", "16x16", "--why", "--format", "json"];
    let ran = checked(&folder, budget, &args);
    let json: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let frame = &json["frames"][0];
    let causes = frame["why"][0]["causes"].as_array().expect("causes");
    let levels = causes.iter().filter(|cause| cause["by"] == "pass, buffer and level");
    let sum: f64 = levels.clone().map(|cause| cause["value"].as_f64().expect("a figure")).sum();
    assert_eq!(Some(sum), frame["rows"][0]["value"].as_f64(), "{causes:?}");
    assert!(
        levels.clone().count() > 0
            && levels
                .clone()
                .all(|cause| cause["part"].as_str().is_some_and(|part| part.ends_with(" in l2")))
    );
}

#[test]
fn a_budget_that_cannot_be_followed_is_refused_with_its_line() {
    let folder = folder();
    let report = raybudget(["profile", "cornell", "--size", "8x8", "--format", "json"]).ok();
    let report = file(&folder, "report.json", report);
    for (budget, args, expected) in [
        (BUDGET.to_owned(), vec!["cornell"], "the budget names its frames; leave out the scene"),
        (BUDGET.to_owned(), vec!["--gpu", "mali-g78"], "the budget names its frames"),
        (
            BUDGET.to_owned(),
            vec!["--baseline", arg(&report)],
            "a report is the baseline of one frame, and there are 3",
        ),
        (
            BUDGET.replace("accel", "weather"),
            vec![],
            "budget.toml:9: frame 'pot in a unit': weather: no such option",
        ),
        (BUDGET.replace("wide-bvh", "oak"), vec![], "frame 'pot in a unit': invalid value 'oak'"),
        (BUDGET.replace("24x16", "24"), vec![], "frame 'box & light': --size 24: expected"),
        (BUDGET.replace("size =", "colour ="), vec![], "base.colour: no such option"),
        (
            BUDGET.replace("pot, computed", "pot\\ncomputed"),
            vec![],
            "budget.toml:15: a frame called \"pot\\ncomputed\"",
        ),
        (
            BUDGET.replace("group = \"time\"", "group = \"ti\\u001bme\""),
            vec![],
            "a group called \"ti\\u{1b}me\"",
        ),
        (
            BUDGET.replace("scene = \"teapot\"\ngroup", "scene = \"kettle\"\ngroup"),
            vec![],
            "budget.toml:29: the limit on frame_time_ms is for none",
        ),
    ] {
        let ran = checked(&folder, &budget, &args);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{expected}");
        assert!(ran.stderr.contains(expected), "{expected}: {}", ran.stderr);
    }
}

/// An element of JUnit's form.
struct Element {
    name: &'static str,
    /// Attributes that it must have.
    required: &'static [&'static str],
    /// Attributes that it may have.
    optional: &'static [&'static str],
    /// Elements that it may have.
    children: &'static [&'static str],
}

/// After the schema that Jenkins' xUnit plugin holds reports against, version 10.
const JUNIT: [Element; 7] = [
    Element {
        name: "testsuites",
        required: &[],
        optional: &["name", "time", "tests", "failures", "errors"],
        children: &["testsuite"],
    },
    Element {
        name: "testsuite",
        required: &["name", "tests", "failures", "errors"],
        optional: &[
            "group",
            "time",
            "skipped",
            "timestamp",
            "hostname",
            "id",
            "package",
            "file",
            "log",
            "url",
        ],
        children: &["testsuite", "properties", "testcase", "system-out", "system-err"],
    },
    Element {
        name: "testcase",
        required: &["name"],
        optional: &["time", "classname", "group"],
        children: &["skipped", "error", "failure", "system-out", "system-err"],
    },
    Element { name: "failure", required: &[], optional: &["type", "message"], children: &[] },
    Element { name: "skipped", required: &[], optional: &["type", "message"], children: &[] },
    Element { name: "system-out", required: &[], optional: &[], children: &[] },
    Element { name: "system-err", required: &[], optional: &[], children: &[] },
];

fn assert_junit(node: roxmltree::Node<'_, '_>) {
    let name = node.tag_name().name();
    let Element { required, optional, children, .. } =
        JUNIT.iter().find(|known| known.name == name).expect(name);
    let attributes: Vec<&str> = node.attributes().map(|attribute| attribute.name()).collect();
    assert!(required.iter().all(|each| attributes.contains(each)), "{name} has {attributes:?}");
    assert!(
        attributes.iter().all(|each| required.contains(each) || optional.contains(each)),
        "{name} has {attributes:?}"
    );
    for child in node.children().filter(|child| child.is_element()) {
        assert!(children.contains(&child.tag_name().name()), "{child:?} in {name}");
        assert_junit(child);
    }
}

#[test]
fn junit_is_of_its_schema_and_counts_what_it_holds() {
    let folder = folder();
    let baseline = folder.path().join("baseline.toml");
    checked(&folder, &BUDGET.replace("24x16", "24x24"), &["--accept", arg(&baseline)]).ok();
    let budget = BUDGET.replace("max = 100", "max = 1e-9").replace("pot, computed", "new <pot>");
    let ran = checked(&folder, &budget, &["--why", "--format", "junit", "--baseline", arg(&baseline)]);
    assert_eq!(ran.code, Some(1));
    let document = roxmltree::Document::parse(&ran.stdout).expect("XML");
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "testsuites");
    assert_junit(root);
    let number = |node: roxmltree::Node<'_, '_>, name: &str| {
        node.attribute(name).expect(name).parse::<usize>().expect("a number")
    };
    let within = |node: roxmltree::Node<'_, '_>, tag: &str| {
        node.descendants().filter(|node| node.has_tag_name(tag)).count()
    };
    let suites: Vec<_> = root.children().filter(|node| node.is_element()).collect();
    assert_eq!(suites.len(), 3);
    for node in suites.iter().copied().chain([root]) {
        assert_eq!(
            (number(node, "tests"), number(node, "failures")),
            (within(node, "testcase"), within(node, "failure"))
        );
    }
    assert!(
        within(root, "failure") == 2 && within(root, "skipped") == 1 && within(root, "system-err") == 3,
        "{}",
        ran.stdout
    );
    assert_eq!(suites[2].attribute("name"), Some("new <pot>: teapot on adreno-540, compute"));
}

#[test]
fn the_example_is_kept_by_the_built_in_scenes() {
    let configs = concat!(env!("CARGO_MANIFEST_DIR"), "/configs");
    let (budget, baseline) =
        (format!("{configs}/budgets/example.toml"), format!("{configs}/baselines/example.toml"));
    let accepted = fs::read_to_string(&baseline).expect("accepted figures");
    assert!(accepted.starts_with("# Figures that limits"), "{accepted}");
    let text = raybudget(["check", "--budget", &budget, "--baseline", &baseline]).ok();
    assert!(text.contains("0 hard broken, 0 soft broken\n"), "{text}");
}
