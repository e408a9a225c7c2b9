//! Is what a scene does not need left out, named, and forced in or out on request?

use crate::support::{arg, file, folder, raybudget, without_run};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const SIZE: [&str; 2] = ["--size", "72x40"];

/// Two triangles, one behind the other, as faces of `corner` such as `{}//1`.
fn obj(corner: &str) -> String {
    let face = |corners: [u32; 3]| {
        let corners = corners.map(|index| corner.replace("{}", &index.to_string()));
        format!("f {}\n", corners.join(" "))
    };
    format!(
        "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 1 1 -1\nv 5 1 -1\nv 1 4 -1\nvn 0 0 1\n{}{}",
        face([1, 2, 3]),
        face([4, 5, 6])
    )
}

/// A scene file over a geometry, with more keys.
fn scene(dir: &TempDir, name: &str, geometry: &str, keys: &str) -> PathBuf {
    let camera = "[camera]\neye = [1, 1, 6]\ntarget = [1, 1, 0]\nvertical_fov_degrees = 60";
    file(dir, name, format!("geometry = \"{geometry}\"\n{keys}\n{camera}\n"))
}

fn profile(scene: &Path, options: &[&str]) -> Value {
    let args = ["profile", arg(scene), "--format", "json"];
    without_run(&raybudget(args.iter().chain(&SIZE).chain(options)).json())
}

fn names<'a>(report: &'a Value, list: &str) -> Vec<&'a str> {
    let entries = report[list].as_array().expect("a list");
    entries.iter().map(|entry| entry["name"].as_str().expect("a name")).collect()
}

fn of_pass<'a>(report: &'a Value, name: &str) -> &'a Value {
    let passes = report["passes"].as_array().expect("passes");
    &passes.iter().find(|pass| pass["name"] == name).unwrap_or_else(|| panic!("no pass {name}"))["counters"]
}

fn buffer<'a>(report: &'a Value, name: &str) -> Option<&'a Value> {
    report["buffers"].as_array().expect("buffers").iter().find(|buffer| buffer["name"] == name)
}

fn why<'a>(report: &'a Value, what: &str) -> Option<&'a str> {
    let entries = report["left_out"].as_array().expect("a list");
    entries.iter().find(|entry| entry["what"] == what)?["why"].as_str()
}

fn count(counters: &Value, id: &str) -> u64 {
    counters[id]["value"].as_u64().unwrap_or_else(|| panic!("{id} is a count: {}", counters[id]))
}

/// The parts of a report that what was asked for shows in, and nothing of the frame.
fn frame_alone(report: &Value) -> Value {
    let mut report = report.clone();
    let parts = report.as_object_mut().expect("a report");
    for part in ["left_out", "notes", "forced"] {
        parts.remove(part);
    }
    report["inputs"].as_object_mut().expect("inputs").remove("scene");
    report["inputs"]["hashes"].as_object_mut().expect("hashes").remove("scene");
    report
}

/// Counters of a pass that follow from its own work, not from what else is in the caches or how long it takes.
const WORK: [&str; 13] = [
    "rays",
    "node_fetches",
    "primitive_tests",
    "fragments",
    "alu_operations",
    "alu_operations_issued",
    "efu_operations",
    "efu_operations_issued",
    "memory_instructions",
    "load_store_cycles",
    "l2_accesses",
    "load_store_l2_accesses",
    "simt_efficiency",
];

fn assert_same_work(a: &Value, b: &Value, pass: &str) {
    for id in WORK {
        assert_eq!(of_pass(a, pass)[id], of_pass(b, pass)[id], "{id} of {pass}");
    }
}

/// Steps and bytes of the trace of a scene.
fn traced(dir: &TempDir, scene: &Path, options: &[&str]) -> (u64, u64) {
    let out = dir.path().join("frame.rbt");
    let args = ["trace", arg(scene), "-o", arg(&out)];
    let printed = raybudget(args.iter().chain(&SIZE).chain(options)).ok();
    let figure = |unit: &str| {
        let before = printed.split(unit).next().expect("a part");
        before
            .rsplit(' ')
            .next()
            .and_then(|number| number.parse().ok())
            .unwrap_or_else(|| panic!("{unit}: {printed}"))
    };
    (figure(" steps"), figure(" bytes,"))
}

