//! Samples of frames: goals, intervals, and what is refused.

use crate::support::{arg, folder, raybudget};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn trace(folder: &Path) -> PathBuf {
    let trace = folder.join("t.rbt");
    raybudget(["trace", "atrium", "--size", "768x768", "-o", arg(&trace)]).ok();
    trace
}

fn replay(trace: &Path, options: &[&str]) -> Value {
    raybudget(["replay", arg(trace), "--format", "json"].iter().chain(options)).json()
}

fn figure(report: &Value, id: &str) -> f64 {
    report["counters"][id]["value"].as_f64().expect("a figure")
}

fn interval(report: &Value, id: &str) -> [f64; 2] {
    let ends = report["counters"][id]["ci95"].as_array().expect("an interval");
    [0, 1].map(|end| ends[end].as_f64().expect("a number"))
}

#[test]
fn samples_keep_their_word_and_everything_is_replayed_where_they_cannot() {
    let dir = folder();
    let trace = trace(dir.path());
    let exact = replay(&trace, &[]);
    let off = |report: &Value, id: &str| (figure(report, id) / figure(&exact, id) - 1.0).abs();

    let sampled = replay(&trace, &["--sample", "25%", "--seed", "3"]);
    assert_eq!(sampled["run"]["fidelity"], "sampled");
    assert!(sampled["run"]["sampled_fraction"].as_f64().is_some_and(|part| (0.1..0.35).contains(&part)));
    assert_eq!(sampled["inputs"]["seed"], 3);
    for id in ["frame_time_ms", "dram_read_bytes", "alu_operations", "node_fetches", "energy_mj", "power_mw"]
    {
        let [low, high] = interval(&sampled, id);
        assert!(low < high && (low..=high).contains(&figure(&sampled, id)), "{id}");
    }
    assert!(off(&sampled, "frame_time_ms") < 0.1);
    let [low, high] = interval(&sampled, "fragments");
    assert_eq!((low, high), (768.0 * 768.0, 768.0 * 768.0));
    assert_eq!(exact["counters"]["frame_time_ms"]["ci95"], Value::Null);

    let within = replay(&trace, &["--within", "frame_time_ms=20%"]);
    assert_eq!(within["run"]["fidelity"], "sampled");
    let [low, high] = interval(&within, "frame_time_ms");
    let time = figure(&within, "frame_time_ms");
    assert!(low >= 0.8 * time && high <= 1.2 * time, "{low} {time} {high}");

    let whole = replay(&trace, &["--within", "0.001%"]);
    assert_eq!(whole["run"]["fidelity"], "replay");
    assert_eq!(whole["counters"], exact["counters"]);
    let notes = whole["notes"].as_array().expect("notes");
    assert!(
        notes
            .iter()
            .any(|note| note.as_str().is_some_and(|note| note.starts_with("Every tile was replayed")))
    );

    let in_time = replay(&trace, &["--time-limit", "60s"]);
    assert_eq!(in_time["run"]["fidelity"], "replay", "there is time for all");
    let late = replay(&trace, &["--time-limit", "1ms"]);
    assert_eq!(late["run"]["fidelity"], "sampled");
    let notes = late["notes"].as_array().expect("notes");
    assert!(notes.iter().any(|note| note.as_str().is_some_and(|note| note.contains("limit was too short"))));
}

#[test]
fn a_frame_that_is_traced_on_the_way_can_be_sampled_and_the_text_says_how_far_figures_may_be_off() {
    let sample = ["profile", "atrium", "--size", "768x768", "--fidelity", "sampled"];
    let text = raybudget(sample).ok();
    assert!(text.contains("frame        95 %"), "{text}");
    assert!(text.lines().any(|line| line.contains("Frame Time") && line.contains(" %  ")), "{text}");
    assert!(text.lines().any(|line| line.contains("Fragments") && line.contains("exact")), "{text}");
    let hybrid = raybudget(sample.iter().chain(&["--technique", "hybrid", "--format", "json"])).json();
    assert_eq!(hybrid["run"]["fidelity"], "replay", "geometry that is drawn is not sampled");
    let dir = folder();
    let out = dir.path().join("out");
    let report = raybudget(sample.iter().chain(&["--format", "json", "-o", arg(&out)])).json();
    let left_out = report["left_out"].as_array().expect("a list");
    assert!(left_out.iter().any(|entry| entry["what"] == "heat maps"));
    assert!(out.join("report.json").exists() && !out.join("node-fetches.png").exists());
}

