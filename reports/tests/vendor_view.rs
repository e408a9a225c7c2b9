//! Is a profiler's view made of the report's counters, and does it survive its JSON form?

mod common;

use common::report;
use gpumodel::{Family, Gpu};
use reports::vendor::{Profiler, VendorView};
use reports::{Report, Value, json, text};

fn with_view(gpu: &str) -> Report {
    let gpu = Gpu::builtin(gpu).expect("it is built in").expect("it is sound");
    let profiler = Profiler::of(gpu.identity.family).expect("sound").expect("it has one");
    let mut report = report();
    report.vendor = Some(VendorView::new(&profiler, &report, &gpu));
    report
}

#[test]
fn a_view_keeps_to_the_schema_and_is_read_back_as_it_was() {
    let schema = serde_json::from_str(json::SCHEMA_TEXT).expect("the schema is JSON");
    let schema = jsonschema::validator_for(&schema).expect("the schema is a JSON Schema");
    for gpu in ["adreno-540", "mali-g715"] {
        let report = with_view(gpu);
        let written = json::write(&report);
        let as_json = serde_json::from_str(&written).expect("JSON");
        let errors: Vec<String> = schema.iter_errors(&as_json).map(|error| error.to_string()).collect();
        assert_eq!(errors, Vec::<String>::new());
        assert_eq!(json::read(&written, "r.json"), Ok(report));
    }
}

#[test]
fn a_counter_with_a_figure_and_a_reason_or_neither_is_refused() {
    let written = json::write(&with_view("adreno-540"));
    let mut broken: serde_json::Value = serde_json::from_str(&written).expect("JSON");
    let clocks = &mut broken["vendor"]["counters"]["Clocks / Second"];
    assert!(clocks["value"].is_number());
    clocks["reason"] = "why".into();
    assert!(json::read(&broken.to_string(), "r.json").is_err());
    let clocks = &mut broken["vendor"]["counters"]["Clocks / Second"];
    clocks.as_object_mut().expect("a counter").remove("reason");
    clocks["value"] = serde_json::Value::Null;
    assert!(json::read(&broken.to_string(), "r.json").is_err());
}

#[test]
fn what_the_report_does_not_have_is_absent_and_says_what_is_missing() {
    let report = with_view("mali-g715");
    let view = report.vendor.as_ref().expect("a view");
    for (name, counter) in &view.counters {
        match &counter.value {
            Value::Absent { reason } => assert!(!reason.is_empty(), "{name}"),
            value => assert!(value.as_f64().is_some_and(f64::is_finite), "{name}"),
        }
    }
    assert_eq!(view.passes.len(), report.passes.len());
    assert_eq!(Profiler::of(Family::Other), Ok(None));
}

#[test]
fn a_view_of_a_profiler_that_is_not_known_leaves_our_names() {
    let mut report = with_view("mali-g715");
    let known = text::write(&report, text::Style::Plain);
    report.vendor.as_mut().expect("a view").profiler = "Another".to_owned();
    let unknown = text::write(&report, text::Style::Plain);
    report.vendor = None;
    assert_eq!(unknown, text::write(&report, text::Style::Plain));
    assert_ne!(known, unknown);
}
