//! A trace from another renderer: is it replayed when it is sound, and refused with its place when it is not?
//!
//! The renderers are the examples beside the writers in `tracer/contrib`. Tests go without one where its language is missing, and say so.

use crate::support::{arg, file, folder, raybudget, without_run};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;
use tracer::{EncodedTile, Op, Step, Tile, TileSource, TraceFile, TraceWriter};

/// Traces by the example in C, built as C and as C++, and by the one in Python.
fn traces(dir: &TempDir) -> Vec<PathBuf> {
    let contrib = Path::new(env!("CARGO_MANIFEST_DIR")).join("tracer/contrib");
    let mut traces = Vec::new();
    for (compiler, standard, language) in [("cc", "-std=c99", "c"), ("c++", "-std=c++11", "c++")] {
        if is_there(compiler, "--version") {
            let program = dir.path().join(format!("example-{language}"));
            // Without fused operations all of them round alike.
            let flags =
                ["-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-x", language, "-o"];
            run(Command::new(compiler)
                .arg(standard)
                .args(flags)
                .arg(&program)
                .arg(contrib.join("example.c")));
            traces.push(dir.path().join(format!("{language}.rbt")));
            run(Command::new(program).arg(traces.last().expect("one")));
        }
    }
    if is_there("python3", "-cimport sys; sys.exit(sys.version_info < (3, 9))") {
        traces.push(dir.path().join("python.rbt"));
        run(Command::new("python3")
            .arg("-B")
            .arg(contrib.join("example.py"))
            .arg(traces.last().expect("one")));
    }
    traces
}

fn is_there(program: &str, argument: &str) -> bool {
    let run = Command::new(program).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = run.is_ok_and(|status| status.success());
    if !there {
        eprintln!("skipped: {program} is not there or too old");
    }
    there
}

fn run(command: &mut Command) {
    let output = command.output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{command:?}: {said}");
}

fn tiles(trace: &TraceFile) -> Vec<Tile> {
    let tile = |index| {
        let mut tile = Tile::default();
        trace.tile(index, &mut tile).expect("a sound tile");
        tile
    };
    (0..trace.header().frame.tiles()).map(tile).collect()
}

#[test]
fn the_examples_in_c_and_python_write_the_same_trace_and_its_steps_lead_to_its_hits() {
    let dir = folder();
    let traces: Vec<TraceFile> =
        traces(&dir).iter().map(|path| TraceFile::open(path).expect("a sound file")).collect();
    let Some(first) = traces.first() else { return };
    let found = tiles(first);
    for other in &traces[1..] {
        assert_eq!((other.header(), other.topology()), (first.header(), first.topology()));
        assert!(tiles(other) == found);
        assert_eq!(other.steps(), first.steps());
    }
    let [mut hits, mut lit] = [0, 0];
    for tile in &found {
        for (set, rays) in tile.ray_sets.iter().enumerate() {
            for (ray, &hit) in rays.hits.iter().enumerate() {
                let steps = &rays.steps[rays.range(ray)];
                let tests = |step: &Step| {
                    step.op() == Op::Primitive && first.topology().references[step.id() as usize] == hit
                };
                assert!(
                    hit == tracer::NO_HIT || steps.iter().any(tests),
                    "the triangle that is hit is tested"
                );
                let is_left = |step: &Step| step.op() != Op::Node || step.id() == 0 || step.id() % 2 == 1;
                assert!(steps.iter().all(is_left), "pairs are named by the left node");
                hits += usize::from(set == 0 && hit != tracer::NO_HIT);
                lit += usize::from(set == 1 && hit == tracer::NO_HIT && !steps.is_empty());
            }
        }
    }
    // The hills fill more than half of the picture, and the light is low enough for some to lie in the shadow of others.
    assert!((1500..3500).contains(&hits) && lit > hits / 2 && lit < hits, "{hits} hits, {lit} in the light");
}

