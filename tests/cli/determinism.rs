//! The same inputs give the same bytes: on any number of threads, again, and from a trace.

use crate::support::{arg, folder, raybudget};
use serde_json::Value;

/// The report as bytes, without what the run cost.
fn answer(args: &[&str]) -> String {
    let mut report = raybudget(args.iter().chain(&["--format", "json"])).json();
    let run = report.as_object_mut().expect("an object").remove("run").expect("run figures");
    assert!(run["wall_s"].as_f64().expect("a time") > 0.0);
    serde_json::to_string_pretty(&report).expect("JSON")
}

/// Names the first line that differs.
fn assert_same(ours: &str, theirs: &str, what: &str) {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let (ours, theirs) = (lines(ours), lines(theirs));
    let differing = ours.iter().zip(&theirs).position(|(a, b)| a != b);
    if let Some(line) = differing {
        panic!("{what}: line {line}: {} is not {}", ours[line], theirs[line]);
    }
    assert_eq!(ours.len(), theirs.len(), "{what}");
}

#[test]
fn threads_and_repetition_change_nothing_but_the_run_figures() {
    for (accel, traversal) in [("bvh", "stack"), ("kd", "push-down")] {
        let frame = ["profile", "teapot", "--size", "300x200", "--accel", accel, "--traversal", traversal];
        let with = |threads| answer(&[&frame[..], &["--threads", threads]].concat());
        let one = with("1");
        for threads in ["1", "2", "5"] {
            assert_same(&with(threads), &one, threads);
        }
    }
}

#[test]
fn the_run_figures_say_how_many_threads_there_were() {
    for threads in ["1", "2"] {
        let args = ["profile", "cornell", "--size", "8x8", "--threads", threads, "--format", "json"];
        assert_eq!(raybudget(args).json()["run"]["threads"].to_string(), threads);
    }
}

#[test]
fn a_replay_equals_the_profile_for_every_traversal_and_layout() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    for traversal in tracer::Traversal::ALL {
        let frame =
            ["--size", "100x70", "--accel", traversal.accel().name(), "--traversal", traversal.name()];
        raybudget(["trace", "cornell", "-o", arg(&trace)].iter().chain(&frame)).ok();
        for layout in ["padded", "compact", "split"] {
            let profile = answer(&[&["profile", "cornell", "--layout", layout][..], &frame].concat());
            let replay = answer(&["replay", arg(&trace), "--layout", layout]);
            assert_same(&replay, &profile, &format!("{traversal:?}, {layout}"));
        }
    }
}

#[test]
fn a_trace_keeps_the_options_of_its_traversal() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    let frame = [
        "--size",
        "50x50",
        "--traversal",
        "restart-trail",
        "--short-stack",
        "4",
        "--trail-bits",
        "32",
        "--ct",
        "1",
    ];
    raybudget(["trace", "teapot", "-o", arg(&trace)].iter().chain(&frame)).ok();
    let replay = answer(&["replay", arg(&trace)]);
    assert_same(&replay, &answer(&[&["profile", "teapot"][..], &frame].concat()), "replay");
    let report: Value = serde_json::from_str(&replay).expect("JSON");
    assert_eq!(report["inputs"]["short_stack"], 4);
    assert_eq!(report["inputs"]["trail_bits"], 32);
    assert_eq!(report["inputs"]["sah_costs"][0], 1.0);
}
