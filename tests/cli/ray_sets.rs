//! Does a frame have the rays that were asked for, and of them only those that its scene needs?

use crate::support::{arg, file, folder, raybudget, without_run};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const SIZE: [&str; 2] = ["--size", "72x40"];
const ALL: [&str; 2] = ["--ray-sets", "hard-shadows,soft-shadows,mirror,glossy,ao,diffuse"];

/// A floor under a wall, with a material that has these statements.
fn room(dir: &TempDir, name: &str, material: &str, keys: &str) -> PathBuf {
    file(dir, &format!("{name}.mtl"), format!("newmtl m\nKd 0.5 0.5 0.5\n{material}\n"));
    let corners = "v -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nv -9 9 -9\nv 9 9 -9\n";
    file(
        dir,
        &format!("{name}.obj"),
        format!("mtllib {name}.mtl\n{corners}usemtl m\nf 1 2 3 4\nf 1 2 6 5\n"),
    );
    let camera = "[camera]\neye = [1, 5, 12]\ntarget = [0, 1, 0]\nvertical_fov_degrees = 50";
    file(dir, &format!("{name}.toml"), format!("geometry = \"{name}.obj\"\n{keys}\n{camera}\n"))
}

const LIGHT: &str = "lights = [{ kind = \"point\", position = [3, 8, 4] }]";

fn profile(scene: &Path, options: &[&str]) -> Value {
    let args = ["profile", arg(scene), "--format", "json"];
    without_run(&raybudget(args.iter().chain(&SIZE).chain(options)).json())
}

fn passes(report: &Value) -> Vec<&str> {
    let passes = report["passes"].as_array().expect("a list");
    passes.iter().map(|pass| pass["name"].as_str().expect("a name")).collect()
}

fn counter<'a>(report: &'a Value, pass: &str, id: &str) -> &'a Value {
    let passes = report["passes"].as_array().expect("passes");
    let found = passes.iter().find(|found| found["name"] == pass).unwrap_or_else(|| panic!("no pass {pass}"));
    &found["counters"][id]["value"]
}

fn rays(report: &Value, pass: &str) -> u64 {
    counter(report, pass, "rays").as_u64().expect("a count")
}

fn why<'a>(report: &'a Value, what: &str) -> Option<&'a str> {
    let entries = report["left_out"].as_array().expect("a list");
    entries.iter().find(|entry| entry["what"] == what)?["why"].as_str()
}

/// What of a report is of the frame, and not of what was asked for.
fn frame_alone(report: &Value) -> Value {
    let mut report = report.clone();
    let parts = report.as_object_mut().expect("a report");
    ["left_out", "notes", "forced"].into_iter().for_each(|part| drop(parts.remove(part)));
    report["inputs"].as_object_mut().expect("inputs").remove("scene");
    report["inputs"]["hashes"].as_object_mut().expect("hashes").remove("scene");
    report
}

fn trace(dir: &TempDir, name: &str, scene: &str, options: &[&str]) -> PathBuf {
    let out = dir.path().join(name);
    raybudget(["trace", scene, "-o", arg(&out)].iter().chain(&SIZE).chain(options)).ok();
    out
}

#[test]
fn every_set_is_a_pass_of_its_own_and_changes_no_other_ones_work() {
    let dir = folder();
    let shiny = room(&dir, "shiny", "illum 5", LIGHT);
    let plain = profile(&shiny, &[]);
    assert_eq!(passes(&plain), ["primary rays", "shadow rays", "output"]);
    for (sets, of_sets) in [
        ("soft-shadows", &["soft shadow rays"][..]),
        ("mirror", &["reflection rays", "reflection shadow rays"]),
        ("ao", &["ambient occlusion rays"]),
        ("diffuse", &["diffuse rays", "diffuse shadow rays"]),
    ] {
        let report = profile(&shiny, &["--ray-sets", &format!("hard-shadows,{sets}")]);
        let expected = [&["primary rays", "shadow rays"], of_sets, &["output"]].concat();
        assert_eq!(passes(&report), expected);
        for pass in passes(&plain) {
            for id in ["rays", "node_fetches", "alu_operations", "memory_instructions", "load_store_cycles"] {
                assert_eq!(counter(&report, pass, id), counter(&plain, pass, id), "{sets}: {id} of {pass}");
            }
        }
        assert_eq!(rays(&report, of_sets[0]), rays(&report, "shadow rays"), "one from every hit");
        let more = profile(&shiny, &["--ray-sets", &format!("hard-shadows,{sets},glossy"), "--spp", "3"]);
        let samples = if sets == "mirror" { 1 } else { 3 };
        assert_eq!(rays(&more, of_sets[0]), samples * rays(&report, of_sets[0]), "{sets}");
    }
}

