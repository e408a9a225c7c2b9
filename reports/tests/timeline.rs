//! Does the time line hold what the report says, pass after pass, in the form of trace events?

mod common;

use common::report;
use reports::{Counter, Counters, Fidelity, Pass, Report, Value, timeline};
use serde_json::Value as Json;

fn counter(id: &str, value: Value, unit: &str) -> (String, Counter) {
    (id.to_owned(), Counter { value, unit: unit.to_owned(), ci95: None, from: Fidelity::Replay })
}

/// A pass of so many milliseconds that reads so many bytes.
fn pass(name: &str, ms: f64, bytes: Option<u64>) -> Pass {
    let absent = || Value::Absent { reason: "nothing is read".to_owned() };
    let counters: Counters = [
        counter("frame_time_ms", Value::Real(ms), "ms"),
        counter("dram_read_bytes", bytes.map_or_else(absent, Value::Count), "B"),
        counter("occupancy", Value::Real(0.25), "ratio"),
        counter("simt_efficiency", absent(), "ratio"),
    ]
    .into_iter()
    .collect();
    Pass { name: name.to_owned(), counters }
}

fn with_passes(passes: Vec<Pass>) -> Report {
    Report { passes, ..report() }
}

fn events(text: &str) -> Vec<Json> {
    let file: Json = serde_json::from_str(text).expect("JSON");
    file["traceEvents"].as_array().expect("a list").clone()
}

fn of_phase<'a>(events: &'a [Json], phase: &str) -> Vec<&'a Json> {
    events.iter().filter(|event| event["ph"] == phase).collect()
}

#[test]
fn passes_follow_one_another_to_the_nanosecond_and_make_up_the_frame() {
    let times = [0.1, 1.0 / 3.0, 44.080_123_4, 1e-7, 2e-6];
    let report = with_passes(times.iter().map(|&ms| pass("p", ms, None)).collect());
    let events = events(&timeline::write(&[("frame", &report)]));
    let slices = of_phase(&events, "X");
    let (frame, passes): (Vec<&Json>, Vec<&Json>) =
        slices.into_iter().partition(|slice| slice["name"] == "frame");
    // One of a tenth of a nanosecond is not seen.
    assert_eq!((frame.len(), passes.len()), (1, 4));
    let nanoseconds = |slice: &Json, key: &str| {
        let microseconds = slice[key].as_f64().expect("a number");
        let whole = (microseconds * 1e3).round();
        assert!((microseconds * 1e3 - whole).abs() < 1e-3, "{microseconds}");
        whole
    };
    let mut end = 0.0;
    for slice in &passes {
        assert_eq!(nanoseconds(slice, "ts"), end);
        end += nanoseconds(slice, "dur");
    }
    assert_eq!((nanoseconds(frame[0], "ts"), nanoseconds(frame[0], "dur")), (0.0, end));
    assert_eq!(end, (times.iter().sum::<f64>() * 1e6).round());
    assert_ne!(frame[0]["tid"], passes[0]["tid"]);
}

#[test]
fn counter_tracks_hold_the_figures_of_the_pass_and_none_of_the_one_before() {
    let report = with_passes(vec![
        pass("a", 2.0, Some(6_000_000)),
        pass("b", 4.0, None),
        pass("c", 1.0, Some(1_000_000)),
    ]);
    let events = events(&timeline::write(&[("frame", &report)]));
    let of_track = |name: &str, unit: &str| -> Vec<(f64, f64)> {
        let of = of_phase(&events, "C").into_iter().filter(|event| event["name"] == name);
        of.map(|event| {
            (event["ts"].as_f64().expect("a time"), event["args"][unit].as_f64().expect("a figure"))
        })
        .collect()
    };
    assert_eq!(of_track("Read Total", "GB/s"), [(0.0, 3.0), (2000.0, 0.0), (6000.0, 1.0)]);
    assert_eq!(of_track("Wave Context Occupancy", "%"), [(0.0, 25.0), (2000.0, 25.0), (6000.0, 25.0)]);
    assert_eq!(of_track("SIMT Efficiency", "%"), [], "no pass has it");
    let slice = of_phase(&events, "X")[0];
    assert_eq!(slice["args"]["Read Total, B"], 6_000_000);
    assert_eq!(slice["args"]["Frame Time, ms"], 2.0);
    assert!(slice["args"].get("SIMT Efficiency, ratio").is_none());
}

#[test]
fn every_event_has_what_its_phase_needs() {
    let events = events(&timeline::write(&[("frame", &report())]));
    for event in &events {
        assert!(event["name"].is_string() && event["pid"].is_u64() && event["args"].is_object(), "{event}");
        match event["ph"].as_str().expect("a phase") {
            "M" => assert!(event["args"]["name"].is_string()),
            "X" => assert!(event["tid"].is_u64() && event["ts"].is_number() && event["dur"].is_number()),
            "C" => assert!(
                event["ts"].is_number()
                    && event["args"].as_object().expect("series").values().all(Json::is_number)
            ),
            other => panic!("a phase {other}"),
        }
    }
    assert_eq!(of_phase(&events, "X").len(), 2);
}

#[test]
fn names_are_escaped_and_the_cost_of_the_run_leaves_no_trace() {
    let mut report = with_passes(vec![pass("a \"pass\"\n\\", 1.0, None)]);
    report.inputs.scene = "a </script> \u{1} scene".to_owned();
    let text = timeline::write(&[("frame", &report)]);
    let events = events(&text);
    assert_eq!(of_phase(&events, "X")[0]["name"], "a \"pass\"\n\\");
    assert_eq!(events[0]["args"]["name"], "a </script> \u{1} scene on adreno-540");
    report.run.wall_s = 77.0;
    report.run.threads = 1;
    assert_eq!(timeline::write(&[("frame", &report)]), text);
}

#[test]
fn two_eyes_follow_one_another() {
    let eye = |ms| with_passes(vec![pass("primary rays", ms, Some(1))]);
    let (left, right) = (eye(3.0), eye(2.0));
    let events = events(&timeline::write(&[("left eye", &left), ("right eye", &right)]));
    let slices: Vec<_> = of_phase(&events, "X")
        .into_iter()
        .map(|slice| (slice["name"].as_str(), slice["ts"].as_f64(), slice["dur"].as_f64()))
        .collect();
    assert_eq!(
        slices,
        [
            (Some("primary rays"), Some(0.0), Some(3000.0)),
            (Some("left eye"), Some(0.0), Some(3000.0)),
            (Some("primary rays"), Some(3000.0), Some(2000.0)),
            (Some("right eye"), Some(3000.0), Some(2000.0)),
        ]
    );
}