#[test]
fn without_light_there_are_no_shadow_rays_anywhere() {
    let dir = folder();
    let lit = scene(&dir, "lit.toml", "cornell", "");
    for (keys, reason) in [
        ("lights = []", "not needed: the scene has no light"),
        ("rays = { shadow = false }", "not needed: the scene has lights, but its file turns shadow rays off"),
    ] {
        let dark = scene(&dir, "dark.toml", "cornell", keys);
        let [with, without] = [&lit, &dark].map(|scene| profile(scene, &[]));
        assert_eq!(names(&with, "passes"), ["primary rays", "shadow rays", "output"]);
        assert_eq!(names(&without, "passes"), ["primary rays", "output"]);
        assert_eq!(without["inputs"]["ray_sets"], json!(["primary"]));
        assert_eq!(why(&with, "shadow_rays"), None);
        assert_eq!(why(&without, "shadow_rays"), Some(reason));
        for pass in ["primary rays", "output"] {
            assert_same_work(&with, &without, pass);
        }
        let rays = |report: &Value| count(&report["counters"], "rays");
        assert_eq!(rays(&without), 72 * 40);
        assert_eq!(rays(&with), 72 * 40 + count(of_pass(&with, "shadow rays"), "rays"));
        let [(steps, bytes), (fewer_steps, fewer_bytes)] =
            [&lit, &dark].map(|scene| traced(&dir, scene, &[]));
        assert!(fewer_steps < steps * 3 / 4 && fewer_bytes < bytes, "{fewer_steps} of {steps} steps");
        for format in ["csv", "text"] {
            let printed = raybudget(["profile", arg(&dark), "--format", format].iter().chain(&SIZE)).ok();
            assert!(!printed.contains("shadow rays  ") && !printed.contains(",shadow rays,"), "{printed}");
        }
        for (technique, passes) in
            [("compute", &["primary rays", "output", "present"][..]), ("hybrid", &["geometry", "output"])]
        {
            assert_eq!(names(&profile(&dark, &["--technique", technique]), "passes"), passes);
        }
    }
}

#[test]
fn shadow_rays_that_are_left_out_take_no_time_in_this_process() {
    let dir = folder();
    let dark = scene(&dir, "dark.toml", "teapot", "lights = []");
    let lit = scene(&dir, "lit.toml", "teapot", "[[lights]]\nkind = \"point\"\nposition = [3, 9, 9]");
    let seconds = |scene: &Path| {
        let args = ["profile", arg(scene), "--format", "json", "--size", "256x256", "--threads", "1"];
        let replay_s = raybudget(args).json()["run"]["replay_s"].as_f64().expect("seconds");
        assert!(replay_s > 0.0);
        replay_s
    };
    let [with, without] =
        [&lit, &dark].map(|scene| (0..3).map(|_| seconds(scene)).fold(f64::INFINITY, f64::min));
    assert!(without < with, "{without} s without shadow rays, {with} s with them");
}

#[test]
fn without_shading_normals_no_record_has_any() {
    let dir = folder();
    file(&dir, "smooth.obj", obj("{}//1"));
    file(&dir, "flat.obj", obj("{}"));
    let smooth = scene(&dir, "smooth.toml", "smooth.obj", "");
    let flat = scene(&dir, "flat.toml", "flat.obj", "");
    for (layout, bytes, apart) in [("padded", 96, 0), ("compact", 80, 0), ("split", 48, 48)] {
        let [with, without] = [&smooth, &flat].map(|scene| profile(scene, &["--layout", layout]));
        let triangles = |report: &Value| buffer(report, "triangles").expect("a buffer")["bytes"].as_u64();
        assert_eq!((triangles(&with), triangles(&without)), (Some(2 * bytes), Some(2 * 48)));
        assert_eq!(
            buffer(&with, "normals").and_then(|normals| normals["bytes"].as_u64()),
            (apart > 0).then_some(2 * apart)
        );
        assert_eq!(buffer(&without, "normals"), None);
        assert!(
            why(&with, "normals").expect("an entry").starts_with("2 of 2 triangles have shading normals")
        );
        assert!(why(&without, "normals").expect("an entry").starts_with("not needed: "));
        let read = |report: &Value| count(&report["counters"], "dram_read_bytes");
        assert!(read(&without) < read(&with), "{layout}");
        assert_same_work(&with, &without, "shadow rays");
        assert_eq!(names(&with, "passes"), names(&without, "passes"));
    }
    let vertices = |scene: &Path| {
        let hybrid = profile(scene, &["--technique", "hybrid"]);
        buffer(&hybrid, "vertices").expect("a buffer")["bytes"].as_u64()
    };
    assert_eq!((vertices(&smooth), vertices(&flat)), (Some(6 * 24), Some(6 * 12)));
}

