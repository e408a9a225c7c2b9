//! Do frames of reflections hold what their techniques promise?

use crate::support::{arg, folder, names_in, raybudget, without_run};
use serde_json::Value;
use std::fs;
use std::path::Path;

const FRAME: [&str; 10] = [
    "profile",
    "cornell",
    "--size",
    "72x40",
    "--accel",
    "wide-bvh",
    "--node-format",
    "compressed-8",
    "--force",
    "mirror",
];

fn profile(options: &[&str]) -> Value {
    let gpu = ["--gpu", "mali-g715", "--format", "json"];
    without_run(&raybudget(FRAME.iter().chain(&gpu).chain(options)).json())
}

fn refused(options: &[&str]) -> String {
    raybudget(FRAME.iter().chain(options)).refused()
}

fn counter(report: &Value, pass: &str, id: &str) -> f64 {
    let passes = report["passes"].as_array().expect("passes");
    let found = passes.iter().find(|found| found["name"] == pass).unwrap_or_else(|| panic!("no pass {pass}"));
    found["counters"][id]["value"].as_f64().unwrap_or_else(|| panic!("no {id} in {pass}"))
}

fn passes(report: &Value) -> Vec<&str> {
    let passes = report["passes"].as_array().expect("a list");
    passes.iter().map(|pass| pass["name"].as_str().expect("a name")).collect()
}

const TECHNIQUES: [&str; 9] = [
    "direct",
    "hybrid-direct",
    "hybrid",
    "hybrid-sign",
    "hybrid-octahedral",
    "hybrid-position",
    "hybrid-position-sign",
    "visibility-buffer",
    "pipeline",
];

#[test]
fn every_technique_traces_what_the_screen_leaves_and_its_passes_add_up() {
    let mut hybrids = Vec::new();
    for technique in TECHNIQUES {
        let report = profile(&["--technique", &format!("reflections-{technique}")]);
        let rays = ["reflection rays", "reflection shadow rays"].map(|pass| counter(&report, pass, "rays"));
        assert!(rays.iter().all(|&rays| rays > 0.0), "{technique}: {rays:?}");
        if !["direct", "pipeline"].contains(&technique) {
            hybrids.push(rays);
        }
        let of_passes: f64 = passes(&report).iter().map(|pass| counter(&report, pass, "frame_time_ms")).sum();
        let frame = report["counters"]["frame_time_ms"]["value"].as_f64().expect("a time");
        assert!((of_passes / frame - 1.0).abs() < 1e-9, "{technique}: {of_passes} of {frame} ms");
        let sorts = passes(&report).contains(&"bucket copy");
        assert_eq!(sorts, technique == "visibility-buffer");
    }
    assert!(hybrids.windows(2).all(|pair| pair[0] == pair[1]), "orders lose no ray: {hybrids:?}");
    let direct = profile(&["--technique", "reflections-direct"]);
    assert!(counter(&direct, "reflection rays", "rays") > 1.5 * hybrids[0][0]);
}

#[test]
fn a_list_of_rays_fills_warps_better_than_pixels_do_and_bins_better_still() {
    let nodes = |options: &[&str]| {
        let unit = ["--ray-unit", "warp", "--technique"];
        let report = profile(&unit.iter().chain(options).copied().collect::<Vec<_>>());
        counter(&report, "reflection rays", "ray_unit_box_nodes")
    };
    let [pixels, list, bins] = ["reflections-hybrid-direct", "reflections-hybrid", "reflections-hybrid-sign"]
        .map(|name| nodes(&[name]));
    assert!(list < pixels && bins < list, "{pixels} nodes by pixels, {list} by a list, {bins} by bins");
}

#[test]
fn what_lanes_join_does_not_reach_memory() {
    let copies = |strategy: &str| {
        let report = profile(&["--technique", "reflections-visibility-buffer", "--atomics", strategy]);
        ["atomics", "frame_time_ms"].map(|id| counter(&report, "bucket copy", id))
    };
    let [brute, looped, subgroup, ballot] = ["brute-force", "loop", "subgroup", "ballot"].map(copies);
    assert!(brute[0] == looped[0] && subgroup[0] == ballot[0] && subgroup[0] < 0.5 * brute[0]);
    assert!(subgroup[1] < brute[1]);
    let elements =
        counter(&profile(&["--technique", "reflections-visibility-buffer"]), "reflection rays", "rays");
    assert_eq!(brute[0], elements, "each element adds to its bucket once");
}

