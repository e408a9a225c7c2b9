//! `raybudget whatif`: does each answer equal a replay, and is what makes no sense left out or refused?

use crate::support::{arg, file, folder, names_in, raybudget, without_run};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn recorded(dir: &TempDir, options: &[&str]) -> PathBuf {
    let trace = dir.path().join("t.rbt");
    raybudget(["trace", "teapot", "--size", "60x44", "-o", arg(&trace)].iter().chain(options)).ok();
    trace
}

/// A trace of a list of rays.
fn listed(dir: &TempDir) -> PathBuf {
    let ray: [f32; 8] = [278.0, 500.0, -800.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY];
    let bytes: Vec<u8> = ray.iter().flat_map(|value| value.to_le_bytes()).collect();
    let rays = file(dir, "rays.bin", bytes.repeat(70));
    let trace = dir.path().join("list.rbt");
    raybudget(["trace", "cornell", "--rays", arg(&rays), "-o", arg(&trace)]).ok();
    trace
}

/// Labels of the changes, the unchanged frame first.
fn labels(whatif: &Value) -> Vec<&str> {
    let variants = whatif["variants"].as_array().expect("variants");
    variants.iter().map(|variant| variant["values"][0].as_str().expect("a label")).collect()
}

fn report<'a>(whatif: &'a Value, label: &str) -> &'a Value {
    let variants = whatif["variants"].as_array().expect("variants");
    let found = variants.iter().find(|variant| variant["values"][0] == label);
    &found.unwrap_or_else(|| panic!("no '{label}' among {:?}", labels(whatif)))["report"]
}

fn replay(trace: &Path, machine: &[&str]) -> Value {
    without_run(&raybudget(["replay", arg(trace), "--format", "json"].iter().chain(machine)).json())
}

#[test]
fn each_change_equals_a_replay_with_that_option_alone() {
    let dir = folder();
    let trace = recorded(&dir, &[]);
    let gpu = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/gpus/adreno-540.toml");
    let changes: [(&str, &str); 9] = [
        ("--layout", "compact"),
        ("--layout", "split"),
        ("--primitive-order", "indexed"),
        ("--node-records", "child-boxes"),
        ("--node-order", "van-emde-boas"),
        ("--technique", "compute"),
        ("--technique", "hybrid"),
        ("--gpu", gpu),
        ("--set", "cache.uche.line=128"),
    ];
    let given = changes.iter().flat_map(|(option, value)| [*option, *value]);
    let whatif = raybudget(["whatif", arg(&trace), "--format", "json"].into_iter().chain(given)).json();
    assert_eq!(labels(&whatif).len(), 1 + changes.len());
    assert_eq!(labels(&whatif)[0], "unchanged");
    assert_eq!(without_run(report(&whatif, "unchanged")), replay(&trace, &[]));
    for (option, value) in changes {
        let label = match option {
            "--set" => value.replace('=', " "),
            _ => format!("{} {value}", &option[2..]),
        };
        assert_eq!(without_run(report(&whatif, &label)), replay(&trace, &[option, value]), "{label}");
    }
    let set = raybudget(["whatif", arg(&trace), "--set", "cache.uche.size=65536+262144", "--format", "json"]);
    let set = set.json();
    for size in ["65536", "262144"] {
        let option = format!("cache.uche.size={size}");
        let replayed = replay(&trace, &["--set", &option]);
        assert_eq!(without_run(report(&set, &format!("cache.uche.size {size}"))), replayed);
    }
}

#[test]
fn every_change_is_tried_unless_some_are_named_and_the_best_comes_first() {
    let dir = folder();
    for (options, expected) in [
        (&[][..], ["node-records child-boxes", "primitive-order indexed"]),
        (&["--accel", "kd"], ["primitive-order leaf", "node-records padded"]),
    ] {
        let trace = recorded(&dir, options);
        let out = dir.path().join("out");
        let printed = raybudget(["whatif", arg(&trace), "--format", "json", "-o", arg(&out)]).ok();
        let whatif: Value = serde_json::from_str(&printed).expect("JSON");
        let labels = labels(&whatif);
        assert_eq!(labels[0], "unchanged");
        for label in expected.iter().chain(&["layout split", "technique hybrid", "technique compute"]) {
            assert!(labels.contains(label), "{options:?}: no {label} in {labels:?}");
        }
        assert!(!labels.contains(&"layout padded") && !labels.contains(&"technique fragment"), "{labels:?}");
        let own = if options.is_empty() { "primitive-order leaf" } else { "primitive-order indexed" };
        assert!(!labels.contains(&own), "{options:?}: {labels:?}");
        let time = |label: &&str| report(&whatif, label)["counters"]["frame_time_ms"]["value"].as_f64();
        let times: Vec<f64> = labels.iter().map(|label| time(label).expect("a time")).collect();
        assert!(times[1..].is_sorted(), "{labels:?}: {times:?}");
        assert!(times[1] < times[0], "some change gains: {labels:?}: {times:?}");

        assert_eq!(names_in(&out), ["whatif.csv", "whatif.html", "whatif.json", "whatif.md"]);
        assert_eq!(fs::read_to_string(out.join("whatif.json")).expect("a file"), printed);
        let csv = fs::read_to_string(out.join("whatif.csv")).expect("a file");
        assert_eq!(csv.lines().count(), 1 + labels.len() * gpumodel::COUNTERS.len());
    }
}