#[test]
fn the_roughness_of_a_surface_decides_on_its_reflection_rays() {
    let dir = folder();
    // (2 / (Ns + 2))^(1/4): 0.5 for Ns 30.
    let gates = |mirror: &str, glossy: &str| {
        format!(
            "{LIGHT}\n[rays]\nmirror = true\nglossy = true\nroughness = {{ mirror = {mirror}, glossy = {glossy} }}"
        )
    };
    for (material, mirror, glossy, rays_per_hit) in [
        ("Ks 1 1 1\nNs 30", "0.51", "0.6", 1),
        ("Ks 1 1 1\nNs 30", "0.49", "0.51", 4),
        ("Ks 1 1 1\nNs 30", "0.4", "0.49", 0),
        ("Ks 0 0 0\nNs 30", "0.51", "0.6", 0),
        ("illum 3\nNs 30", "0.0", "0.0", 1),
    ] {
        let scene = room(&dir, "gated", material, &gates(mirror, glossy));
        let report = profile(&scene, &["--spp", "4"]);
        let hits = rays(&report, "shadow rays");
        if rays_per_hit == 0 {
            assert!(!passes(&report).contains(&"reflection rays"), "{material} {mirror} {glossy}");
            for what in ["mirror", "glossy"] {
                assert!(why(&report, what).is_some_and(|why| why.starts_with("not needed: ")), "{what}");
            }
        } else {
            assert_eq!(rays(&report, "reflection rays"), hits * rays_per_hit, "{material} {mirror} {glossy}");
            assert!(rays(&report, "reflection shadow rays") < rays(&report, "reflection rays"));
        }
    }
}

#[test]
fn what_no_surface_needs_costs_nothing_and_is_named() {
    let dir = folder();
    let matte = room(&dir, "matte", "Ks 0 0 0", LIGHT);
    let plain = profile(&matte, &[]);
    let asked = profile(&matte, &["--ray-sets", "hard-shadows,mirror,glossy", "--spp", "8"]);
    assert_eq!(frame_alone(&asked), frame_alone(&plain));
    assert_eq!(
        why(&asked, "mirror"),
        Some("not needed: no triangle that reflects has a roughness of at most 0.1")
    );
    assert!(why(&asked, "glossy").is_some_and(|why| why.contains("above 0.1 and of at most 0.4")));
    let scene = arg(&matte);
    let [plain, asked] = [&[][..], &["--ray-sets", "hard-shadows,mirror,glossy"]]
        .map(|options| std::fs::read(trace(&dir, "frame.rbt", scene, options)).expect("a file").len());
    assert!(asked.abs_diff(plain) < 200, "the sentences alone: {asked} and {plain} bytes");

    let shiny = room(&dir, "shiny", "illum 5", LIGHT);
    let glossy = profile(&shiny, &["--ray-sets", "hard-shadows,glossy"]);
    assert_eq!(frame_alone(&glossy), frame_alone(&profile(&shiny, &[])));
    assert!(why(&glossy, "mirror").is_some_and(|why| why.starts_with("not asked for: 4 of 4 triangles")));
    let dark = room(&dir, "dark", "Ks 0 0 0", "lights = []");
    let soft = profile(&dark, &["--ray-sets", "soft-shadows"]);
    assert_eq!(
        (passes(&soft), why(&soft, "soft_shadows")),
        (vec!["primary rays", "output"], Some("not needed: the scene has no light"))
    );
    assert_eq!(why(&glossy, "shadow_rays"), None);
    let without = profile(&shiny, &["--ray-sets", "ao"]);
    assert_eq!(why(&without, "shadow_rays"), Some("not asked for: --ray-sets does not name hard-shadows"));
}

