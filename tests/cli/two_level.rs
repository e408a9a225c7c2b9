//! Two levels over a scene of instances.

use crate::support::{SMALL, file, folder, raybudget, without_run};
use serde_json::Value;
use std::path::PathBuf;
use tempfile::TempDir;

/// A tetrahedron, placed 60 times: turned, and scaled unevenly.
fn field(folder: &TempDir) -> PathBuf {
    let positions: [[f32; 3]; 4] = [[0.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, -1.0, -1.0]];
    let indices: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];
    let bytes: Vec<u8> = positions
        .as_flattened()
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .chain(indices.iter().flat_map(|index| index.to_le_bytes()))
        .collect();
    file(folder, "field.bin", bytes);
    let node = |number: u32| {
        let (x, z) = (2.5 * f64::from(number % 10), 2.5 * f64::from(number / 10));
        let half_angle = 0.17 * f64::from(number);
        let (sine, cosine) = half_angle.sin_cos();
        format!(
            r#"{{"mesh":0,"translation":[{x},0,{z}],"rotation":[0,{sine},0,{cosine}],"scale":[1,{},0.5]}}"#,
            0.5 + 0.02 * f64::from(number)
        )
    };
    let nodes: Vec<String> = (0..60).map(node).collect();
    let roots: Vec<String> = (0..60).map(|number| number.to_string()).collect();
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":48}}],
        "buffers":[{{"byteLength":96,"uri":"field.bin"}}]}}"#,
        roots.join(","),
        nodes.join(",")
    );
    file(folder, "field.gltf", text)
}

fn profile(scene: &std::path::Path, more: &[&str]) -> Value {
    let scene = scene.to_str().expect("UTF-8");
    let args = ["profile", scene, "--format", "json"];
    raybudget(args.iter().chain(&SMALL).chain(more)).json()
}

fn counter(report: &Value, id: &str) -> f64 {
    report["counters"][id]["value"].as_f64().unwrap_or_else(|| panic!("{id}: {}", report["counters"][id]))
}

#[test]
fn a_replayed_trace_of_instances_says_what_their_profile_says_on_any_number_of_threads() {
    let folder = folder();
    let scene = field(&folder);
    let trace = folder.path().join("field.rbt");
    for more in [
        &["--accel", "two-level"][..],
        &["--accel", "two-level", "--node-format", "full-4"],
        &["--accel", "two-level", "--traversal", "short-stack"],
    ] {
        let profiled = profile(&scene, more);
        let alone = profile(&scene, &[more, &["--threads", "1"]].concat());
        let paths = [&scene, &trace].map(|path| path.to_str().expect("UTF-8"));
        raybudget(["trace", paths[0], "-o", paths[1]].iter().chain(&SMALL).chain(more)).ok();
        let replayed = raybudget(["replay", paths[1], "--format", "json"]).json();
        assert_eq!(without_run(&profiled), without_run(&replayed));
        assert_eq!(without_run(&profiled), without_run(&alone));
        assert!(counter(&profiled, "instances") > 0.0);
    }
}

#[test]
fn two_levels_store_a_mesh_once_and_say_what_they_suffer_from() {
    let folder = folder();
    let scene = field(&folder);
    let [flat, levels] =
        [&["--accel", "bvh"][..], &["--accel", "two-level"]].map(|more| profile(&scene, more));
    assert_eq!(counter(&flat, "primitive_tests") > 0.0, counter(&levels, "primitive_tests") > 0.0);
    // A TLAS of 119 nodes, 60 records, and the BVH of four triangles.
    let structure = 119 * 32_u32;
    let expected =
        structure.next_multiple_of(256) + 60 * 128 + counter(&levels, "structure_nodes") as u32 * 32
            - structure;
    assert_eq!(counter(&levels, "structure_bytes") as u32, expected);
    let notes = levels["notes"].as_array().expect("notes");
    let has = |text: &str| notes.iter().any(|note| note.as_str().is_some_and(|note| note.contains(text)));
    assert!(has("60 instances of 1 meshes") && has("and 4 triangles") && has("240 triangles"), "{notes:?}");
    assert!(has("have fewer than 64 triangles: join neighbours"), "{notes:?}");
    assert!(flat["counters"]["instances"]["value"].is_null());
}

