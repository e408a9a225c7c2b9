//! Does `replay --miss-trace` write every request to memory, in the forms that simulators of DRAM read?

use crate::support::{arg, folder, names_in, raybudget};
use std::fs;
use std::path::{Path, PathBuf};

fn recorded(folder: &Path) -> PathBuf {
    let trace = folder.join("teapot.rbt");
    raybudget(["trace", "teapot", "--size", "64x48", "-o", arg(&trace)]).ok();
    trace
}

#[test]
fn the_requests_are_those_of_the_report_in_order_of_time() {
    let folder = folder();
    let trace = recorded(folder.path());
    let misses = folder.path().join("misses.txt");
    let report = raybudget([
        "replay",
        arg(&trace),
        "--fidelity",
        "timed",
        "--miss-trace",
        arg(&misses),
        "--format",
        "json",
    ])
    .json();
    let text = fs::read_to_string(&misses).expect("it was written");
    let (mut reads, mut writes, mut last) = (0_u64, 0_u64, 0_u64);
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let [address, kind, cycle] = words[..] else { panic!("{line}") };
        let address =
            u64::from_str_radix(address.strip_prefix("0x").expect("hexadecimal"), 16).expect("an address");
        match kind {
            "READ" => {
                assert!(address.is_multiple_of(64), "lines of 64 bytes: {line}");
                reads += 1;
            }
            "WRITE" => writes += 1,
            _ => panic!("{line}"),
        }
        let cycle: u64 = cycle.parse().expect("a cycle");
        assert!(cycle >= last, "{line} after {last}");
        last = cycle;
    }
    // Lines that are asked for again while they are on their way come once.
    let read_bytes = report["counters"]["dram_read_bytes"]["value"].as_u64().expect("a count");
    assert!(
        reads * 64 <= read_bytes && reads * 64 > read_bytes * 9 / 10,
        "{reads} reads of {read_bytes} bytes"
    );
    assert!(writes > 0, "tile memory is written out");

    let other = folder.path().join("other.txt");
    let format = ["--miss-trace-format", "ramulator2"];
    raybudget(
        ["replay", arg(&trace), "--fidelity", "timed", "--miss-trace", arg(&other)].into_iter().chain(format),
    )
    .ok();
    let other = fs::read_to_string(&other).expect("it was written");
    assert_eq!(other.lines().count(), text.lines().count());
    assert!(other.lines().all(|line| line.starts_with("LD 0x") || line.starts_with("ST 0x")));
}

#[test]
fn without_times_there_is_no_order_of_requests_and_no_file() {
    let folder = folder();
    let trace = recorded(folder.path());
    let misses = folder.path().join("misses.txt");
    for rung in [&[][..], &["--fidelity", "replay"]] {
        let args = ["replay", arg(&trace), "--miss-trace", arg(&misses)];
        let message = raybudget(args.iter().chain(rung)).refused();
        assert!(message.contains("--fidelity"), "{message}");
    }
    assert_eq!(names_in(folder.path()), ["teapot.rbt"]);
}
