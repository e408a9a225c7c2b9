//! Does every GPU, built-in scene, traversal, layout and technique give a whole report?

use assert_cmd::Command;
use serde_json::Value;

fn profile(scene: &str, traversal: tracer::Traversal, machine: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_raybudget"))
        .args(["profile", scene, "--size", "40x24", "--format", "json"])
        .args(["--accel", traversal.accel().name(), "--traversal", traversal.name()])
        .args(machine)
        .output()
        .expect("the program starts");
    let place = format!("{scene}, {traversal:?}, {machine:?}");
    assert!(output.status.success(), "{place}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{place}: {error}"))
}

/// Every count of the frame is a number or a reason, and the frame took work and time.
fn assert_whole(report: &Value, place: &str) {
    let counters = report["counters"].as_object().expect("counters by id");
    assert_eq!(counters.len(), gpumodel::COUNTERS.len());
    for (id, counter) in counters {
        match counter["value"].as_f64() {
            Some(value) => assert!(value.is_finite() && value >= 0.0, "{id} of {place}: {value}"),
            None => assert!(
                counter["reason"].as_str().is_some_and(|reason| !reason.is_empty()),
                "{id} of {place}"
            ),
        }
    }
    assert!(counters["node_fetches"]["value"].as_u64() > Some(0), "{place}");
    assert!(counters["frame_time_ms"]["value"].as_f64() > Some(0.0), "{place}");
}

/// The passes of a report, by name, in their order.
fn passes(report: &Value) -> Vec<&str> {
    let passes = report["passes"].as_array().expect("passes");
    passes.iter().map(|pass| pass["name"].as_str().expect("a name")).collect()
}

/// A counter of a pass; 0 where it is absent.
fn of_pass(report: &Value, name: &str, counter: &str) -> f64 {
    let passes = report["passes"].as_array().expect("passes");
    let pass = passes.iter().find(|pass| pass["name"] == name).expect("a pass of this name");
    pass["counters"][counter]["value"].as_f64().unwrap_or(0.0)
}

/// One GPU of each family beside the Adrenos.
const OTHER_FAMILIES: [&str; 2] = ["mali-g57", "vulkan-sim-mobile"];

/// Of scenes with more triangles, one traversal of each structure stands for all: each run builds it anew, a second or more.
const LARGE: usize = 300_000;

#[test]
fn scenes_run_through_every_traversal_and_every_count_is_a_number_or_a_reason() {
    for scene in scenes::BUILTINS {
        let mut built = Vec::new();
        for traversal in tracer::Traversal::ALL {
            let accel = traversal.accel().name();
            if scene.triangles > LARGE && built.contains(&accel) {
                continue;
            }
            built.push(accel);
            let report = profile(scene.name, traversal, &["--gpu", "adreno-540"]);
            assert_whole(&report, &format!("{}, {traversal:?}", scene.name));
        }
        for gpu in OTHER_FAMILIES {
            let report = profile(scene.name, tracer::Traversal::BvhStack, &["--gpu", gpu]);
            assert_whole(&report, &format!("{}, {gpu}", scene.name));
        }
    }
}

#[test]
fn every_gpu_runs_every_technique_and_the_default_scene() {
    for gpu in gpumodel::GPUS {
        let report = profile("atrium", tracer::Traversal::BvhStack, &["--gpu", gpu.name]);
        assert_whole(&report, gpu.name);
        for technique in [false, true].map(techniques).concat() {
            let machine = ["--gpu", gpu.name, "--technique", technique, "--force", "mirror"];
            let report = profile("cornell", tracer::Traversal::KdPushDown { short_stack: 0 }, &machine);
            assert_whole(&report, &format!("{}, {technique}", gpu.name));
        }
    }
}

#[test]
fn buffers_can_take_the_way_of_images_on_adrenos_whose_driver_may_do_so() {
    for (gpu, path) in [
        ("adreno-630", "[\"tp_l1\", \"uche\"]"),
        ("adreno-640", "[\"tp_l1\", \"uche\", \"slc\"]"),
        ("adreno-740", "[\"tp_l1\", \"cluster\", \"uche\", \"slc\"]"),
    ] {
        let set = format!("paths.ssbo={path}");
        let as_images = profile("cornell", tracer::Traversal::BvhStack, &["--gpu", gpu, "--set", &set]);
        assert_whole(&as_images, gpu);
        let as_buffers = profile("cornell", tracer::Traversal::BvhStack, &["--gpu", gpu]);
        assert!(as_images["counters"]["l1_accesses"]["value"].as_u64() > Some(0), "{gpu}");
        assert!(as_buffers["counters"]["l1_accesses"]["reason"].is_string(), "{gpu}");
        // Behind a cluster cache, the second level sees little of either.
        if !path.contains("cluster") {
            let l2 = |report: &Value| report["counters"]["l2_accesses"]["value"].as_u64().expect("a count");
            assert!(l2(&as_images) < l2(&as_buffers), "{gpu}: the first level takes some of the accesses");
        }
    }
}

#[test]
fn every_primitive_layout_runs_and_only_moves_bytes() {
    let counters = |layout| {
        profile("figure", tracer::Traversal::BvhStack, &["--layout", layout, "--force", "normals"])["counters"].clone()
    };
    let padded = counters("padded");
    for layout in ["compact", "split"] {
        let other = counters(layout);
        for id in ["node_fetches", "primitive_tests", "rays"] {
            assert_eq!(other[id]["value"], padded[id]["value"], "{id} with {layout}");
        }
        assert_ne!(other["dram_read_bytes"]["value"], padded["dram_read_bytes"]["value"], "{layout}");
    }
}

