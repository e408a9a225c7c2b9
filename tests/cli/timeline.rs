//! `timeline.json`: does it say of every pass what the report says?

use crate::support::{SMALL, arg, folder, raybudget};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// Nanoseconds of a time in microseconds.
fn nanoseconds(microseconds: &Value) -> u64 {
    (microseconds.as_f64().expect("a number") * 1e3).round() as u64
}

#[test]
fn every_technique_has_its_passes_one_after_the_other_and_they_make_up_the_frame_time() {
    let runs: [&[&str]; 4] = [
        &["profile", "cornell"],
        &["profile", "cornell", "--technique", "hybrid", "--fidelity", "timed"],
        &[
            "profile",
            "cornell",
            "--gpu",
            "mali-g715",
            "--accel",
            "wide-bvh",
            "--force",
            "glossy",
            "--technique",
            "reflections-hybrid",
        ],
        &["profile", "cornell", "--ray-sets", "hard-shadows,ao", "--fidelity", "replay"],
    ];
    for run in runs {
        let dir = folder();
        raybudget(run.iter().copied().chain(SMALL).chain(["-o", arg(dir.path())])).ok();
        let (report, timeline) =
            (read(&dir.path().join("report.json")), read(&dir.path().join("timeline.json")));
        let events = timeline["traceEvents"].as_array().expect("a list");
        let slices: Vec<&Value> =
            events.iter().filter(|event| event["ph"] == "X" && event["name"] != "frame").collect();
        let time = |pass: &Value| pass["counters"]["frame_time_ms"]["value"].as_f64().unwrap_or(0.0);
        let passes: Vec<&Value> =
            report["passes"].as_array().expect("passes").iter().filter(|pass| time(pass) > 1e-6).collect();
        let names = |of: &[&Value]| of.iter().map(|one| one["name"].clone()).collect::<Vec<_>>();
        assert_eq!(names(&slices), names(&passes), "{run:?}");
        let mut end = 0;
        for (slice, pass) in slices.iter().zip(&passes) {
            assert_eq!(nanoseconds(&slice["ts"]), end, "{run:?}");
            end += nanoseconds(&slice["dur"]);
            let read = &pass["counters"]["dram_read_bytes"]["value"];
            assert_eq!(slice["args"]["Read Total, B"], *read, "{run:?}");
            let at = |event: &&Value| event["name"] == "Read Total" && event["ts"] == slice["ts"];
            let rate = events.iter().find(at).expect("a counter")["args"]["GB/s"].as_f64().expect("a figure");
            let expected = read.as_f64().expect("bytes") / time(pass) * 1e-6;
            assert!((rate - expected).abs() <= 1e-9 * expected, "{run:?}: {rate}, {expected} expected");
        }
        let frame = report["counters"]["frame_time_ms"]["value"].as_f64().expect("a time") * 1e6;
        assert!((end as f64 - frame).abs() <= 1.0, "{run:?}: {end} of {frame} ns");
    }
}

#[test]
fn the_time_line_is_the_same_on_one_thread_and_on_many() {
    let [one, many] = ["1", "5"].map(|threads| {
        let dir = folder();
        let args = ["profile", "teapot", "--threads", threads, "-o", arg(dir.path())];
        raybudget(args.into_iter().chain(SMALL)).ok();
        fs::read(dir.path().join("timeline.json")).expect("a file")
    });
    assert!(one == many);
}
