//! `raybudget profile --sustained` and `raybudget verify thermal`: what a phone makes of a frame rate.

use crate::support::{REPORT_FILES, SMALL, arg, file, folder, names_in, raybudget, without_run};
use serde_json::Value;
use std::fs;

const SCHEMA: &str = include_str!("../../reports/schema/report-1.schema.json");
const PHONE: &str = include_str!("../../configs/thermal/phone.toml");

fn profile(more: &[&str]) -> crate::support::Ran {
    raybudget(["profile", "cornell"].iter().chain(&SMALL).chain(more))
}

#[test]
fn a_load_says_what_is_sustained_and_where_the_heat_went() {
    let dir = folder();
    let out = dir.path().join("out");
    let report = profile(&["--sustained", "10min", "--format", "json", "-o", arg(&out)]).json();
    let schema: Value = serde_json::from_str(SCHEMA).expect("JSON");
    jsonschema::validate(&schema, &report).expect("a report as the schema has it");
    let sustained = &report["sustained"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let (peak, rate) = (number(&sustained["peak_fps"]), number(&sustained["sustained_fps"]));
    assert!(rate > 0.0 && rate <= peak * (1.0 + 1e-9), "{peak} {rate}");
    // The highest clock is the GPU's own, so its frame is the one that was profiled.
    let points = sustained["operating_points"].as_array().expect("points");
    let fps = number(&report["counters"]["fps"]["value"]);
    assert!((number(&points[0]["fps"]) / fps - 1.0).abs() < 1e-12 && (peak / fps - 1.0).abs() < 1e-12);
    let power: f64 = ["gpu_w", "dram_w", "leakage_w"].iter().map(|figure| number(&points[0][*figure])).sum();
    assert!((power * 1e3 / number(&report["counters"]["power_mw"]["value"]) - 1.0).abs() < 1e-9, "{power} W");
    assert_eq!(
        (&points[0]["volts"], &points[0]["leakage_celsius"]),
        (&report["energy"]["volts"], &report["energy"]["celsius"])
    );
    assert_eq!(points.len(), 7);
    for pair in points.windows(2) {
        for figure in ["mhz", "volts", "fps", "gpu_w", "leakage_w"] {
            assert!(number(&pair[1][figure]) < number(&pair[0][figure]), "{figure} in {pair:?}");
        }
    }
    let heat = &sustained["heat"];
    let balance = number(&heat["in_j"]) - number(&heat["stored_j"]) - number(&heat["to_air_j"]);
    assert!(balance.abs() <= 1e-6 * number(&heat["in_j"]), "{heat}");
    // The built-in phone's charge, of which ten minutes take a sixth of what an hour would.
    let battery = &sustained["battery"];
    let charge_j = 3600.0 * number(&battery["watt_hours"]);
    assert!((number(&battery["used"]) * charge_j / number(&heat["in_j"]) - 1.0).abs() < 1e-9, "{battery}");
    assert!(
        (number(&battery["lasts_hours"]) * number(&battery["used"]) * 6.0 - 1.0).abs() < 1e-9,
        "{battery}"
    );
    let minutes = sustained["minutes"].as_array().expect("minutes");
    let joules: f64 = minutes.iter().map(|minute| number(&minute["energy_j"])).sum();
    assert!((joules / number(&heat["in_j"]) - 1.0).abs() < 1e-9 && minutes.len() == 10);

    let mut expected: Vec<String> = REPORT_FILES.iter().map(|name| (*name).to_owned()).collect();
    expected.extend(["sustained.csv", "sustained.png", "sustained.svg"].map(str::to_owned));
    expected.sort();
    assert_eq!(names_in(&out), expected);
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a text file");
    assert_eq!(read("sustained.csv").lines().count(), 602);
    assert!(read("sustained.csv").starts_with("seconds,mhz,fps,power_w,frames,energy_j,gpu_celsius"));
    let chart = read("sustained.svg");
    for label in [
        "frame rate, frames per second",
        "clock of the GPU, MHz",
        "temperature, degrees Celsius",
        "time, minutes",
    ] {
        assert!(chart.contains(label), "{label}");
    }
    assert!(read("report.txt").contains("frames per second at first"));
}

#[test]
fn without_the_option_nothing_is_said_and_with_it_nothing_else_changes() {
    let plain = without_run(&profile(&["--format", "json"]).json());
    assert!(plain.get("sustained").is_none());
    let asked = |threads| {
        without_run(&profile(&["--sustained", "90s", "--threads", threads, "--format", "json"]).json())
    };
    let loaded = asked("1");
    assert_eq!(loaded, asked("2"));
    assert_eq!(plain["counters"], loaded["counters"]);
    assert_eq!(loaded["sustained"]["minutes"].as_array().map(Vec::len), Some(2));
}

#[test]
fn a_phone_of_paper_is_slowed_and_one_of_lead_is_not() {
    let dir = folder();
    let phone = |name: &str, from: &str, to: &str| {
        assert!(PHONE.contains(from), "{from}");
        file(&dir, name, PHONE.replacen(from, to, 1))
    };
    let paper = phone("paper.toml", "to_ambient = { value = 0.261", "to_ambient = { value = 0.05");
    let lead = phone("lead.toml", "to_ambient = { value = 0.261", "to_ambient = { value = 1000");
    let stability = |phone: &std::path::Path| {
        let report = profile(&["--sustained", "1440min", "--phone", arg(phone), "--format", "json"]).json();
        report["sustained"]["stability"].as_f64().expect("a number")
    };
    assert!(stability(&paper) < 0.9, "{}", stability(&paper));
    assert_eq!(stability(&lead), 1.0);
}

#[test]
fn a_trip_of_the_phone_does_not_change_what_leaks() {
    let dir = folder();
    let from = "celsius = { value = 95";
    assert!(PHONE.contains(from));
    let cooler = file(&dir, "cooler.toml", PHONE.replacen(from, "celsius = { value = 50", 1));
    let points = |more: &[&str]| {
        let asked = [&["--sustained", "10s", "--format", "json"], more].concat();
        let report = profile(&asked).json();
        let mut points = report["sustained"]["operating_points"].as_array().expect("points").clone();
        points.iter_mut().for_each(|point| point["seconds"] = Value::Null);
        points
    };
    assert_eq!(points(&[]), points(&["--phone", arg(&cooler)]));
}

#[test]
fn what_cannot_be_followed_is_refused_with_a_remedy() {
    let dir = folder();
    let refused = |more: &[&str]| profile(more).refused();
    assert!(refused(&["--sustained", "long"]).contains("such as 10min or 90s"));
    assert!(refused(&["--sustained", "2000min"]).contains("up to a day"));
    for unit_is_unknown in ["24h", "1ns"] {
        assert!(refused(&["--sustained", unit_is_unknown]).contains("one of ms, s and min"));
    }
    // Before the scene is looked for.
    let figure = PHONE.lines().find(|line| line.starts_with("polling_passive_ms")).expect("a sensor");
    let often = "polling_passive_ms = { value = 1, source = \"a test\", tag = \"estimate\" }";
    let restless = file(&dir, "restless.toml", PHONE.replacen(figure, often, 1));
    let asked = ["profile", "nowhere", "--sustained", "1440min", "--phone", arg(&restless)];
    let message = raybudget(asked.iter()).refused();
    assert!(
        message.contains("--sustained 1440min") && message.contains("read sensors less often"),
        "{message}"
    );
    assert!(refused(&["--sustained", "10min", "--sample", "10%"]).contains("leave out --sample"));
    let message = refused(&["--sustained", "10min", "--gpu", "mali-g71"]);
    assert!(message.contains("mali-g71") && message.contains("[[operating_point]]"), "{message}");
    let message = refused(&["--sustained", "10min", "--set", "clock.mhz=100"]);
    assert!(message.contains("raise clock.mhz"), "{message}");
    const GPU: &str = include_str!("../../configs/gpus/adreno-540.toml");
    assert!(GPU.contains("\"10nm\""));
    let gpu = file(&dir, "my-gpu.toml", GPU.replacen("\"10nm\"", "\"11nm\"", 1));
    let message = refused(&["--gpu", arg(&gpu)]);
    assert!(message.contains("my-gpu.toml") && message.contains("energy.process: is '11nm'"), "{message}");
    assert!(refused(&["--phone", "phone.toml"]).contains("--sustained"));
    let broken = file(&dir, "phone.toml", PHONE.replacen("[heat]", "[heat]\ncpu = \"gpu\"", 1));
    let message = refused(&["--sustained", "10min", "--phone", arg(&broken)]);
    assert!(message.contains("phone.toml:") && message.contains("cpu"), "{message}");
}

#[test]
fn a_lower_clock_of_the_gpu_takes_the_points_above_it_away() {
    let report = profile(&["--sustained", "10s", "--set", "clock.mhz=414", "--format", "json"]).json();
    let points = report["sustained"]["operating_points"].as_array().expect("points");
    assert_eq!(
        points.iter().map(|point| point["mhz"].as_f64()).collect::<Vec<_>>(),
        [414.0, 342.0, 257.0].map(Some)
    );
}

#[test]
fn a_clock_between_operating_points_is_said_not_to_be_the_first_of_them() {
    let note = "the highest operating point has";
    let text = |clock: &str| {
        profile(&["--sustained", "10s", "--set", clock, "--format", "json"]).json()["assumptions"].to_string()
    };
    let between = text("clock.mhz=400");
    assert!(between.contains(&format!("{note} 342 MHz, not the 400 MHz")), "{between}");
    assert!(!text("clock.mhz=342").contains(note));
}

#[test]
fn the_temperatures_are_held_against_closed_forms() {
    let dir = folder();
    let out = dir.path().join("out");
    let ran = raybudget(["verify", "thermal", "--quick", "--format", "json", "-o", arg(&out)]);
    let found: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let rows = found["rows"].as_array().expect("rows");
    // No limit is on a time, so this holds on any machine.
    assert!(rows.iter().all(|row| row["outcome"] == "pass"), "{}", ran.stdout);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    for id in ["thermal/exact", "thermal/balance/governed", "thermal/chatter", "thermal/ten-minutes"] {
        assert!(rows.iter().any(|row| row["id"] == id), "{id}");
    }
    let points = found["run"]["work_precision"]["points"].as_array().expect("points");
    assert!(points.iter().any(|point| point["error_k"].is_null()), "explicit steps can be too long");
    let files = names_in(&out);
    for name in ["thermal.json", "work-precision.csv", "work-precision.svg", "step-sizes.png"] {
        assert!(files.contains(&name.to_owned()), "{name} in {files:?}");
    }
}