#[test]
fn a_set_that_is_forced_in_is_as_if_the_scene_needed_it() {
    let dir = folder();
    let needs = room(&dir, "shiny", "illum 5", LIGHT);
    let lacks = room(&dir, "matte", "Ks 0 0 0", LIGHT);
    for (set, needs, lacks) in [
        ("mirror", &needs, &lacks),
        ("ao", &lacks, &lacks),
        ("diffuse", &lacks, &lacks),
        ("soft-shadows", &lacks, &lacks),
    ] {
        for machine in [&["--layout", "split"][..], &["--technique", "hybrid"], &["--fidelity", "timed"]] {
            let run = |scene: &Path, options: &[&str]| profile(scene, &[machine, options].concat());
            let sets = format!("hard-shadows,{set}");
            let needed = run(needs, &["--ray-sets", &sets]);
            let unneeded = run(lacks, &[]);
            assert_ne!(frame_alone(&needed), frame_alone(&unneeded), "{set} {machine:?}");
            let forced = run(lacks, &["--force", set]);
            assert_eq!(frame_alone(&forced), frame_alone(&needed), "{set} {machine:?}");
            let left_out = run(needs, &["--ray-sets", &sets, "--leave-out", set]);
            assert_eq!(frame_alone(&left_out), frame_alone(&unneeded), "{set} {machine:?}");
            assert_eq!(
                run(needs, &["--ray-sets", &sets, "--force", set]),
                needed,
                "what is needed is not forced"
            );
            assert_eq!(run(lacks, &["--leave-out", set]), unneeded);
            let [entry] = left_out["forced"].as_array().expect("a list").as_slice() else {
                panic!("one entry")
            };
            assert_eq!((&entry["choice"], &entry["frame_time_ms"]), (&json!("out"), &Value::Null));
        }
    }
}

#[test]
fn what_is_forced_in_is_named_with_its_cost() {
    let dir = folder();
    let matte = room(&dir, "matte", "Ks 0 0 0", LIGHT);
    for (set, what, of_set) in [
        ("ao", "ambient_occlusion", &["ambient occlusion rays"][..]),
        ("mirror", "mirror", &["reflection rays", "reflection shadow rays"]),
        ("diffuse", "diffuse", &["diffuse rays", "diffuse shadow rays"]),
        ("soft-shadows", "soft_shadows", &["soft shadow rays"]),
    ] {
        let report = profile(&matte, &["--force", set]);
        let [cost] = report["forced"].as_array().expect("a list").as_slice() else { panic!("one entry") };
        assert_eq!((&cost["what"], &cost["choice"]), (&json!(what), &json!("in")));
        let times =
            of_set.iter().map(|pass| counter(&report, pass, "frame_time_ms").as_f64().expect("a time"));
        let (sum, said) = (times.sum::<f64>(), cost["frame_time_ms"].as_f64().expect("a time"));
        assert!((said / sum - 1.0).abs() < 1e-12, "{said} of {sum}");
        assert_eq!(why(&report, what), None);
    }
    let dark = room(&dir, "dark", "Ks 0 0 0", "lights = []");
    let soft = profile(&dark, &["--force", "soft-shadows"]);
    assert!(soft["notes"].to_string().contains("above and behind the camera"));
    let mirrors = profile(&dark, &["--force", "mirror"]);
    assert!(mirrors["notes"].to_string().contains("count as mirrors"));
    assert_eq!(
        passes(&mirrors),
        ["primary rays", "reflection rays", "output"],
        "nothing lights what they show"
    );
}

#[test]
fn without_shadow_rays_nothing_that_is_hit_sends_one() {
    let dir = folder();
    let shiny = room(&dir, "shiny", "illum 5", LIGHT);
    let unlit = profile(&shiny, &["--ray-sets", "mirror,diffuse", "--leave-out", "shadow-rays"]);
    assert_eq!(passes(&unlit), ["primary rays", "reflection rays", "diffuse rays", "output"]);
    let lit = profile(&shiny, &["--ray-sets", "mirror,diffuse"]);
    assert!(passes(&lit).contains(&"reflection shadow rays") && !passes(&lit).contains(&"shadow rays"));
}

#[test]
fn a_replay_equals_the_profile_and_threads_change_no_byte() {
    let dir = folder();
    let shiny = room(&dir, "shiny", "Ks 1 1 1\nNs 200", LIGHT);
    let options =
        [&ALL[..], &["--spp", "2", "--light-radius", "0.5", "--ao-radius", "4", "--ray-seed", "7"]].concat();
    let expected = profile(&shiny, &options);
    assert_eq!(passes(&expected).len(), 9);
    assert_eq!(expected["inputs"]["samples_per_pixel"], 2);
    let mut traces = Vec::new();
    for threads in ["1", "4"] {
        let with = [&options[..], &["--threads", threads]].concat();
        let path = trace(&dir, &format!("{threads}.rbt"), arg(&shiny), &with);
        let replayed = raybudget(["replay", arg(&path), "--format", "json", "--threads", threads]).json();
        assert_eq!(without_run(&replayed), expected);
        traces.push(std::fs::read(path).expect("a file"));
    }
    assert!(traces[0] == traces[1], "the same bytes");
    let other = [&options[..options.len() - 1], &["8"]].concat();
    let reseeded = std::fs::read(trace(&dir, "other.rbt", arg(&shiny), &other)).expect("a file");
    assert!(reseeded != traces[0], "another seed draws other rays");
    assert_eq!(rays(&profile(&shiny, &other), "diffuse rays"), rays(&expected, "diffuse rays"));
}

