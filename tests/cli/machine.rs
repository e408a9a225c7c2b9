//! `--set` and `--technique`: what the frame is replayed through.

use crate::support::{arg, file, folder, raybudget};
use serde_json::Value;

const FRAME: [&str; 6] = ["profile", "cornell", "--size", "40x24", "--format", "json"];

fn profile(machine: &[&str]) -> Value {
    raybudget(FRAME.iter().chain(machine)).json()
}

fn refused(machine: &[&str], expected: &[&str]) {
    let message = raybudget(FRAME.iter().chain(machine)).refused();
    for part in expected {
        assert!(message.contains(part), "{machine:?}: expected '{part}' in:\n{message}");
    }
}

#[test]
fn a_figure_that_is_set_is_named_hashed_counted_as_an_estimate_and_used() {
    let (plain, set) = (profile(&[]), profile(&["--set", "cache.uche.line=128"]));
    assert_eq!(plain["inputs"]["gpu"], "adreno-540");
    assert_eq!(set["inputs"]["gpu"], "adreno-540 with cache.uche.line=128");
    assert_ne!(set["inputs"]["hashes"]["gpu"], plain["inputs"]["hashes"]["gpu"]);
    assert_eq!(set["inputs"]["hashes"]["scene"], plain["inputs"]["hashes"]["scene"]);
    let misses = |report: &Value| report["counters"]["l2_misses"]["value"].as_u64().expect("a count");
    assert!(misses(&set) < misses(&plain), "a line of 128 B is fetched once for two of 64 B");
    let other = profile(&["--set", "cache.uche.line=32"]);
    assert_ne!(other["inputs"]["hashes"]["gpu"], set["inputs"]["hashes"]["gpu"]);
}

#[test]
fn the_last_of_several_figures_wins_and_all_are_named() {
    let set =
        profile(&["--set", "cache.uche.line=32", "--set", "clock.mhz=355", "--set", "cache.uche.line=128"]);
    let gpu = set["inputs"]["gpu"].as_str().expect("a name");
    assert!(gpu.contains("clock.mhz=355") && gpu.ends_with("cache.uche.line=128"), "{gpu}");
    let once = profile(&["--set", "clock.mhz=355", "--set", "cache.uche.line=128"]);
    assert_eq!(set["counters"], once["counters"]);
}

#[test]
fn a_figure_that_there_is_not_or_that_cannot_be_is_refused() {
    refused(&["--set", "cache.uche.line"], &["--set cache.uche.line", "expected KEY=VALUE"]);
    refused(&["--set", "cache.l9.line=64"], &["no figure 'cache.l9.line'", "cache.uche.line"]);
    refused(&["--set", "cache.uche=64"], &["no figure 'cache.uche'"]);
    refused(&["--set", "identity.name=\"x\""], &["no figure 'identity.name'"]);
    refused(&["--set", "cache.uche.line=wide"], &["'wide' is not a value"]);
    refused(&["--set", "cache.uche.line=\"wide\""], &["--set cache.uche.line"]);
    refused(&["--set", "cache.uche.line=0"], &["cache.uche.line", "16 to 4096"]);
    refused(&["--set", "cache.uche.line=65"], &["cache.uche.line"]);
    refused(&["--set", "clock.mhz=nan"], &["clock.mhz"]);
}

#[test]
fn a_technique_from_a_file_is_the_built_in_one_and_a_broken_one_is_refused_with_its_line() {
    let dir = folder();
    for technique in gpumodel::TECHNIQUES {
        let path = file(&dir, "mine.toml", technique.toml);
        let [by_name, by_path] = [technique.name, arg(&path)]
            .map(|technique| profile(&["--technique", technique, "--force", "mirror"]));
        assert_eq!(by_name["counters"], by_path["counters"], "{}", technique.name);
    }
    refused(
        &["--technique", "no.toml"],
        &["--technique no.toml", "fragment, compute, hybrid", "configs/techniques"],
    );
    refused(&["--technique", arg(dir.path())], &["cannot"]);
    let line = |text: &str, part: &str| {
        1 + text.lines().position(|line| line.contains(part)).unwrap_or_else(|| panic!("{part} in {text}"))
    };
    let good =
        gpumodel::TECHNIQUES.iter().find(|technique| technique.name == "compute").expect("built in").toml;
    let cases = [
        (good.replace("\"compute\"\nprimary", "\"vertex\"\nprimary"), "vertex", "`fragment` or `compute`"),
        (good.replace("primary = true", "primary = true\nweather = 3"), "weather", "weather"),
        (good.replace("[8, 8]", "[8, 0]"), "[8, 0]", "workgroup"),
        (good.replace("primary = true", "primary = "), "primary = ", ""),
    ];
    for (text, part, expected) in cases {
        let path = file(&dir, "broken.toml", &text);
        refused(&["--technique", arg(&path)], &[&format!("broken.toml:{}", line(&text, part)), expected]);
    }
    let empty = file(&dir, "empty.toml", "");
    refused(&["--technique", arg(&empty)], &["empty.toml"]);
}

#[test]
fn a_table_of_energies_is_used_hashed_and_refused_with_its_line() {
    let dir = folder();
    let text = gpumodel::EnergyTable::builtin_text();
    let with = |text: &str| {
        let path = file(&dir, "energy.toml", text);
        profile(&["--energy", arg(&path)])
    };
    let plain = profile(&[]);
    let same = with(text);
    assert_eq!(same["counters"], plain["counters"]);
    assert_eq!(same["inputs"]["hashes"], plain["inputs"]["hashes"]);
    let dearer = with(&text.replace("alu_operation = { value = 2.3", "alu_operation = { value = 23"));
    assert_ne!(dearer["inputs"]["hashes"]["energy"], plain["inputs"]["hashes"]["energy"]);
    let of = |report: &Value| {
        let causes = report["energy"]["causes"].as_array().expect("causes").iter();
        let mj: Vec<f64> = causes.map(|cause| cause["mj"].as_f64().expect("a figure")).collect();
        let frame = report["counters"]["energy_mj"]["value"].as_f64().expect("a figure");
        assert!((mj.iter().sum::<f64>() - frame).abs() <= 1e-12 * frame, "{mj:?} {frame}");
        let shares = report["energy"]["causes"].as_array().expect("causes").iter();
        let shares: f64 = shares.map(|cause| cause["share"].as_f64().expect("a share")).sum();
        assert!((shares - 1.0).abs() < 1e-12);
        (mj[0], frame)
    };
    let ((alu, frame), (dear_alu, dear_frame)) = (of(&plain), of(&dearer));
    assert!((dear_alu / alu - 10.0).abs() < 1e-12 && (dear_frame - frame - 9.0 * alu).abs() < 1e-9 * frame);
    let path = file(&dir, "energy.toml", text.replacen("name = \"10nm\"", "name = \"10um\"", 1));
    refused(&["--energy", arg(&path)], &["energy.process: is '10nm'", "energy.toml has", "10um"]);
    let path = file(&dir, "energy.toml", "nonsense = 1\n");
    refused(&["--energy", arg(&path)], &["energy.toml"]);
}