#[test]
fn every_technique_of_reflections_runs_through_every_traversal_in_its_own_passes() {
    for traversal in tracer::Traversal::ALL {
        let mut queries = Vec::new();
        for technique in techniques(true) {
            let place = format!("{traversal:?}, {technique}");
            let report = profile("cornell", traversal, &["--technique", technique, "--force", "mirror"]);
            assert_whole(&report, &place);
            let sorted = ["bucket count", "bucket offset", "bucket copy", "hit shading"];
            let sorted: &[&str] = if technique == "reflections-visibility-buffer" { &sorted } else { &[] };
            let expected = ["screen-space march", "reflection rays"].iter().chain(sorted);
            let expected: Vec<&str> = expected.chain(&["reflection shadow rays"]).copied().collect();
            assert_eq!(passes(&report), expected, "{place}");
            if !["reflections-direct", "reflections-pipeline"].contains(&technique) {
                queries.push(of_pass(&report, "reflection rays", "rays"));
            }
        }
        assert!(queries.iter().all(|&rays| rays > 0.0 && rays == queries[0]), "{traversal:?}: {queries:?}");
    }
}

#[test]
fn every_technique_runs_through_every_traversal_in_its_own_passes() {
    for scene in ["cornell", "teapot"] {
        for traversal in tracer::Traversal::ALL {
            let run = |technique| {
                let report = profile(scene, traversal, &["--technique", technique]);
                assert_whole(&report, &format!("{scene}, {traversal:?}, {technique}"));
                assert_eq!(report["inputs"]["technique"], technique);
                report
            };
            // One of two eyes, traced as any other image.
            let of_an_eye: &[&str] = &["primary rays", "shadow rays", "output"];
            let expected: [(&str, &[&str]); 7] = [
                ("fragment", &["primary rays", "shadow rays", "output"]),
                ("compute", &["primary rays", "shadow rays", "output", "present"]),
                ("hybrid", &["geometry", "shadow rays", "output"]),
                ("hybrid-resolved", &["geometry", "shadow rays", "output"]),
                ("stereo", of_an_eye),
                ("stereo-in-place", of_an_eye),
                ("stereo-memory", of_an_eye),
            ];
            assert_eq!(expected.map(|(name, _)| name).to_vec(), techniques(false));
            let reports = expected.map(|(technique, expected)| {
                let report = run(technique);
                assert_eq!(passes(&report), expected, "{scene}, {traversal:?}, {technique}");
                report
            });
            let [fragment, compute, hybrid, resolved, eyes @ ..] = &reports;
            let place = format!("{scene}, {traversal:?}");
            let shadow_rays = of_pass(fragment, "shadow rays", "rays");
            assert!(shadow_rays > 0.0);
            assert_eq!(of_pass(fragment, "primary rays", "rays"), 40.0 * 24.0, "{place}");
            assert_eq!(compute["counters"]["rays"], fragment["counters"]["rays"], "{place}");
            assert!(of_pass(compute, "present", "frame_time_ms") > 0.0, "{place}");
            for eye in eyes {
                assert_eq!(eye["counters"]["rays"], fragment["counters"]["rays"], "{place}");
            }
            for report in [hybrid, resolved] {
                assert_eq!(report["counters"]["rays"]["value"].as_f64(), Some(shadow_rays), "{place}");
                assert!(of_pass(report, "geometry", "frame_time_ms") > 0.0, "{place}");
                assert!(of_pass(report, "geometry", "dram_read_bytes") > 0.0, "{place}");
                assert!(of_pass(report, "geometry", "vertex_memory_read_bytes") > 0.0, "{place}");
            }
            let bytes = |report: &Value| {
                let value = |id: &str| report["counters"][id]["value"].as_u64().expect("a count");
                value("dram_read_bytes") + value("dram_write_bytes")
            };
            assert!(bytes(resolved) > bytes(hybrid), "attachments in memory move more bytes: {place}");
        }
    }
}

#[test]
fn pipelines_run_through_every_traversal_launched_and_bound_in_every_way() {
    for traversal in tracer::Traversal::ALL {
        for hit_shading in ["pipeline", "pipeline-library"] {
            for query in ["ray-generation", "hit-shader"] {
                for technique in
                    ["reflections-direct", "reflections-hybrid-direct", "reflections-hybrid-sign"]
                {
                    let place = format!("{traversal:?}, {technique}, {hit_shading}, {query}");
                    let options = ["--technique", technique, "--force", "mirror", "--gpu", "mali-g925"];
                    let of_pipeline = ["--hit-shading", hit_shading, "--secondary-query", query];
                    let report = profile("cornell", traversal, &[&options[..], &of_pipeline].concat());
                    assert_whole(&report, &place);
                    assert!(of_pass(&report, "reflection rays", "shader_calls") > 0.0, "{place}");
                }
            }
        }
    }
}

/// Names of the techniques whose frames are of pixels, or of lists of reflection rays.
fn techniques(reflections: bool) -> Vec<&'static str> {
    let names = gpumodel::TECHNIQUES.iter().map(|technique| technique.name);
    names.filter(|name| name.starts_with("reflections-") == reflections).collect()
}