#[test]
fn a_feature_that_is_forced_in_is_as_if_the_scene_needed_it() {
    let dir = folder();
    file(&dir, "smooth.obj", obj("{}//1"));
    file(&dir, "flat.obj", obj("{}"));
    // A file without lights is given the light that forced shadow rays go to.
    let lit = scene(&dir, "lit.toml", "flat.obj", "");
    let dark = scene(&dir, "dark.toml", "flat.obj", "lights = []");
    let smooth = scene(&dir, "smooth.toml", "smooth.obj", "");
    for (needs, lacks, feature) in [(&lit, &dark, "shadow-rays"), (&smooth, &lit, "normals")] {
        for machine in
            [&["--layout", "split"][..], &["--technique", "compute"], &["--technique", "hybrid-resolved"]]
        {
            let run = |scene: &Path, options: &[&str]| profile(scene, &[machine, options].concat());
            let (needed, unneeded) = (run(needs, &[]), run(lacks, &[]));
            assert_ne!(frame_alone(&needed), frame_alone(&unneeded), "{feature}, {machine:?}");
            assert_eq!(
                frame_alone(&run(lacks, &["--force", feature])),
                frame_alone(&needed),
                "{feature}, {machine:?}"
            );
            assert_eq!(
                frame_alone(&run(needs, &["--leave-out", feature])),
                frame_alone(&unneeded),
                "{feature}, {machine:?}"
            );
            // What the scene asks for anyway is not forced.
            assert_eq!(run(needs, &["--force", feature]), needed);
            assert_eq!(run(lacks, &["--leave-out", feature]), unneeded);
        }
    }
}

#[test]
fn forcing_what_is_not_needed_changes_no_other_counter() {
    let dir = folder();
    let dark = scene(&dir, "dark.toml", "teapot", "lights = []");
    let [plain, shadowed] = [&[][..], &["--force", "shadow-rays"]].map(|options| profile(&dark, options));
    for pass in ["primary rays", "output"] {
        assert_same_work(&plain, &shadowed, pass);
    }
    for id in ["structure_nodes", "structure_bytes", "fragments", "warps"] {
        assert_eq!(plain["counters"][id], shadowed["counters"][id], "{id}");
    }
    for name in ["nodes", "triangles", "stacks"] {
        assert_eq!(
            buffer(&plain, name).expect("a buffer")["bytes"],
            buffer(&shadowed, name).expect("a buffer")["bytes"]
        );
    }
    let split = ["--layout", "split"];
    let [plain, smooth] =
        [&split[..], &["--layout", "split", "--force", "normals"]].map(|options| profile(&dark, options));
    for id in WORK {
        assert_eq!(of_pass(&plain, "primary rays")[id], of_pass(&smooth, "primary rays")[id], "{id}");
    }
    assert_eq!(plain["counters"]["alu_operations"], smooth["counters"]["alu_operations"]);
    assert_eq!(
        buffer(&plain, "triangles").expect("a buffer")["bytes"],
        buffer(&smooth, "triangles").expect("a buffer")["bytes"]
    );
    assert_eq!(names(&smooth, "buffers"), ["nodes", "triangles", "normals", "stacks"]);
}