#[test]
fn a_pipeline_is_linked_up_to_the_limit_of_the_driver_and_called_beyond_it() {
    let of = |options: &[&str]| {
        let gpu = ["--gpu", "mali-g1-ultra", "--technique", "reflections-pipeline"];
        let options: Vec<&str> = gpu.iter().chain(options).copied().collect();
        without_run(&raybudget(FRAME.iter().chain(&["--format", "json"]).chain(&options)).json())
    };
    let calls = |report: &Value| counter(report, "reflection rays", "shader_calls");
    let says = |report: &Value, text: &str| report["assumptions"].to_string().contains(text);
    // Ray generation, miss and 8 materials are 10 shaders.
    let linked = of(&["--materials", "8"]);
    assert!(
        calls(&linked) == 0.0 && says(&linked, "The 10 shaders of the ray-tracing pipeline are one shader")
    );
    let beyond = of(&["--materials", "9"]);
    assert!(calls(&beyond) > 0.0 && says(&beyond, "The 11 shaders of the ray-tracing pipeline are called"));
    let library = of(&["--materials", "8", "--hit-shading", "pipeline-library"]);
    assert!(calls(&library) > 0.0 && says(&library, "libraries"));
}

#[test]
fn ray_queries_in_hit_shaders_are_walked_by_shaders_where_the_driver_emulates_them() {
    let of = |query| profile(&["--technique", "reflections-pipeline", "--secondary-query", query]);
    let (by_unit, emulated) = (of("ray-generation"), of("hit-shader"));
    let boxes = |report: &Value| report["counters"]["ray_unit_box_nodes"]["value"].as_u64();
    assert!(boxes(&by_unit).is_some_and(|nodes| nodes > 0) && boxes(&emulated).is_none());
    assert!(emulated["inputs"]["ray_unit"].is_null());
    for pass in ["reflection rays", "reflection shadow rays"] {
        assert_eq!(counter(&by_unit, pass, "rays"), counter(&emulated, pass, "rays"), "{pass}");
        let [alone, walked] = [&by_unit, &emulated].map(|report| counter(report, pass, "alu_operations"));
        assert!(walked > 5.0 * alone, "{pass}: {walked} against {alone}");
    }
    assert!(emulated["left_out"].to_string().contains("divergence of ray queries in hit shaders"));
}

#[test]
fn options_stand_in_the_name_of_the_technique_and_change_the_frame() {
    let report = profile(&[
        "--technique",
        "reflections-hybrid",
        "--binning",
        "octahedral-2x3",
        "--screen-space",
        "linear",
    ]);
    let name = "reflections-hybrid with screen-space linear, binning octahedral-2x3";
    assert_eq!(report["inputs"]["technique"], name);
    let plain = profile(&["--technique", "reflections-hybrid"]);
    assert_ne!(report["counters"]["frame_time_ms"], plain["counters"]["frame_time_ms"]);
}

#[test]
fn threads_change_nothing() {
    let report =
        |threads: &str| profile(&["--technique", "reflections-visibility-buffer", "--threads", threads]);
    assert_eq!(report("1"), report("3"));
}

#[test]
fn what_cannot_be_is_refused_with_its_reason() {
    for (options, expected) in [
        (&["--technique", "fragment", "--binning", "sign"][..], "technique fragment has no [reflections]"),
        (&["--technique", "reflections-hybrid", "--binning", "octahedral-0x4"], "0 bins"),
        (&["--technique", "reflections-hybrid", "--binning", "signs"], "no binning is called 'signs'"),
        (&["--technique", "reflections-direct", "--binning", "sign"], "bins rays that no buffer lists"),
        (
            &["--technique", "reflections-direct", "--hit-shading", "visibility-buffer"],
            "sorts hits of rays that no buffer lists",
        ),
        (&["--technique", "reflections-direct", "--payload", "64"], "no pipeline"),
        (&["--technique", "reflections-direct", "--secondary-query", "hit-shader"], "no pipeline"),
        (&["--technique", "reflections-pipeline", "--payload", "0"], "4 to 1024 bytes"),
        (&["--technique", "reflections-pipeline", "--payload", "large"], "expected a whole number"),
        (&["--technique", "reflections-pipeline", "--materials", "513"], "1 to 512 materials"),
        (&["--technique", "reflections-direct", "--query-origin", "last-position"], "there is none"),
        (&["--technique", "reflections-hybrid", "--fidelity", "timed"], "several shaders"),
        (&["--technique", "reflections-hybrid", "--fidelity", "sampled"], "lists them anew"),
    ] {
        let message = refused(options);
        assert!(message.contains(expected), "{options:?}: {message}");
    }
    let rough =
        raybudget(["profile", "cornell", "--size", "32x32", "--technique", "reflections-hybrid"]).refused();
    assert!(rough.contains("no surface is smooth enough") && rough.contains("--force mirror"), "{rough}");
}

