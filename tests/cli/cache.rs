//! `raybudget cache`: known counts, and their form.

use crate::support::{arg, file, folder, raybudget};
use cachesim::synthetic::{Stream, lines};
use std::path::PathBuf;
use tempfile::TempDir;

const LEVELS: &str = "
[[level]]
name = \"L1\"
size = 16384
line = 64
ways = 4
policy = \"lru\"

[[level]]
name = \"L2\"
size = 1048576
line = 64
ways = 16
policy = \"lru\"
";

fn stream(dir: &TempDir, stream: Stream, count: usize) -> PathBuf {
    let bytes: Vec<u8> =
        lines(stream, count).iter().flat_map(|line| (line.get() * 64).to_le_bytes()).collect();
    file(dir, "stream.u64", bytes)
}

#[test]
fn the_golden_counts_come_out_of_the_command() {
    let dir = folder();
    let levels = file(&dir, "levels.toml", LEVELS);
    for (name, count, misses) in [
        (Stream::Bvh, 10_000, [2_785, 252]),
        (Stream::Bvh, 1_000_000, [193_614, 6_767]),
        (Stream::Rnd, 100_000, [99_890, 94_233]),
        (Stream::Seq, 1_000_000, [250_000, 250_000]),
    ] {
        let addresses = stream(&dir, name, count);
        let counts =
            raybudget(["cache", arg(&addresses), "--levels", arg(&levels), "--format", "json"]).json();
        let level = |index: usize, key: &str| counts["levels"][index][key].as_u64().expect("a count");
        assert_eq!([level(0, "misses"), level(1, "misses")], misses);
        assert_eq!(level(0, "accesses"), count as u64);
        assert_eq!(level(0, "hits"), count as u64 - misses[0]);
        assert_eq!(level(1, "accesses"), misses[0]);
        assert_eq!(counts["memory"]["reads"], misses[1]);
        assert_eq!(counts["memory"]["writes"], 0);
        assert!(counts["run"]["wall_s"].as_f64().expect("a time") > 0.0);
        assert_eq!(counts["levels"][0]["name"], "L1");
    }
}

#[test]
fn the_curve_ends_at_the_distinct_lines_and_agrees_with_a_simulated_cache() {
    let dir = folder();
    let addresses = stream(&dir, Stream::Bvh, 100_000);
    let full = "[[level]]\nname = \"all\"\nsize = 8192\nline = 64\nways = \"full\"\npolicy = \"lru\"\n";
    let levels = file(&dir, "full.toml", full);
    let args = ["cache", arg(&addresses), "--levels", arg(&levels), "--curve", "--format"];
    let counts = raybudget(args.iter().chain(&["json"])).json();
    let points = counts["curve"]["points"].as_array().expect("points");
    let at = |lines: u64| {
        points.iter().rfind(|point| point["lines"].as_u64().expect("a count") <= lines).expect("a point")
    };
    assert_eq!(at(8192 / 64)["misses"], counts["levels"][0]["misses"]);
    assert_eq!(points.last().expect("a point")["misses"], counts["curve"]["distinct_lines"]);
    assert_eq!(counts["curve"]["kind"], "exact");
    let first = &counts["curve"]["first_level"];
    assert_eq!(first["estimated_misses"].as_f64(), first["misses"].as_u64().map(|misses| misses as f64));
    let csv = raybudget(args.iter().chain(&["csv"])).ok();
    assert_eq!(csv.lines().count(), points.len() + 1);
    assert!(csv.starts_with("lines,bytes,misses,miss_ratio\n"), "{csv}");
    let text = raybudget(args.iter().chain(&["text"])).ok();
    assert!(text.contains("distinct lines"), "{text}");
}