#[test]
fn what_is_forced_is_named_with_its_cost_by_a_profile_and_by_a_replay() {
    let dir = folder();
    let dark = scene(&dir, "dark.toml", "cornell", "lights = []");
    let lit = scene(&dir, "lit.toml", "cornell", "");
    let forced = |report: &Value| report["forced"].as_array().cloned().unwrap_or_default();
    assert!(forced(&profile(&dark, &[])).is_empty());

    let shadows = profile(&dark, &["--force", "shadow-rays"]);
    let [cost] = forced(&shadows).try_into().expect("one entry");
    assert_eq!((&cost["what"], &cost["choice"]), (&json!("shadow_rays"), &json!("in")));
    assert_eq!(cost["frame_time_ms"], of_pass(&shadows, "shadow rays")["frame_time_ms"]["value"]);
    assert_eq!(cost["dram_read_bytes"], of_pass(&shadows, "shadow rays")["dram_read_bytes"]["value"]);
    let notes = shadows["notes"].as_array().expect("notes");
    assert!(
        notes
            .iter()
            .any(|note| note.as_str().is_some_and(|note| note.contains("above and behind the camera")))
    );

    let without = profile(&lit, &["--leave-out", "shadow-rays"]);
    let [saved] = forced(&without).try_into().expect("one entry");
    assert_eq!(saved["frame_time_ms"], of_pass(&without, "primary rays")["frame_time_ms"]["value"]);
    assert_eq!(why(&without, "shadow_rays"), Some("the scene needs it; --leave-out shadow-rays"));

    // 32 triangles: three normals of 16 bytes in each record, and of 12 in each vertex.
    for (technique, bytes) in [("fragment", 32 * 48), ("hybrid", 32 * (48 + 36))] {
        let normals = profile(&lit, &["--force", "normals", "--layout", "split", "--technique", technique]);
        let [cost] = forced(&normals).try_into().expect("one entry");
        assert_eq!(cost["buffer_bytes"], bytes, "{technique}");
        assert_eq!(why(&normals, "normals"), None);
    }

    let options = ["--force", "normals,shadow-rays"];
    let out = dir.path().join("forced.rbt");
    raybudget(["trace", arg(&dark), "-o", arg(&out)].iter().chain(&SIZE).chain(&options)).ok();
    let replayed = without_run(&raybudget(["replay", arg(&out), "--format", "json"]).json());
    assert_eq!(replayed, profile(&dark, &options));
    assert_eq!(forced(&replayed).len(), 2);
    let text = raybudget(["replay", arg(&out)]).ok();
    assert!(
        text.contains("Forced against the needs of the scene\n  - shadow_rays, forced in: it takes "),
        "{text}"
    );
}

#[test]
fn requests_without_meaning_are_refused() {
    let refused = |args: &[&str], expected: &str| {
        let message = raybudget(args).refused();
        assert!(message.contains(expected), "{args:?}: expected '{expected}' in:\n{message}");
    };
    let dir = folder();
    let rays = file(&dir, "rays.bin", [0_u8; 32]);
    let out = dir.path().join("out");
    refused(&["profile", "cornell", "--force", "glass"], "shadow-rays, normals");
    refused(&["profile", "cornell", "--leave-out", ""], "shadow-rays, normals");
    refused(
        &["profile", "cornell", "--force", "normals", "--leave-out", "shadow-rays,normals"],
        "give one of them",
    );
    refused(
        &["trace", "cornell", "--rays", arg(&rays), "-o", arg(&out), "--force", "shadow-rays"],
        "closest hits alone",
    );
    refused(&["render", "cornell", "-o", arg(&out), "--leave-out", "normals"], "shaded by the flat normal");
    assert!(!out.exists());
}