#[test]
fn a_trace_that_does_not_say_what_a_rasteriser_draws_leaves_hybrid_out() {
    let dir = folder();
    // The first byte tells the fuzzer that a file follows.
    let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/trace_file/whole.rbt");
    let old = fs::read(old).expect("a file of the repository").split_off(1);
    let old = file(&dir, "old.rbt", old);
    for trace in [listed(&dir), old] {
        let run = raybudget(["whatif", arg(&trace), "--format", "json"]);
        let (whatif, warning) = run.json_with_warning();
        assert!(warning.contains("hybrid rendering is left out"), "{warning}");
        let labels = labels(&whatif);
        assert!(!labels.iter().any(|label| label.contains("hybrid")), "{labels:?}");
        assert!(labels.contains(&"technique compute") && labels.contains(&"layout split"), "{labels:?}");
        let out = dir.path().join("out");
        let args = ["whatif", arg(&trace), "--technique", "hybrid", "-o", arg(&out)];
        let message = raybudget(args).refused();
        assert!(message.contains("; "), "{message}");
        assert!(!out.exists());
    }
}

#[test]
fn what_no_trace_can_answer_is_refused() {
    let dir = folder();
    let trace = recorded(&dir, &["--traversal", "parent-link"]);
    let out = dir.path().join("out");
    for (args, expected) in [
        (&["--set", "cache.uche.line"][..], "--set cache.uche.line: expected KEY=V+V"),
        (&["--set", "cache.uche.line=64+64"], "given twice"),
        (&["--set", "cache.uche.line=64+"], "a value is empty"),
        (&["--set", "cache.l9.line=1"], "has no figure 'cache.l9.line'"),
        (&["--set", "cache.uche.line=wide"], "'wide' is not a value"),
        // Only figures of the GPU are set; another tree or traversal needs another trace.
        (&["--set", "layout=split"], "--set layout=split"),
        (&["--set", "ct-ci=3:1"], "--set ct-ci=3:1"),
        (&["--set", "traversal=kd-stack"], "--set traversal=kd-stack"),
        (&["--layout", "split,split"], "--layout split,split: a value is empty or given twice"),
        (&["--layout", "tight"], "padded, compact, split"),
        (&["--gpu", "adreno-9999"], "adreno-9999"),
        (&["--technique", "magic"], "magic"),
        (&["--node-records", "child-boxes"], "parent-link"),
        (&["--costs", "no.toml"], "no.toml"),
    ] {
        let message = raybudget(["whatif", arg(&trace), "-o", arg(&out)].iter().chain(args)).refused();
        assert!(message.contains(expected), "{args:?}: {message}");
        assert!(!out.exists(), "{args:?}");
    }
    assert!(raybudget(["whatif", "no.rbt"]).refused().contains("no.rbt"));
    let torn = fs::read(&trace).expect("a trace");
    let torn = file(&dir, "torn.rbt", &torn[..torn.len() / 2]);
    assert!(raybudget(["whatif", arg(&torn), "-o", arg(&out)]).refused().contains("torn.rbt"));
    assert!(!out.exists());
}

#[test]
fn threads_change_no_answer() {
    let dir = folder();
    let trace = recorded(&dir, &[]);
    let [one, two] = ["1", "2"].map(|threads| {
        let whatif = raybudget(["whatif", arg(&trace), "--threads", threads, "--format", "json"]).json();
        let variants = whatif["variants"].as_array().expect("variants");
        let answers =
            variants.iter().map(|variant| json!([variant["values"], without_run(&variant["report"])]));
        answers.collect::<Vec<_>>()
    });
    assert_eq!(one, two);
}
