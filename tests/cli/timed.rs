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
    for report in [&replay, &timed] {
        assert_eq!(report["counters"]["rays"]["value"], 100);
    }
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

/// Milliseconds of a small frame on the Adreno 540 of which figures are set. It has 48 warps per core: with a dozen, of which ten are
/// resident, the order in which the last ones end would decide.
fn time(rung: &str, figures: &[String]) -> f64 {
    let mut args = vec!["profile", "teapot", "--size", "96x64", "--fidelity", rung];
    figures.iter().for_each(|figure| args.extend(["--set", figure]));
    frame_time_ms(&answer(&args))
}

const SMALLEST: [&str; 13] = [
    "shader_cores.warp_slots=1",
    "registers.granularity=1",
    "cache.uche.size=64",
    "cache.uche.ways=\"full\"",
    "cache.uche.banks=1",
    "cache.uche.mshrs=1",
    "cache.tp_l1.size=64",
    "cache.tp_l1.banks=1",
    "cache.tp_l1.mshrs=1",
    "load_store.lines_in_flight=1",
    "texture.lines_in_flight=1",
    "dram.channels=1",
    "dram.queue=1",
];

#[test]
fn the_least_and_the_fastest_that_a_gpu_can_be_have_finite_times() {
    let alone = ["profile", "teapot", "--set", SMALLEST[0]];
    assert!(raybudget(alone).refused().contains("registers.granularity"), "two warps share registers");
    let owned = |figures: &[&str]| figures.iter().map(|&figure| figure.to_owned()).collect::<Vec<_>>();
    for rung in RUNGS {
        let plain = time(rung, &[]);
        for set in [&SMALLEST[..2], &SMALLEST[2..5], &SMALLEST[9..10], &SMALLEST] {
            let time = time(rung, &owned(set));
            assert!(time.is_finite() && time > plain, "{rung} {set:?}: {time} ms, plain {plain} ms");
        }
        let extremes = [
            "clock.mhz=10000000",
            "clock.mhz=0.000001",
            "dram.peak_gbs=0.000000001",
            "dram.peak_gbs=10000000",
        ];
        for figure in extremes {
            let time = time(rung, &owned(&[figure]));
            assert!(time.is_finite() && time > 0.0, "{rung} {figure}: {time} ms");
        }
        let time = time(rung, &owned(&[&SMALLEST[..], &["clock.mhz=10000000", extremes[2]]].concat()));
        assert!(time.is_finite() && time > 1e6 * plain, "{rung}: {time} ms");
    }
}

/// Checks that more of one thing makes no frame slower. A time may rise by 1 %, for it can change the order of all that follows: on
/// the default rung that of the warps, on the other one that of all events. (Of one replay the default rung's time rises by
/// rounding alone, which `verify stability` checks.)
fn check_falls(key: &str, values: [&str; 5]) {
    for rung in RUNGS {
        let times = values.map(|value| time(rung, &[format!("{key}={value}")]));
        assert!(times.iter().all(|time| time.is_finite() && *time > 0.0), "{rung} {key}: {times:?}");
        assert!(times.windows(2).all(|pair| pair[1] <= 1.01 * pair[0]), "{rung} {key}: {times:?}");
        assert!(times[4] < times[0], "{rung} {key} changes nothing: {times:?}");
    }
}

#[test]
fn more_bandwidth_clock_or_lines_in_flight_make_no_frame_slower() {
    check_falls("dram.peak_gbs", ["0.1", "1", "5", "29.8", "200"]);
    check_falls("clock.mhz", ["10", "100", "355", "710", "2000"]);
    check_falls("cache.uche.bytes_per_clock", ["4", "16", "32", "64", "256"]);
    check_falls("load_store.bytes_per_clock", ["1", "4", "16", "64", "256"]);
    check_falls("load_store.lines_in_flight", ["1", "4", "16", "64", "256"]);
}

#[test]
fn more_misses_in_flight_make_no_frame_slower() {
    check_falls("cache.uche.mshrs", ["1", "4", "16", "64", "256"]);
}