/// Width, height and pixels of a picture.
fn decoded(path: &Path) -> (u32, u32, Vec<u8>) {
    let file = std::io::BufReader::new(fs::File::open(path).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut pixels).expect("a whole PNG");
    (info.width, info.height, pixels)
}

#[test]
fn a_frame_has_pictures_of_what_it_has() {
    let dir = folder();
    let written = |options: &[&str]| {
        let out = dir.path().join(options.join(" "));
        let report = profile(&[&["-o", arg(&out)], options].concat());
        (names_in(&out), report, out)
    };
    let has = |names: &[String], name: &str| names.iter().any(|other| other == name);
    let left_out = |report: &Value| {
        report["left_out"].as_array().expect("a list").iter().any(|entry| entry["what"] == "divergence map")
    };
    let occupancy = ["ray-unit-occupancy.svg", "ray-unit-occupancy.png", "ray-unit-occupancy.csv"];

    let (names, report, out) = written(&["--technique", "reflections-hybrid-sign"]);
    assert!(
        ["coverage.png", "divergence.png", "dram-lines.png"]
            .iter()
            .chain(&occupancy)
            .all(|name| has(&names, name))
    );
    assert!(!left_out(&report));
    let (width, height, pixels) = decoded(&out.join("coverage.png"));
    // 72 x 40 pixels are enlarged to 576 x 320.
    assert!(width >= 576 && height > 320, "{width} x {height}");
    // Yellow for the screen, blue for hits of ray queries.
    for colour in [[0xf0, 0xe4, 0x42], [0x00, 0x72, 0xb2]] {
        let painted = pixels.chunks_exact(3).filter(|pixel| *pixel == colour).count();
        assert!(painted > 100 * 8 * 8, "{painted} pixels of {colour:?}");
    }
    let table = fs::read_to_string(out.join(occupancy[2])).expect("a table");
    assert!(table.contains("\nreflection rays,boxes,13,16,"), "{table}");

    let (names, report, _) = written(&["--technique", "reflections-hybrid-sign", "--ray-unit", "ray"]);
    assert!(has(&names, "coverage.png") && !has(&names, "divergence.png") && left_out(&report), "{names:?}");
    assert!(!occupancy.iter().any(|name| has(&names, name)), "{names:?}");
    let (names, report, _) = written(&["--technique", "reflections-hybrid-sign", "--ray-unit", "none"]);
    assert!(has(&names, "divergence.png") && !has(&names, occupancy[0]) && !left_out(&report), "{names:?}");
    let (names, report, _) = written(&["--technique", "fragment"]);
    assert!(!has(&names, "coverage.png") && has(&names, "divergence.png") && !left_out(&report), "{names:?}");
    assert!(has(&names, occupancy[0]));
    let (names, report, _) = written(&["--technique", "fragment", "--ray-unit", "ray"]);
    assert!(!has(&names, "divergence.png") && left_out(&report), "{names:?}");
}

#[test]
fn variants_of_reflections_stand_side_by_side() {
    let dir = folder();
    let out = dir.path().join("out");
    let gpu = ["--gpu", "mali-g715", "--technique", "reflections-hybrid-sign", "-o", arg(&out)];
    let vary = ["--vary", "binning=none+sign"];
    raybudget(["compare"].iter().chain(&FRAME[1..]).chain(&gpu).chain(&vary)).ok();
    // Bins change the order of rays, not what they meet: one map of coverage, two of divergence.
    let (alone, _, _) = decoded(&out.join("coverage.png"));
    let (side_by_side, _, _) = decoded(&out.join("divergence.png"));
    assert!(alone < 2 * 504 && side_by_side > 2 * 504, "{alone} and {side_by_side} pixels wide");
    assert!(out.join("dram-lines.png").exists());
}

