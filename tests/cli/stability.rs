//! `raybudget verify stability`: is every form of the table the same, and is a triangle test chosen and named?

use crate::support::{SMALL, arg, folder, names_in, raybudget};
use serde_json::Value;
use std::fs;

#[test]
fn a_quick_run_tells_of_every_case_what_was_expected_and_what_came_out() {
    let dir = folder();
    let out = dir.path().join("out");
    let ran = raybudget(["verify", "stability", "--quick", "--format", "json", "-o", arg(&out)]);
    let found: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let rows = found["rows"].as_array().expect("rows");
    let fails = rows.iter().filter(|row| row["outcome"] == "fail").count();
    assert_eq!(ran.code, Some(i32::from(fails > 0)), "{}", ran.stderr);
    let mut ids: Vec<&str> = Vec::new();
    for row in rows {
        let id = row["id"].as_str().expect("an id");
        assert!(!ids.contains(&id), "{id} is there twice");
        ids.push(id);
        for text in ["statement", "unit"] {
            assert!(row[text].as_str().is_some_and(|text| !text.is_empty()), "{text} in {row}");
        }
        assert!(row["published"].is_null() && row["ours"].is_number() && row["why"].is_string(), "{row}");
        let beyond = row["error"].as_f64().expect("a number");
        assert_eq!(row["outcome"], if beyond <= 0.0 { "pass" } else { "fail" }, "{row}");
        let expected = row["expected"].as_object().expect("a limit");
        assert_eq!(expected.len(), 1, "{row}");
    }
    for id in
        ["leaks/embree-sphere/watertight", "solver/saturation", "frames/rescaled", "all/panics", "all/nan"]
    {
        assert!(ids.contains(&id), "{id} in {ids:?}");
    }
    assert_eq!(found["run"]["quick"], true);

    assert_eq!(names_in(&out), ["stability.csv", "stability.json", "stability.md", "stability.txt"]);
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("a text file");
    assert_eq!(serde_json::from_str::<Value>(&read("stability.json")).expect("JSON")["rows"], found["rows"]);
    assert_eq!(read("stability.csv").lines().count(), rows.len() + 1);
    for name in ["stability.csv", "stability.md", "stability.txt"] {
        let text = read(name);
        assert!(ids.iter().all(|id| text.contains(id)), "{name}");
    }
}

#[test]
fn a_triangle_test_is_chosen_by_name_and_the_report_says_what_its_costs_are() {
    let profile = |more: &[&str]| {
        raybudget(["profile", "cornell", "--format", "json"].iter().chain(&SMALL).chain(more)).json()
    };
    let notes = |report: &Value| report["notes"].to_string();
    let (default, chosen) = (profile(&[]), profile(&["--triangle-test", "moeller-trumbore"]));
    assert_eq!(default["counters"], chosen["counters"]);
    assert!(!notes(&default).contains("watertight"), "{}", notes(&default));
    let watertight = profile(&["--triangle-test", "watertight"]);
    let said = notes(&watertight);
    assert!(said.contains("watertight") && said.contains("costs of Moeller-Trumbore"), "{said}");
    let message = raybudget(["profile", "cornell", "--triangle-test", "sphere"]).refused();
    assert!(message.contains("moeller-trumbore, watertight"), "{message}");
}