#[test]
fn what_makes_no_sense_is_refused_with_the_remedy() {
    for (options, expected) in [
        (&["--within", "2"][..], "--within 2: expected a part of the whole above 0, such as 2% or 0.02"),
        (&["--within", "time=2%"], "there is no counter 'time'; see `raybudget list counters`"),
        (&["--sample", "0%"], "--sample 0%: expected a part of the whole"),
        (
            &["--time-limit", "5"],
            "--time-limit 5: expected a time above 0 with its unit, such as 1s or 500ms",
        ),
        (&["--seed", "5"], "add --sample, --within or --time-limit"),
        (&["--fidelity", "timed", "--within", "2%"], "leave out --sample, --within and --time-limit"),
        (&["--within", "2%", "--time-limit", "1s"], "cannot be used with"),
    ] {
        let error = raybudget(["profile", "cornell"].iter().chain(options)).refused();
        assert!(error.contains(expected), "{options:?}: {error}");
    }
    let error = raybudget(["compare", "cornell", "--vary", "layout", "--fidelity", "sampled"]).refused();
    assert!(error.contains("only profile, replay and whatif take samples"), "{error}");
}

#[test]
fn verify_accuracy_holds_samples_against_replays() {
    let dir = folder();
    let out = dir.path().join("out");
    let verify = ["verify", "accuracy", "--samples", "--quick", "--format", "json", "-o", arg(&out)];
    let found = raybudget(verify).json();
    assert_eq!(
        found["rows"].as_array().map(Vec::len),
        Some(16),
        "four counters and what one change does to them, each with errors and coverage"
    );
    let change = |row: &&Value| row["change"] == "layout split";
    assert_eq!(found["samples"].as_array().expect("samples").iter().filter(change).count(), 8);
    for row in found["samples"].as_array().expect("samples") {
        assert_eq!(row["errors"].as_array().map(Vec::len), Some(4));
        let errors = row["errors"].as_array().expect("errors").iter().filter_map(Value::as_f64);
        if row["counter"] == "frame_time_ms" {
            let most = if row["change"].is_null() { 0.2 } else { 0.002 };
            assert!(errors.map(f64::abs).fold(0.0, f64::max) < most, "{row}");
        }
    }
    let traced = ["verify", "accuracy", "--samples", "--quick", "--change", "ct-ci=1:1"];
    assert!(raybudget(traced).refused().contains("--change ct-ci: it changes what is traced"));
    for file in ["sampling.txt", "sampling.csv", "work-precision-frame_time_ms.svg"] {
        assert!(out.join(file).exists(), "{file}");
    }
}

/// The ends of the interval of a ratio.
fn ratio(variant: &Value, id: &str) -> [f64; 2] {
    let ends = variant["ratios_ci95"][id].as_array().unwrap_or_else(|| panic!("{id} has no interval"));
    [0, 1].map(|end| ends[end].as_f64().expect("a number"))
}

#[test]
fn what_changes_do_is_sampled_together_and_known_better_than_the_frame() {
    let dir = folder();
    let trace = trace(dir.path());
    let changes = ["--node-records", "child-boxes", "--node-order", "breadth-first"];
    let whatif = |options: &[&str]| {
        let given = ["whatif", arg(&trace), "--format", "json"];
        raybudget(given.iter().chain(&changes).chain(options)).json()
    };
    let variant = |whatif: &Value, label: &str| {
        let all = whatif["variants"].as_array().expect("variants");
        all.iter().find(|variant| variant["values"][0] == label).expect("the variant").clone()
    };
    let (exact, sampled) = (whatif(&[]), whatif(&["--sample", "25%", "--seed", "3"]));
    crate::compare::validator().validate(&sampled).expect("a comparison as the schema has it");
    assert!(
        variant(&exact, "node-records child-boxes")["ratios_ci95"].is_null(),
        "whole frames need no intervals"
    );
    let first = variant(&sampled, "unchanged");
    assert!(first["ratios_ci95"].is_null());
    for label in ["node-records child-boxes", "node-order breadth-first"] {
        let of = |whatif: &Value, id: &str| {
            figure(&variant(whatif, label)["report"], id)
                / figure(&variant(whatif, "unchanged")["report"], id)
        };
        for id in ["frame_time_ms", "dram_read_bytes", "energy_mj"] {
            let [low, high] = ratio(&variant(&sampled, label), id);
            assert!((low..=high).contains(&of(&sampled, id)), "{label} {id}");
            assert!(
                (low..=high).contains(&of(&exact, id)),
                "{label} {id}: {} not in {low}..{high}",
                of(&exact, id)
            );
            let [own_low, own_high] = interval(&first["report"], id);
            let own = (own_high - own_low) / figure(&first["report"], id);
            assert!(high - low < 0.5 * own, "{label} {id}: {low}..{high} beside {own}");
        }
        assert_eq!(ratio(&variant(&sampled, label), "fragments"), [1.0, 1.0]);
    }

    let within = whatif(&["--within", "frame_time_ms=3%"]);
    for label in ["node-records child-boxes", "node-order breadth-first"] {
        let [low, high] = ratio(&variant(&within, label), "frame_time_ms");
        assert!(high - low <= 0.06, "{label}: {low}..{high}");
    }
    let whole = whatif(&["--within", "0.001%"]);
    assert!(whole["remarks"][0].as_str().is_some_and(|remark| remark.starts_with("Every tile was replayed")));
    assert_eq!(
        variant(&whole, "node-records child-boxes")["report"]["counters"],
        variant(&exact, "node-records child-boxes")["report"]["counters"]
    );
}

