//! Does every combination of GPU, built-in scene, traversal and layout give a whole report?

use assert_cmd::Command;
use serde_json::Value;

fn profile(scene: &str, traversal: tracer::Traversal, layout: &str, gpu: &str) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_raybudget"))
        .args(["profile", scene, "--size", "40x24", "--gpu", gpu, "--layout", layout, "--format", "json"])
        .args(["--accel", traversal.accel().name(), "--traversal", traversal.name()])
        .output()
        .expect("the program starts");
    let place = format!("{scene}, {traversal:?}, {layout}, {gpu}");
    assert!(output.status.success(), "{place}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{place}: {error}"))
}

#[test]
fn every_scene_runs_through_every_traversal_and_every_count_is_a_number_or_a_reason() {
    for scene in scenes::BUILTINS {
        for traversal in tracer::Traversal::ALL {
            for gpu in gpumodel::GPUS {
                let report = profile(scene.name, traversal, "padded", gpu.name);
                let counters = report["counters"].as_object().expect("counters by id");
                assert_eq!(counters.len(), gpumodel::COUNTERS.len());
                for (id, counter) in counters {
                    let place = format!("{id} of {} with {traversal:?}", scene.name);
                    match counter["value"].as_f64() {
                        Some(value) => assert!(value.is_finite() && value >= 0.0, "{place}: {value}"),
                        None => assert!(
                            counter["reason"].as_str().is_some_and(|reason| !reason.is_empty()),
                            "{place}"
                        ),
                    }
                }
                assert!(counters["node_fetches"]["value"].as_u64() > Some(0), "{}", scene.name);
                assert!(counters["frame_time_ms"]["value"].as_f64() > Some(0.0), "{}", scene.name);
            }
        }
    }
}

#[test]
fn every_primitive_layout_runs_and_only_moves_bytes() {
    let counters =
        |layout| profile("figure", tracer::Traversal::BvhStack, layout, "adreno-540")["counters"].clone();
    let padded = counters("padded");
    for layout in ["compact", "split"] {
        let other = counters(layout);
        for id in ["node_fetches", "primitive_tests", "rays"] {
            assert_eq!(other[id]["value"], padded[id]["value"], "{id} with {layout}");
        }
        assert_ne!(other["dram_read_bytes"]["value"], padded["dram_read_bytes"]["value"], "{layout}");
    }
}