#[test]
fn a_wide_tlas_is_smaller_and_adrenos_instruction_walks_it_with_a_short_stack() {
    let folder = folder();
    let scene = field(&folder);
    let on =
        |more: &[&str]| profile(&scene, &[&["--accel", "two-level", "--gpu", "adreno-830"], more].concat());
    let [binary, full] = [&[][..], &["--node-format", "adreno-8"]].map(on);
    assert!(counter(&full, "structure_nodes") * 3.0 < counter(&binary, "structure_nodes"));
    let tlas = counter(&full, "structure_nodes") as u32 - 1;
    let expected = (tlas * 64).next_multiple_of(256) + 60 * 192 + 64;
    assert_eq!(counter(&full, "structure_bytes") as u32, expected);
    assert!(full["counters"]["ray_unit_box_tests"]["value"].is_null());
    let says = |report: &Value, text: &str| report["assumptions"].to_string().contains(text);
    assert!(says(&full, "--traversal short-stack") && says(&binary, "has no part in it"));

    let short = on(&["--traversal", "short-stack"]);
    assert!(!says(&short, "has no part in it"), "{}", short["assumptions"]);
    assert_eq!(short["inputs"]["node_format"], "adreno-8");
    let (tlas_boxes, boxes) =
        (counter(&short, "ray_unit_tlas_box_tests"), counter(&short, "ray_unit_box_tests"));
    assert!(0.0 < tlas_boxes && tlas_boxes < boxes, "{tlas_boxes} of {boxes}");
    assert_eq!(counter(&short, "ray_unit_instances"), counter(&short, "instances"));
    let in_shader = on(&["--traversal", "short-stack", "--ray-unit", "none"]);
    for same in ["node_fetches", "primitive_tests", "instances", "structure_bytes"] {
        assert_eq!(counter(&in_shader, same), counter(&short, same), "{same}");
    }
    // A shadow ray for each hit.
    assert_eq!(counter(&binary, "rays"), counter(&short, "rays"));
}

#[test]
fn pairs_of_triangles_are_fetched_once_and_named_in_the_report() {
    let of = |format: &str| {
        // An any-hit query ends at the first triangle, and pairs change which that is.
        let args = ["profile", "cornell", "--shadow-query", "closest-hit", "--format", "json"];
        let structure = ["--accel", "wide-bvh", "--node-format", format];
        raybudget(args.iter().chain(&SMALL).chain(&structure)).json()
    };
    let [alone, pairs] = ["compressed-8", "compressed-8-pairs"].map(of);
    for same in ["node_fetches", "primitive_tests", "structure_bytes", "rays"] {
        assert_eq!(counter(&alone, same), counter(&pairs, same), "{same}");
    }
    assert!(counter(&pairs, "memory_instructions") < counter(&alone, "memory_instructions"));
    let says = |report: &Value| report["notes"].to_string().contains("share an edge");
    assert!(says(&pairs) && !says(&alone), "{}", pairs["notes"]);

    let folder = folder();
    let trace = folder.path().join("pairs.rbt");
    let trace = trace.to_str().expect("UTF-8");
    let more =
        ["--accel", "wide-bvh", "--node-format", "compressed-8-pairs", "--shadow-query", "closest-hit"];
    raybudget(["trace", "cornell", "-o", trace].iter().chain(&SMALL).chain(&more)).ok();
    let replayed = raybudget(["replay", trace, "--format", "json"]).json();
    assert_eq!(without_run(&pairs), without_run(&replayed));
    let refused = raybudget(["replay", trace, "--primitive-order", "indexed"]).refused();
    assert!(refused.contains("use triangles in the order of the leaves"), "{refused}");
}

#[test]
fn trees_that_no_blas_can_be_are_refused_with_what_can() {
    let refused = |more: &[&str]| {
        raybudget(["profile", "cornell", "--accel", "two-level"].iter().chain(more)).refused()
    };
    assert!(refused(&["--max-depth", "9"]).contains("the trees of two levels are BVHs"));
    assert!(refused(&["--traversal", "dda"]).contains("use one of: stack, short-stack"));
    assert!(refused(&["--node-records", "child-boxes"]).contains("use packed or padded node records"));
}
