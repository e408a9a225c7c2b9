//! Alpha tests: which frames have them, what they leave of a trace, and what is refused.

use crate::support::{arg, raybudget, without_run};
use serde_json::Value;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const MODES: [&str; 5] = ["any-hit", "unmarked", "opaque", "cull", "micromap"];
const SIZE: [&str; 2] = ["--size", "48x32"];

fn profile(scene: &str, options: &[&str]) -> Value {
    let args = [&["profile", scene, "--format", "json"], &SIZE[..], options].concat();
    without_run(&raybudget(args).json())
}

fn counter(report: &Value, id: &str) -> Option<u64> {
    report["counters"][id]["value"].as_u64()
}

/// A plate whose material has a mask, before a wall.
fn fenced(dir: &TempDir) -> PathBuf {
    let file =
        |name: &str, text: &str| std::fs::write(dir.path().join(name), text).expect("it can be written");
    file("fence.mtl", "newmtl fence\nmap_d fence.png\nnewmtl wall\nKd 1 1 1\n");
    file(
        "fence.obj",
        "mtllib fence.mtl\nv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nv -2 -2 -2\nv 2 -2 -2\nv 2 2 -2\nv -2 2 -2\n\
         usemtl fence\nf 1 2 3\nf 1 3 4\nusemtl wall\nf 5 6 7\nf 5 7 8\n",
    );
    let scene = "geometry = \"fence.obj\"\n[camera]\neye = [0, 0, 4]\ntarget = [0, 0, 0]\nvertical_fov_degrees = 50\n";
    file("fence.toml", scene);
    dir.path().join("fence.toml")
}

#[test]
fn scenes_with_masks_have_any_hit_shaders_and_others_none() {
    let dir = TempDir::new().expect("a folder");
    let scene = fenced(&dir);
    let masked = profile(arg(&scene), &[]);
    assert!(counter(&masked, "any_hits") > Some(0));
    let notes = masked["notes"].to_string();
    assert!(notes.contains("2 of 4 triangles carry an alpha mask"), "{notes}");
    let [left_out, opaque] =
        [["--leave-out", "alpha-tests"], ["--alpha", "opaque"]].map(|options| profile(arg(&scene), &options));
    for id in ["rays", "primitive_tests", "frame_time_ms", "dram_read_bytes"] {
        assert_eq!(left_out["counters"][id], opaque["counters"][id], "{id}");
    }
    assert_eq!(counter(&left_out, "any_hits"), None);
    assert!(opaque["left_out"].to_string().contains("--alpha opaque"));

    let plain = profile("cornell", &[]);
    assert_eq!(counter(&plain, "any_hits"), None);
    let why = "not needed: no triangle carries an alpha mask: no any-hit shader";
    assert!(plain["left_out"].to_string().contains(why));
    assert!(plain["buffers"].as_array().expect("a list").iter().all(|buffer| buffer["name"] != "images"));
    let forced = profile("cornell", &["--force", "alpha-tests"]);
    assert!(counter(&forced, "any_hits") > Some(0));
    assert_eq!(forced["forced"][0]["what"], "alpha_tests");
    assert!(forced["notes"].to_string().contains("8 of 32"), "{}", forced["notes"]);
    let unmarked = profile("cornell", &["--alpha", "unmarked"]);
    assert!(counter(&unmarked, "any_hits") > Some(0), "geometry without alpha may be unmarked too");
    for id in ["rays", "primitive_tests", "node_fetches"] {
        assert_eq!(unmarked["counters"][id], plain["counters"][id], "its shaders accept every hit: {id}");
    }
}

#[test]
fn a_replay_equals_the_profile_in_every_mode() {
    let dir = TempDir::new().expect("a folder");
    let out = dir.path().join("alpha.rbt");
    for frame in
        [&["--accel", "bvh"][..], &["--accel", "wide-bvh"], &["--accel", "two-level"], &["--accel", "kd"]]
    {
        for mode in MODES {
            let options = [frame, &["--force", "alpha-tests", "--alpha", mode]].concat();
            let trace = [&["trace", "cornell", "-o", arg(&out)], &SIZE[..], &options].concat();
            raybudget(trace).ok();
            for gpu in ["adreno-540", "mali-g715", "mali-g1-ultra"] {
                let replayed = raybudget(["replay", arg(&out), "--gpu", gpu, "--format", "json"]).json();
                let profiled = profile("cornell", &[&options[..], &["--gpu", gpu]].concat());
                assert_eq!(without_run(&replayed), profiled, "{options:?} on {gpu}");
            }
        }
    }
}