#[test]
fn every_form_of_a_sampled_comparison_says_how_far_differences_may_be_off() {
    let dir = folder();
    let trace = trace(dir.path());
    let sampled = ["whatif", arg(&trace), "--sample", "25%"];
    let out = dir.path().join("out");
    let ran = raybudget(sampled.iter().chain(&["-o", arg(&out)]));
    assert!(
        ran.stderr.contains("left out technique hybrid: the geometry is drawn bin by bin"),
        "{}",
        ran.stderr
    );
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let text = ran.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains(" \u{b1}") && text.contains("intervals of 95 %, narrower than those of the"),
        "{text}"
    );
    assert!(text.contains("technique compute") && !text.contains("hybrid"), "{text}");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect("a file");
    for name in ["whatif.md", "whatif.html"] {
        assert!(read(name).contains(" \u{b1}"), "{name}");
    }
    let csv = read("whatif.csv");
    let mut rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heading = rows.next().expect("a heading");
    let place = |name: &str| heading.iter().position(|known| *known == name).expect("a column");
    let time = rows
        .find(|row| row[0] == "node-order breadth-first" && row[place("id")] == "frame_time_ms")
        .expect("a row");
    let number = |name: &str| time[place(name)].parse::<f64>().expect("a number");
    assert!(number("relative_low") < number("relative") && number("relative") < number("relative_high"));

    let on = |threads| raybudget(sampled.iter().chain(&["--threads", threads])).stdout;
    assert!(on("1") == on("3") && on("1").contains("unchanged"));

    let drawn = raybudget(sampled.iter().chain(&["--technique", "hybrid", "--format", "json"])).json();
    assert!(drawn["remarks"][0].as_str().is_some_and(|remark| remark.contains("the geometry is drawn")));
    let binned = raybudget(sampled.iter().chain(&["--binning", "sign"])).refused();
    assert!(binned.contains("leave out --sample, --within and --time-limit"), "{binned}");
    let seed = raybudget(["whatif", arg(&trace), "--seed", "3"]).refused();
    assert!(seed.contains("--seed: it draws a sample"), "{seed}");
}

#[test]
fn a_sample_that_misses_when_the_work_is_done_is_not_believed() {
    // Warps of an object before an empty background.
    let figure = ["profile", "figure", "--size", "1024x1024", "--gpu", "mali-g78", "--format", "json"];
    let run = |options: &[&str]| raybudget(figure.iter().chain(options)).json();
    let part = run(&["--sample", "28%"]);
    assert_eq!(part["run"]["fidelity"], "replay");
    let unseen = "the sample has not seen when most of the work is done";
    let told = |report: &Value| {
        let notes = report["notes"].as_array().expect("notes").clone();
        notes.iter().any(|note| note.as_str().is_some_and(|note| note.contains(unseen)))
    };
    assert!(told(&part), "{}", part["notes"]);
    let hurried = run(&["--time-limit", "1ms"]);
    assert_eq!(hurried["run"]["fidelity"], "sampled");
    assert!(told(&hurried), "{}", hurried["notes"]);
    assert_eq!(hurried["counters"]["dram_read_bytes"]["ci95"], Value::Null);
    assert!(hurried["run"]["within"]["why"].is_string(), "{}", hurried["run"]);
}
