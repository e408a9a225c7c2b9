//! `raybudget verify accuracy`: is every frame measured on both rungs, and every form of the table the same?

use crate::support::{arg, file, folder, names_in, raybudget};
use reports::Recorded;
use serde_json::Value;
use std::fs;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_quick_run_holds_every_frame_of_one_rung_against_the_other() {
    let dir = folder();
    let out = dir.path().join("out");
    let args = ["verify", "accuracy", "--quick", "--format", "json", "-o", arg(&out)];
    let found = raybudget(args).json();
    let rows = found["rows"].as_array().expect("rows");
    let ids: Vec<&str> = rows.iter().map(|row| row["id"].as_str().expect("an id")).collect();
    let mut expected = Vec::new();
    for scene in ["cornell", "teapot"] {
        for traversal in ["bvh-parent-link", "kd-backtrack"] {
            expected.extend(["adreno-540", "mali-g715"].map(|gpu| format!("{scene}/{traversal}/{gpu}")));
        }
    }
    assert_eq!(ids, expected);
    let limits = &found["limits"];
    for row in rows {
        let (ours, reference) = (&row["ours"], &row["reference"]);
        assert_eq!((&ours["rung"], &reference["rung"]), (&"replay".into(), &"timed".into()), "{row}");
        assert!(row["published"].is_null() && row["statement"].is_string(), "{row}");
        for rung in [ours, reference] {
            for figure in ["frame_time_ms", "dram_read_bytes", "dram_write_bytes", "run_s"] {
                assert!(number(&rung[figure]) > 0.0, "{figure} in {row}");
            }
        }
        assert!(row["deciding_bound"].as_str().is_some_and(|bound| !bound.is_empty()), "{row}");
        let error = number(&ours["frame_time_ms"]) / number(&reference["frame_time_ms"]) - 1.0;
        assert!((number(&row["error"]) - error).abs() < 1e-12, "{row}");
        let bytes = |rung: &Value| number(&rung["dram_read_bytes"]) + number(&rung["dram_write_bytes"]);
        let dram_error = bytes(ours) / bytes(reference) - 1.0;
        assert!((number(&row["dram_error"]) - dram_error).abs() < 1e-12, "{row}");
        let within = error.abs() <= number(&limits["worst"]) && dram_error.abs() <= number(&limits["dram"]);
        assert_eq!(row["outcome"], if within { "pass" } else { "fail" }, "{row}");
        assert_eq!(row["why"] == "", within, "{row}");
        // What every report says of its own error must be true here as well.
        let recorded = Recorded::embedded();
        assert!(error.abs() <= recorded.frame_time && dram_error.abs() <= recorded.dram_bytes, "{row}");
    }
    let summary = &found["summary"];
    let mean = rows.iter().map(|row| number(&row["error"]).abs()).sum::<f64>() / rows.len() as f64;
    let statements = summary["rows"].as_array().expect("rows");
    let statement = |id: &str| statements.iter().find(|row| row["id"] == id).expect("a statement");
    assert!((number(&statement("mean")["ours"]) - mean).abs() < 1e-12, "{summary}");
    for id in ["mean", "worst", "dram"] {
        let holds = number(&statement(id)["ours"]).abs() <= number(&limits[id]);
        assert_eq!(statement(id)["outcome"], if holds { "pass" } else { "fail" }, "{summary}");
    }
    for (groups, count) in [("by_gpu", 2), ("by_scene", 2), ("by_traversal", 2)] {
        assert_eq!(summary[groups].as_array().map(Vec::len), Some(count), "{summary}");
    }
    let run = &found["run"];
    assert_eq!((&run["traces"], &run["replays"], &run["image"]), (&4.into(), &16.into(), &"128x128".into()));

    let expected = [
        "accuracy.csv",
        "accuracy.json",
        "accuracy.txt",
        "errors.png",
        "errors.svg",
        "mean-errors.png",
        "mean-errors.svg",
    ];
    assert_eq!(names_in(&out), expected);
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a text file");
    assert_eq!(serde_json::from_str::<Value>(&read("accuracy.json")).expect("JSON"), found);
    let (csv, text) = (read("accuracy.csv"), read("accuracy.txt"));
    assert_eq!(csv.lines().count(), 1 + rows.len(), "{csv}");
    for row in rows {
        let time = &row["ours"]["frame_time_ms"];
        let id = row["id"].as_str().expect("an id");
        let in_csv = csv.lines().find(|line| line.starts_with(&format!("{id},"))).expect("a row");
        assert!(in_csv.contains(&time.to_string()), "{time} in {in_csv}");
    }
    assert!(text.contains("8 frames") && text.contains("cornell kd-backtrack"), "{text}");
    for name in ["errors", "mean-errors"] {
        assert!(read(&format!("{name}.svg")).starts_with("<svg "), "{name}");
        assert!(fs::read(out.join(format!("{name}.png"))).expect("a file").starts_with(b"\x89PNG"), "{name}");
    }
}

#[test]
fn what_is_given_replaces_the_defaults_and_threads_change_no_figure() {
    let frames = |threads: &str| {
        let args = ["verify", "accuracy", "--quick", "--scene", "cornell", "--gpu", "mali-g78,adreno-640"];
        let more = ["--traversal", "kd-push-down", "--size", "40x36", "--format", "csv"];
        let csv = raybudget(args.into_iter().chain(more).chain(["--threads", threads])).ok();
        let cells = |line: &str| line.split(',').take(12).map(str::to_owned).collect::<Vec<_>>();
        csv.lines().map(cells).collect::<Vec<_>>()
    };
    let one = frames("1");
    assert_eq!(one.len(), 3, "{one:?}");
    assert_eq!(one[1][0], "cornell/kd-push-down/mali-g78");
    assert_eq!(one[2][0], "cornell/kd-push-down/adreno-640");
    assert_eq!(frames("3"), one);
}

#[test]
fn what_there_is_not_is_refused_before_any_work_and_nothing_is_written() {
    let dir = folder();
    let out = dir.path().join("out");
    let broken = file(&dir, "broken.toml", "[identity]\nname = 3\n");
    for (args, expected) in [
        (&["--scene", "cornel"][..], "cornel"),
        (&["--scene", "cornell", "--scene", "atriun"], "atriun"),
        (&["--gpu", "adreno-541"], "--gpu adreno-541"),
        (&["--gpu", arg(&broken)], "broken.toml"),
        (
            &["--traversal", "kd-parent-link"],
            "--traversal kd-parent-link: no such one; use one of: bvh-stack",
        ),
        (&["--size", "0x4"], "--size 0x4"),
    ] {
        let message = raybudget(["verify", "accuracy", "-o", arg(&out)].iter().chain(args)).refused();
        assert!(message.contains(expected), "{args:?}: {message}");
        assert!(!out.exists(), "{args:?}");
    }
}