#[test]
fn micromaps_spare_shaders_but_no_hit() {
    let run =
        |options: &[&str]| profile("cornell", &[&["--force", "alpha-tests", "--alpha"], options].concat());
    let tested = run(&["any-hit"]);
    let mut calls = vec![counter(&tested, "any_hits")];
    for level in ["0", "2", "4"] {
        let spared = run(&["micromap", "--micromap-level", level]);
        for id in ["rays", "primitive_tests", "non_opaque_hits"] {
            assert_eq!(spared["counters"][id], tested["counters"][id], "{id} at level {level}");
        }
        calls.push(counter(&spared, "any_hits"));
    }
    assert!(calls.is_sorted_by(|a, b| a >= b) && calls[3] < calls[0], "{calls:?}");
    let two = run(&["micromap", "--micromap-states", "2"]);
    assert_eq!(counter(&two, "any_hits"), Some(0));
    // Among the triangles: 8 of the 32 have one.
    let bytes = |report: &Value| -> u64 {
        let buffers = report["buffers"].as_array().expect("a list");
        let of_triangles = buffers.iter().find(|buffer| buffer["name"] == "triangles").expect("it is there");
        of_triangles["bytes"].as_u64().expect("a number")
    };
    assert_eq!(bytes(&run(&["micromap"])) - bytes(&tested), 8 * 64);
    assert_eq!(bytes(&two) - bytes(&tested), 8 * 32);
}

#[test]
fn alpha_is_an_axis_of_comparisons() {
    let options = ["compare", "cornell", "--force", "alpha-tests", "--vary", "alpha", "--format", "csv"];
    let table = raybudget(options.iter().chain(&SIZE)).ok();
    assert!(MODES.iter().all(|mode| table.contains(&format!("\n{mode},"))), "{table}");
    let levels = ["compare", "cornell", "--force", "alpha-tests", "--alpha", "micromap"];
    let table =
        raybudget(levels.iter().chain(&["--vary", "micromap-level=0+4", "--format", "csv"]).chain(&SIZE));
    assert!(table.ok().contains(",any_hits,"), "the counter is there");
}

#[test]
fn requests_without_meaning_are_refused() {
    let refused = |options: &[&str], expected: &str| {
        let message = raybudget([&["profile", "cornell"], options].concat()).refused();
        assert!(message.contains(expected), "{options:?}: expected '{expected}' in:\n{message}");
    };
    refused(&["--alpha", "blend"], "any-hit, unmarked, opaque, cull, micromap");
    refused(&["--alpha", "cull", "--leave-out", "alpha-tests"], "leaves it nothing to decide");
    refused(&["--micromap-level", "2"], "add --alpha micromap");
    refused(&["--micromap-states", "2"], "add --alpha micromap");
    refused(&["--alpha", "micromap", "--micromap-level", "5"], "0..=4");
    refused(&["--vary", "alpha"], "unexpected argument");
}

#[test]
fn costs_and_units_that_say_nothing_of_alpha_tests_are_refused_where_they_are_needed() {
    let dir = TempDir::new().expect("a folder");
    let without = |path: &str, from: &str, to: &str| -> PathBuf {
        let text = std::fs::read_to_string(path).expect("it is there");
        let (before, rest) = text.split_once(from).expect("it has one");
        let (_, after) = rest.split_once(to).expect("and something behind it");
        let out = dir.path().join(Path::new(path).file_name().expect("a name"));
        std::fs::write(&out, format!("{before}{to}{after}")).expect("it can be written");
        out
    };
    let costs = without("configs/costs.toml", "[alpha]", "# A ray query that a ray unit answers");
    let gpu = without("configs/gpus/mali-g715.toml", "return_cycles = ", "path = ");
    let alpha = ["profile", "cornell", "--force", "alpha-tests", "--accel", "wide-bvh"];
    for (option, file, expected) in
        [("--costs", &costs, "add a table [alpha]"), ("--gpu", &gpu, "add return_cycles to its [ray_unit]")]
    {
        let given = [option, arg(file)];
        let message = raybudget(alpha.iter().chain(&SIZE).chain(&given)).refused();
        assert!(message.contains(expected), "{message}");
        let plain = ["profile", "cornell", "--accel", "wide-bvh"];
        raybudget(plain.iter().chain(&SIZE).chain(&given)).ok();
    }
}