/// A trace of the frame, whose reflection rays it keeps.
fn traced(path: &Path, options: &[&str]) {
    raybudget(["trace"].iter().chain(&FRAME[1..]).chain(options).chain(&["-o", arg(path)])).ok();
}

#[test]
fn a_trace_is_replayed_as_its_scene_is_profiled_in_every_order() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    let listed = ["--technique", "reflections-direct", "--launch", "buffer"];
    let masked = ["--force", "alpha-tests"];
    for (of_frame, options) in [
        (&[][..], &["--technique", "reflections-direct"][..]),
        (&[], &["--technique", "reflections-pipeline"]),
        (&[], &listed),
        (&[], &[&listed[..], &["--binning", "octahedral-4x4"]].concat()),
        (&[], &[&listed[..], &["--binning", "position-sign-1", "--ray-unit", "ray"]].concat()),
        (&[], &[&listed[..], &["--hit-shading", "visibility-buffer", "--binning", "sign"]].concat()),
        (&masked, &[&listed[..], &["--binning", "sign"]].concat()),
    ] {
        traced(&trace, of_frame);
        let of_scene = profile(&[of_frame, options].concat());
        let gpu = ["replay", arg(&trace), "--gpu", "mali-g715", "--format", "json"];
        let of_trace = without_run(&raybudget(gpu.iter().chain(options)).json());
        for key in ["counters", "passes", "notes", "left_out", "inputs"] {
            assert_eq!(of_trace[key], of_scene[key], "{of_frame:?} {options:?}: {key}");
        }
    }
    let maps = dir.path().join("maps");
    raybudget(["replay", arg(&trace), "--gpu", "mali-g715", "-o", arg(&maps)].iter().chain(&listed)).ok();
    assert!(names_in(&maps).contains(&"coverage.png".to_owned()), "{:?}", names_in(&maps));
}

#[test]
fn what_a_trace_of_reflections_does_not_tell_is_refused() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    traced(&trace, &[]);
    let refused = |trace: &Path, options: &[&str]| {
        raybudget(["replay", arg(trace), "--gpu", "mali-g715"].iter().chain(options)).refused()
    };
    let screen = refused(&trace, &["--technique", "reflections-hybrid"]);
    assert!(screen.contains("depths") && screen.contains("--screen-space none"), "{screen}");
    let direct = ["--technique", "reflections-direct"];
    let materials = refused(&trace, &[&direct[..], &["--materials", "4"]].concat());
    assert!(materials.contains("--materials 4") && materials.contains("profile the scene"), "{materials}");
    let sampled = refused(&trace, &[&direct[..], &["--fidelity", "sampled"]].concat());
    assert!(sampled.contains("lists them anew"), "{sampled}");
    let rough = dir.path().join("rough.rbt");
    raybudget(["trace", "teapot", "--size", "32x32", "-o", arg(&rough)]).ok();
    let none = refused(&rough, &direct);
    assert!(none.contains("--force mirror"), "{none}");
    let whatif = raybudget(["whatif", arg(&rough), "--binning", "sign"]).refused();
    assert!(whatif.contains("--force mirror"), "{whatif}");
}

#[test]
fn whatif_bins_the_rays_of_a_trace() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    traced(&trace, &[]);
    let given = ["--base", "mali-g715", "--binning", "sign,octahedral-2x2", "--layout", "split"];
    let whatif = raybudget(["whatif", arg(&trace), "--format", "json"].iter().chain(&given)).json();
    let variants = whatif["variants"].as_array().expect("variants");
    let labels: Vec<&str> = variants.iter().map(|of| of["values"][0].as_str().expect("a label")).collect();
    assert_eq!(labels[0], "reflections as they arrive");
    let technique = ["--technique", "reflections-direct", "--launch", "buffer"];
    for (label, options) in [
        ("reflections as they arrive", &[][..]),
        ("binning sign", &["--binning", "sign"]),
        ("binning octahedral-2x2", &["--binning", "octahedral-2x2"]),
        ("layout split", &["--layout", "split"]),
    ] {
        let place = labels.iter().position(|&found| found == label).expect("it is among them");
        let expected = profile(&[&technique[..], options].concat());
        assert_eq!(variants[place]["report"]["counters"], expected["counters"], "{label}");
    }
    let unknown = raybudget(["whatif", arg(&trace), "--binning", "colour"]).refused();
    assert!(unknown.contains("--binning colour"), "{unknown}");
}
