//! Does the JSON form keep to its published schema, and does the schema refuse what is not a report?

mod common;

use common::report;
use reports::{Report, csv_table, json, text};
use serde_json::{Value as Json, json};

fn validator() -> jsonschema::Validator {
    let schema: Json = serde_json::from_str(json::SCHEMA_TEXT).expect("the schema is JSON");
    jsonschema::validator_for(&schema).expect("the schema is a JSON Schema")
}

fn as_json(report: &Report) -> Json {
    serde_json::from_str(&json::write(report)).expect("a report is JSON")
}

#[test]
fn a_report_keeps_to_the_published_schema() {
    let errors: Vec<String> =
        validator().iter_errors(&as_json(&report())).map(|error| error.to_string()).collect();
    assert_eq!(errors, Vec::<String>::new());
}

#[test]
fn the_schema_refuses_what_is_not_a_report() {
    let validator = validator();
    let good = as_json(&report());
    type Break = fn(&mut Json);
    let breaks: [(&str, Break); 12] = [
        ("another schema", |report| report["schema"] = json!(2)),
        ("a missing part", |report| drop(report.as_object_mut().expect("an object").remove("counters"))),
        ("a missing input", |report| {
            drop(report["inputs"].as_object_mut().expect("an object").remove("traversal"));
        }),
        ("no figure and no reason", |report| report["counters"]["rays"]["value"] = Json::Null),
        ("a figure and a reason", |report| report["counters"]["rays"]["reason"] = json!("why")),
        ("a figure as text", |report| report["counters"]["rays"]["value"] = json!("NaN")),
        ("an unknown rung", |report| report["counters"]["rays"]["from"] = json!("guess")),
        ("a short hash", |report| report["inputs"]["hashes"]["scene"] = json!("0123")),
        ("a part above 1", |report| report["run"]["sampled_fraction"] = json!(1.5)),
        ("an unknown boundary", |report| report["energy"]["causes"][0]["boundary"] = json!("some")),
        ("traffic without a level's bytes", |report| {
            let level = report["traffic"][0]["levels"][0].as_object_mut().expect("an object");
            level.remove("bytes");
        }),
        ("energy from nowhere", |report| report["energy"]["causes"][1]["domain"] = json!("sun")),
    ];
    assert!(validator.is_valid(&good));
    for (what, break_it) in breaks {
        let mut bad = good.clone();
        break_it(&mut bad);
        assert!(!validator.is_valid(&bad), "{what} passed");
    }
}

#[test]
fn reading_gives_back_what_was_written() {
    let report = report();
    assert_eq!(json::read(&json::write(&report), "r.json"), Ok(report));
}

#[test]
fn fields_of_later_versions_are_passed_over() {
    let mut later = as_json(&report());
    later["weather"] = json!("sunny");
    assert_eq!(json::read(&later.to_string(), "r.json"), Ok(report()));
}

#[test]
fn a_report_that_is_none_is_refused_with_file_and_line() {
    let whole = json::write(&report());
    let refused = |text: &str| json::read(text, "r.json").expect_err("not a report").to_string();
    assert!(refused("").starts_with("r.json"), "{}", refused(""));
    let torn = refused(&whole[..whole.len() / 2]);
    assert!(torn.starts_with("r.json:") && torn.contains("raybudget profile"), "{torn}");
    let newer = refused(&whole.replacen("\"schema\": 1", "\"schema\": 2", 1));
    assert!(newer.contains("schema 2, expected 1"), "{newer}");
    let twice = whole.replacen("\"rays\"", "\"frame_time_ms\"", 1);
    assert!(refused(&twice).contains("twice"), "{}", refused(&twice));
}

#[test]
fn the_text_tells_causes_of_energy_the_largest_first_with_boundary_and_tag() {
    let text = text::write(&report(), text::Style::Plain);
    let from = text
        .find("What the energy is made of (10nm, 0.800 V of its process, 50 degrees Celsius)")
        .expect("a table");
    let lines: Vec<Vec<&str>> =
        text[from..].lines().skip(2).take(2).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines[0].join(" "), "DRAM: reads and writes 4.500 mJ 75.0 % DRAM whole path estimate");
    assert_eq!(lines[1].join(" "), "ALU operations 1.500 mJ 25.0 % GPU unit estimate");
    let without = text::write(&Report { energy: None, ..report() }, text::Style::Plain);
    assert!(!without.contains("What the energy"));
}

#[test]
fn an_absent_counter_keeps_its_reason_in_every_form() {
    let report = report();
    assert!(text::write(&report, text::Style::Plain).contains("Texture Memory Read: no texture, \"none\""));
    assert!(csv_table::write(&report).contains("\"no texture, \"\"none\"\"\""));
    let json = as_json(&report);
    assert_eq!(json["counters"]["texture_memory_read_bytes"]["value"], Json::Null);
    assert_eq!(json["counters"]["texture_memory_read_bytes"]["reason"], "no texture, \"none\"");
}

#[test]
fn the_csv_has_one_row_per_counter_and_place_and_keeps_every_digit() {
    let table = csv_table::write(&report());
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows[0], csv_table::COLUMNS.join(","));
    assert_eq!(rows.len(), 1 + 4 + 4);
    assert_eq!(rows[2], "rays,Rays,,9007199254740993,rays,,,replay,");
    assert_eq!(rows[8], "l2_miss_ratio,L2 Miss Ratio,primary rays,0.15,ratio,0.1,0.2,replay,");
}

#[test]
fn plain_text_holds_no_escapes_and_bold_text_is_the_same_otherwise() {
    let plain = text::write(&report(), text::Style::Plain);
    let bold = text::write(&report(), text::Style::Ansi);
    assert!(!plain.contains('\x1b') && bold.contains('\x1b'));
    assert_eq!(bold.replace("\x1b[1m", "").replace("\x1b[0m", ""), plain);
}