#[test]
fn only_buffers_that_the_frame_has_are_listed() {
    let dir = folder();
    let cornell = scene(&dir, "cornell.toml", "cornell", "");
    for (options, expected) in [
        (&["--accel", "bvh", "--traversal", "stack"][..], &["nodes", "triangles", "stacks"][..]),
        (&["--accel", "bvh", "--traversal", "restart-trail"], &["nodes", "triangles"]),
        (&["--accel", "kd", "--traversal", "push-down"], &["nodes", "triangles", "triangle indices"]),
        (&["--technique", "compute"], &["nodes", "triangles", "stacks", "images"]),
        (&["--technique", "hybrid", "--traversal", "parent-link"], &["nodes", "triangles", "vertices"]),
        (&["--technique", "hybrid-resolved"], &["nodes", "triangles", "stacks", "vertices", "images"]),
        (&["--technique", "hybrid", "--leave-out", "shadow-rays"], &["vertices"]),
        (&["--force", "normals", "--layout", "split"], &["nodes", "triangles", "normals", "stacks"]),
        (
            &["--force", "normals", "--layout", "split", "--technique", "hybrid"],
            &["nodes", "triangles", "stacks", "vertices"],
        ),
    ] {
        let report = profile(&cornell, options);
        assert_eq!(names(&report, "buffers"), expected, "{options:?}");
        for buffer in report["buffers"].as_array().expect("buffers") {
            assert!(
                buffer["bytes"].as_u64() > Some(0) && buffer["line_accesses"].as_u64() > Some(0),
                "{buffer}"
            );
        }
    }
}

#[test]
fn binning_is_a_pass_only_of_frames_larger_than_a_bin() {
    let dir = folder();
    let cornell = scene(&dir, "cornell.toml", "cornell", "");
    let small = profile(&cornell, &["--technique", "hybrid"]);
    assert_eq!(names(&small, "passes"), ["geometry", "shadow rays", "output"]);
    assert_eq!(why(&small, "binning"), Some("not needed: the frame fits into one bin"));
    let binned = profile(&cornell, &["--technique", "hybrid", "--set", "tiler.tile_memory_bytes=24576"]);
    assert_eq!(names(&binned, "passes"), ["binning", "geometry", "shadow rays", "output"]);
    assert_eq!(why(&binned, "binning"), None);
}

#[test]
fn a_trail_is_as_wide_as_the_tree_is_deep() {
    let dir = folder();
    let run = |geometry: &str, options: &[&str]| {
        let scene = scene(&dir, "scene.toml", geometry, "");
        profile(&scene, &[&["--traversal", "restart-trail"], options].concat())
    };
    let narrow = run("cornell", &[]);
    let wide = run("cornell", &["--trail-bits", "64"]);
    assert_eq!((&narrow["inputs"]["trail_bits"], &wide["inputs"]["trail_bits"]), (&json!(32), &json!(64)));
    assert_eq!(narrow["counters"], wide["counters"]);
    let says = |report: &Value| {
        let sentences = report["assumptions"].as_array().expect("sentences");
        sentences
            .iter()
            .any(|sentence| sentence.as_str().is_some_and(|sentence| sentence.contains("a trail of 32 bits")))
    };
    assert!(says(&wide) && !says(&narrow));
    // The soup's tree is deeper than 31 levels unless it is told not to be.
    assert_eq!(run("soup", &[])["inputs"]["trail_bits"], 64);
    assert_eq!(run("soup", &["--trail-bits", "32"])["inputs"]["trail_bits"], 32);
}

#[test]
fn needs_that_no_frame_can_meet_yet_are_told_from_those_that_a_scene_does_not_have() {
    let dir = folder();
    file(&dir, "plain.obj", obj("{}"));
    let plain = profile(&scene(&dir, "plain.toml", "plain.obj", ""), &[]);
    for (need, material) in [("reflections", "illum 5"), ("textures", "map_Kd wood.png")] {
        file(&dir, "m.mtl", format!("newmtl m\n{material}\n"));
        file(&dir, "m.obj", format!("mtllib m.mtl\nusemtl m\n{}", obj("{}")));
        let with = profile(&scene(&dir, "m.toml", "m.obj", ""), &[]);
        assert!(why(&plain, need).is_some_and(|why| why.starts_with("not needed: no triangle")), "{need}");
        assert!(why(&with, need).is_some_and(|why| why.starts_with("2 of 2 triangles")), "{need}");
        assert_eq!(frame_alone(&with), frame_alone(&plain), "{need} is not modelled");
    }
    assert!(why(&plain, "instances").is_some_and(|why| why.starts_with("not needed: ")));
    assert!(why(&plain, "several_materials").is_some_and(|why| why.starts_with("not needed: ")));
}
