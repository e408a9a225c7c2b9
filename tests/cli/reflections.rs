//! Do frames of reflections hold what their techniques promise?

use crate::support::{arg, folder, raybudget, without_run};
use serde_json::Value;

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

const TECHNIQUES: [&str; 8] = [
    "direct",
    "hybrid-direct",
    "hybrid",
    "hybrid-sign",
    "hybrid-octahedral",
    "hybrid-position",
    "hybrid-position-sign",
    "visibility-buffer",
];

#[test]
fn every_technique_traces_what_the_screen_leaves_and_its_passes_add_up() {
    let mut hybrids = Vec::new();
    for technique in TECHNIQUES {
        let report = profile(&["--technique", &format!("reflections-{technique}")]);
        let rays = ["reflection rays", "reflection shadow rays"].map(|pass| counter(&report, pass, "rays"));
        assert!(rays.iter().all(|&rays| rays > 0.0), "{technique}: {rays:?}");
        if technique != "direct" {
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

#[test]
fn a_trace_is_of_pixels_and_says_so() {
    let dir = folder();
    let trace = dir.path().join("cornell.rbt");
    raybudget(["trace", "cornell", "--size", "32x32", "-o", arg(&trace)]).ok();
    let message = raybudget(["replay", arg(&trace), "--technique", "reflections-hybrid"]).refused();
    assert!(message.contains("use profile or compare"), "{message}");
}
