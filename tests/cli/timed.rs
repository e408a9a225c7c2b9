//! `--fidelity timed`, and both rungs at the extremes of what a GPU can be.

use crate::support::{arg, file, folder, raybudget};
use serde_json::Value;

const RUNGS: [&str; 2] = ["replay", "timed"];

fn answer(args: &[&str]) -> Value {
    raybudget(args.iter().chain(&["--format", "json"])).json()
}

/// All figures of the frame and its passes: what a rung says, without what the run cost.
fn figures(report: &Value) -> [&Value; 3] {
    ["counters", "passes", "bounds"].map(|part| &report[part])
}

fn frame_time_ms(of: &Value) -> f64 {
    of["counters"]["frame_time_ms"]["value"].as_f64().expect("a time")
}

#[test]
fn simulated_time_depends_neither_on_threads_nor_on_whether_the_frame_is_traced_or_read() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    let frame = ["--size", "100x70", "--accel", "kd", "--traversal", "push-down"];
    raybudget(["trace", "teapot", "-o", arg(&trace)].iter().chain(&frame)).ok();
    for gpu in ["adreno-540", "mali-g715"] {
        let machine = ["--fidelity", "timed", "--gpu", gpu];
        let profile = answer(&[&["profile", "teapot", "--threads", "1"], &frame[..], &machine].concat());
        assert_eq!(profile["run"]["fidelity"], "timed");
        for threads in ["1", "2", "3"] {
            let replay = answer(&[&["replay", arg(&trace), "--threads", threads][..], &machine].concat());
            assert_eq!(figures(&replay), figures(&profile), "{gpu}, {threads} threads");
        }
    }
}

#[test]
fn a_list_of_rays_can_be_simulated() {
    let dir = folder();
    let ray = |index: u32| [0.0, 1.0, 3.0, 1e-4, 0.01 * index as f32 - 0.5, 0.0, -1.0, 1e9_f32];
    let bytes: Vec<u8> = (0..100).flat_map(ray).flat_map(f32::to_le_bytes).collect();
    let (rays, trace) = (file(&dir, "rays.bin", bytes), dir.path().join("t.rbt"));
    raybudget(["trace", "cornell", "-o", arg(&trace), "--rays", arg(&rays)]).ok();
    let [replay, timed] = RUNGS.map(|rung| answer(&["replay", arg(&trace), "--fidelity", rung]));
    assert_eq!(timed["counters"]["rays"], replay["counters"]["rays"]);
    let (quick, simulated) = (frame_time_ms(&replay), frame_time_ms(&timed));
    assert!(simulated > 0.0 && simulated.is_finite());
    assert!((0.25..4.0).contains(&(quick / simulated)), "{quick} ms and {simulated} ms");
}

#[test]
fn times_of_passes_add_up_to_the_frame_for_every_technique_on_both_rungs() {
    for technique in ["fragment", "compute", "hybrid"] {
        for rung in RUNGS {
            let args =
                ["profile", "cornell", "--size", "64x48", "--technique", technique, "--fidelity", rung];
            let report = answer(&args);
            let passes = report["passes"].as_array().expect("passes");
            let sum: f64 = passes.iter().map(frame_time_ms).sum();
            let whole = frame_time_ms(&report);
            assert!(whole > 0.0 && (sum / whole - 1.0).abs() < 1e-9, "{technique} {rung}: {sum} of {whole}");
            for pass in passes {
                assert!(frame_time_ms(pass) >= 0.0, "{technique} {rung}: {pass}");
            }
        }
    }
}

/// A small frame on a GPU of which figures are set.
fn time(rung: &str, gpu: &str, figures: &[String]) -> f64 {
    let mut args = vec!["profile", "teapot", "--size", "48x32", "--gpu", gpu, "--fidelity", rung];
    figures.iter().for_each(|figure| args.extend(["--set", figure]));
    frame_time_ms(&answer(&args))
}

const SMALLEST: [&str; 12] = [
    "shader_cores.warp_slots=1",
    "registers.granularity=1",
    "cache.uche.size=64",
    "cache.uche.ways=\"full\"",
    "cache.uche.banks=1",
    "cache.uche.mshrs=1",
    "cache.tp_l1.size=64",
    "cache.tp_l1.mshrs=1",
    "load_store.lines_in_flight=1",
    "texture.lines_in_flight=1",
    "dram.channels=1",
    "dram.queue=1",
];

#[test]
fn the_least_and_the_fastest_that_a_gpu_can_be_have_finite_times() {
    for rung in RUNGS {
        let plain = time(rung, "adreno-540", &[]);
        for set in
            [&SMALLEST[..1], &SMALLEST[..2], &SMALLEST[2..5], &SMALLEST[5..6], &SMALLEST[8..9], &SMALLEST]
        {
            let set: Vec<String> = set.iter().map(|&figure| figure.to_owned()).collect();
            if set.len() == 1 && set[0].contains("warp_slots") {
                // One slot is fewer than the two warps that share registers.
                let args = ["profile", "teapot", "--set", &set[0], "--fidelity", rung];
                assert!(raybudget(args).refused().contains("registers.granularity"));
                continue;
            }
            let time = time(rung, "adreno-540", &set);
            assert!(time.is_finite() && time > plain, "{rung} {set:?}: {time} ms, plain {plain} ms");
        }
        for figure in [
            "clock.mhz=10000000",
            "clock.mhz=0.000001",
            "dram.peak_gbs=0.000000001",
            "dram.peak_gbs=10000000",
        ] {
            let time = time(rung, "adreno-540", &[figure.to_owned()]);
            assert!(time.is_finite() && time > 0.0, "{rung} {figure}: {time} ms");
        }
        let slow: Vec<String> = SMALLEST
            .iter()
            .chain(&["clock.mhz=10000000", "dram.peak_gbs=0.000000001"])
            .map(|&figure| figure.to_owned())
            .collect();
        let time = time(rung, "adreno-540", &slow);
        assert!(time.is_finite() && time > 1e6 * plain, "{rung}: {time} ms");
    }
}

/// More of one thing does not make a frame slower. The default rung's time follows from a formula and may rise by rounding alone; a
/// simulated one may rise by 1 %, for an earlier answer can change the order of all that follows.
#[test]
fn more_of_one_thing_makes_no_frame_slower() {
    let sweeps: [(&str, [&str; 5]); 6] = [
        ("dram.peak_gbs", ["0.1", "1", "5", "29.8", "200"]),
        ("clock.mhz", ["10", "100", "355", "710", "2000"]),
        ("cache.uche.bytes_per_clock", ["4", "16", "32", "64", "256"]),
        ("load_store.bytes_per_clock", ["1", "4", "16", "64", "256"]),
        ("load_store.lines_in_flight", ["1", "4", "16", "64", "256"]),
        ("cache.uche.mshrs", ["1", "4", "16", "64", "256"]),
    ];
    for (rung, rise) in [("replay", 1.0 + 1e-9), ("timed", 1.01)] {
        for (key, values) in sweeps {
            let times = values.map(|value| time(rung, "adreno-540", &[format!("{key}={value}")]));
            assert!(times.iter().all(|time| time.is_finite() && *time > 0.0), "{rung} {key}: {times:?}");
            assert!(times.windows(2).all(|pair| pair[1] <= pair[0] * rise), "{rung} {key}: {times:?}");
            assert!(times[4] < times[0], "{rung} {key} changes nothing: {times:?}");
        }
    }
}