#[test]
fn a_scene_file_asks_as_the_options_do() {
    let dir = folder();
    let keys = "[rays]\nsoft_shadows = true\nmirror = true\nambient_occlusion = true\ndiffuse = true\nsamples = 2\nseed = 7\n\
                light_radius = 0.5\nambient_occlusion_radius = 4";
    let asks = profile(&room(&dir, "room", "illum 5", &format!("{LIGHT}\n{keys}")), &[]);
    let plain = room(&dir, "room", "illum 5", LIGHT);
    let sets = ["--ray-sets", "hard-shadows,soft-shadows,mirror,ao,diffuse", "--spp", "2", "--ray-seed", "7"];
    let radii = ["--light-radius", "0.5", "--ao-radius", "4"];
    assert_eq!(profile(&plain, &[&sets[..], &radii].concat()), asks);
    let asks = room(&dir, "room", "illum 5", &format!("{LIGHT}\n{keys}"));
    assert_eq!(
        passes(&profile(&asks, &["--ray-sets", "hard-shadows"])),
        ["primary rays", "shadow rays", "output"]
    );
}

#[test]
fn requests_without_meaning_are_refused() {
    let dir = folder();
    let rays = file(&dir, "rays.bin", [0_u8; 32]);
    let out = dir.path().join("out");
    let refused = |args: &[&str], expected: &[&str]| {
        let message = raybudget(args).refused();
        for expected in expected {
            assert!(message.contains(expected), "{args:?}: expected '{expected}' in:\n{message}");
        }
    };
    let with = |options: &[&'static str], expected: &[&str]| {
        refused(&[&["profile", "cornell"], options].concat(), expected);
    };
    with(
        &["--ray-sets", "glass"],
        &["--ray-sets", "hard-shadows, soft-shadows, mirror, glossy, ao, diffuse"],
    );
    with(&["--ray-sets", "ao", "--spp", "0"], &["--spp 0", "1 to 64", "give a number"]);
    with(&["--ray-sets", "ao", "--spp", "65"], &["--spp 65", "1 to 64"]);
    with(&["--ray-sets", "ao", "--light-radius", "1"], &["--light-radius", "add one of soft-shadows"]);
    with(&["--ray-sets", "soft-shadows", "--light-radius", "0"], &["--light-radius 0", "above 0"]);
    with(&["--ray-sets", "ao", "--ao-radius", "-1"], &["--ao-radius -1", "above 0"]);
    with(&["--ray-sets", "ao", "--ao-radius", "inf"], &["--ao-radius inf", "give a finite one"]);
    with(&["--force", "ao", "--leave-out", "ao"], &["give one of them"]);
    let of_list = ["trace", "cornell", "--rays", arg(&rays), "-o", arg(&out)];
    refused(&[&of_list[..], &["--ray-sets", "ao"]].concat(), &["--ray-sets", "closest hits alone"]);
    refused(&[&of_list[..], &["--force", "diffuse"]].concat(), &["--force diffuse", "closest hits alone"]);
    refused(&["render", "cornell", "-o", arg(&out), "--ray-sets", "ao"], &["hard shadow rays alone"]);
    assert!(!out.exists());
    for (keys, expected) in [
        ("[rays]\nglass = true", "unknown field `glass`"),
        ("[rays]\nsamples = 0", "rays.samples is 0, expected 1 to 64"),
        ("[rays]\nlight_radius = -1.0", "rays.light_radius is -1"),
        ("[rays]\nroughness = { mirror = 0.5, glossy = 0.4 }", "mirror not above glossy"),
        ("[rays]\nroughness = { max = 0.4 }", "unknown field `max`"),
    ] {
        let scene = room(&dir, "wrong", "illum 5", keys);
        refused(&["profile", arg(&scene)], &["wrong.toml", expected]);
    }
}

#[test]
fn a_table_of_costs_without_those_of_new_rays_serves_old_frames_alone() {
    let dir = folder();
    let costs =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/costs.toml")).expect("text");
    let (before, rest) = costs.split_once("[secondary]\n").expect("a table");
    let after = &rest[rest.find("\n[").expect("another table")..];
    let old = file(&dir, "old.toml", format!("{before}{after}"));
    let profile = |options: &[&str]| {
        let args = ["profile", "cornell", "--costs", arg(&old)];
        raybudget(args.iter().chain(&SIZE).chain(options))
    };
    profile(&[]).ok();
    let message = profile(&["--ray-sets", "ao"]).refused();
    assert!(message.contains("add a table [secondary]"), "{message}");
}