#[test]
fn a_trace_of_each_example_is_replayed_with_the_same_counters() {
    let dir = folder();
    let reports: Vec<Value> = traces(&dir)
        .iter()
        .map(|trace| without_run(&raybudget(["replay", arg(trace), "--format", "json"]).json()))
        .collect();
    let Some(first) = reports.first() else { return };
    assert!(reports.iter().all(|report| report == first));
    let counter = |id: &str| first["counters"][id]["value"].as_f64().expect("a figure");
    let rays = counter("rays");
    assert!(rays > 70.0 * 64.0 && rays < 2.0 * 70.0 * 64.0, "{rays}");
    assert!(counter("node_fetches_per_ray") > 1.0 && counter("primitive_tests_per_ray") > 0.5);
    assert!(counter("frame_time_ms") > 0.0 && counter("dram_read_bytes") > 0.0);
    assert_eq!(first["inputs"]["scene"], "hills");
}

/// The message of a replay of `bytes`, which it refuses with the file's name and an offset.
fn refused(dir: &TempDir, bytes: &[u8]) -> String {
    let bad = file(dir, "bad.rbt", bytes);
    let message = raybudget(["replay", arg(&bad)]).refused();
    assert!(message.contains("bad.rbt") && message.contains("byte "), "{message}");
    message
}

#[test]
fn a_malformed_trace_is_refused_with_the_file_and_the_offset() {
    let dir = folder();
    for path in traces(&dir) {
        let good = fs::read(&path).expect("a trace");
        for place in [9, 40, good.len() / 3, good.len() - 60, good.len() - 30] {
            let mut flipped = good.clone();
            flipped[place] ^= 1 << (place % 8);
            refused(&dir, &flipped);
        }
        for length in [30, good.len() / 2, good.len() - 1] {
            refused(&dir, &good[..length]);
        }
        // With sound checksums: a step that names a node which is not there, and a hit of such a triangle.
        let trace = TraceFile::open(&path).expect("a sound file");
        let nodes = trace.topology().nodes.len() as u32;
        let forged = dir.path().join("forged.rbt");
        for (step, hit, problem) in [
            (Step::new(Op::Node, nodes), 0, "a Node step with id"),
            (Step::new(Op::Node, 0), 128, "a hit of a triangle that is not among the 128"),
        ] {
            let mut writer =
                TraceWriter::create(&forged, trace.header(), trace.topology()).expect("a sound header");
            for mut tile in tiles(&trace) {
                tile.ray_sets[0].steps[0] = step;
                tile.ray_sets[0].hits[0] = hit;
                writer
                    .write_tile(&EncodedTile::new(&tile, trace.header()).expect("it fits"))
                    .expect("written");
            }
            writer.finish(0).expect("written");
            let message = refused(&dir, &fs::read(&forged).expect("a file"));
            assert!(message.contains(problem), "{message}");
        }
    }
}

#[test]
fn an_unknown_key_of_the_header_is_refused() {
    if !is_there("python3", "-cimport sys; sys.exit(sys.version_info < (3, 9))") {
        return;
    }
    let dir = folder();
    let contrib = Path::new(env!("CARGO_MANIFEST_DIR")).join("tracer/contrib");
    let bad = dir.path().join("bad.rbt");
    let script = "import sys; sys.path.insert(0, sys.argv[1]); from rbt_writer import *\n\
        h = Header('g', 's', 1, [RaySet('primary')], 'bvh', 'stack', 'pair', 'while-while', rays=1, more={'colour': 1})\n\
        with Writer(sys.argv[2], h, Tree([leaf(0, 1)], [0], 1)) as w:\n \
            t = w.tile(0); t.begin_ray(0, 0); t.step(NODE, 0); t.end_ray(MISS); w.write_tile(t); w.finish()";
    run(Command::new("python3").args(["-B", "-c", script]).arg(contrib).arg(&bad));
    let message = raybudget(["replay", arg(&bad)]).refused();
    assert!(
        message.contains("bad.rbt")
            && message.contains("byte 12")
            && message.contains("unknown field `colour`"),
        "{message}"
    );
}