#[test]
fn a_curve_estimates_the_misses_of_the_first_level_and_tells_the_error() {
    let dir = folder();
    let addresses = stream(&dir, Stream::Bvh, 1_000_000);
    let levels = file(&dir, "levels.toml", LEVELS);
    let run = |kind: &str, levels: &str, format: &str| {
        raybudget(["cache", arg(&addresses), "--levels", levels, kind, "--format", format])
    };
    for (kind, name) in [("--curve=exact", "exact"), ("--curve=aet", "aet")] {
        let curve = run(kind, arg(&levels), "json").json()["curve"].take();
        assert_eq!((&curve["kind"], &curve["accesses"]), (&name.into(), &1_000_000.into()));
        let first = &curve["first_level"];
        assert_eq!((&first["name"], &first["misses"]), (&"L1".into(), &193_614.into()));
        assert_eq!((&first["sets"], &first["ways"]), (&64.into(), &4.into()));
        let error = first["miss_ratio_error"].as_f64().expect("a number");
        let misses = first["estimated_misses"].as_f64().expect("a number");
        assert!((misses - 193_614.0 - error * 1e6).abs() < 1e-3, "{kind}: {error}");
        assert!((-0.045..-0.035).contains(&error), "{kind}: {error}");
    }
    let text = run("--curve=aet", arg(&levels), "text").ok();
    assert!(text.contains("(aet)") && text.contains("estimate for L1 (64 sets, 4 ways): "), "{text}");
    let fifo = file(&dir, "fifo.toml", LEVELS.replacen("lru", "fifo", 1));
    assert!(run("--curve", arg(&fifo), "json").json()["curve"]["first_level"].is_null());
    assert!(run("--curve=shards", arg(&levels), "json").refused().contains("exact, aet"));
}

#[test]
fn writes_reach_memory_when_their_lines_are_evicted() {
    let dir = folder();
    let one_line = "[[level]]\nname = \"L1\"\nsize = 64\nline = 64\nways = 1\npolicy = \"lru\"\n";
    let levels = file(&dir, "one.toml", one_line);
    let addresses = file(&dir, "a.din", "1 0\n0 40\n0 0\n");
    let counts = raybudget(["cache", arg(&addresses), "--levels", arg(&levels), "--format", "json"]).json();
    assert_eq!(counts["levels"][0]["writes"], 1);
    assert_eq!(counts["levels"][0]["misses"], 3);
    assert_eq!(counts["memory"]["writes"], 1);
}

#[test]
fn wrong_levels_and_addresses_are_refused_with_their_place() {
    let dir = folder();
    let good = file(&dir, "good.toml", LEVELS);
    let din = file(&dir, "good.din", "0 40\n");
    let refused = |addresses: &str, levels: &str, expected: &[&str]| {
        let message = raybudget(["cache", addresses, "--levels", levels]).refused();
        expected.iter().for_each(|part| assert!(message.contains(part), "{part}: {message}"));
    };
    let unknown = file(&dir, "unknown.toml", LEVELS.replace("ways = 4", "wais = 4"));
    refused(arg(&din), arg(&unknown), &["unknown.toml:6", "wais"]);
    let empty = file(&dir, "empty.toml", LEVELS.replace("size = 16384", "size = 0"));
    refused(arg(&din), arg(&empty), &["empty.toml", "L1", "0 bytes"]);
    let three = file(&dir, "three.toml", LEVELS.replace("ways = 4", "ways = 3"));
    refused(arg(&din), arg(&three), &["three.toml", "L1", "3 ways"]);
    refused(arg(&din), "no.toml", &["no.toml: cannot open"]);
    refused("no.din", arg(&good), &["no.din: cannot open"]);
    refused(arg(&file(&dir, "a.txt", "")), arg(&good), &["a.txt", ".din, .csv or .u64"]);
    refused(arg(&file(&dir, "a.din", "")), arg(&good), &["a.din", "no accesses"]);
    refused(arg(&file(&dir, "b.din", "0 40\nx\n")), arg(&good), &["b.din:2"]);
    refused(arg(&file(&dir, "c.u64", [1, 2, 3])), arg(&good), &["c.u64"]);
}
