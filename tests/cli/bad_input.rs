//! What cannot be done is refused with one clear message, exit code 2, and nothing written.

use crate::support::{arg, file, folder, names_in, raybudget};
use std::fs;

/// The message of a run that must be refused, checked for `expected` parts.
fn refused(args: &[&str], expected: &[&str]) {
    let message = raybudget(args).refused();
    for part in expected {
        assert!(message.contains(part), "{args:?}: expected '{part}' in:\n{message}");
    }
}

#[test]
fn sizes_that_cannot_be_are_refused_with_the_limit_and_the_reason() {
    refused(&["profile", "cornell", "--size", "0x0"], &["--size 0x0", "at least 1x1"]);
    refused(
        &["profile", "cornell", "--size", "100000x100000"],
        &["--size 100000x100000", "at most 16384", "smaller"],
    );
    refused(&["profile", "cornell", "--size", "16384x16384"], &["67108864 pixels", "memory"]);
    refused(&["profile", "cornell", "--size", "big"], &["WIDTHxHEIGHT"]);
}

#[test]
fn pairs_of_structure_and_traversal_that_do_not_exist_are_refused_with_those_that_do() {
    refused(
        &["profile", "cornell", "--accel", "kd", "--traversal", "parent-link"],
        &["--accel kd", "stack, restart, push-down, backtrack"],
    );
    refused(
        &["profile", "cornell", "--traversal", "push-down"],
        &["--accel bvh", "stack, parent-link, restart-trail"],
    );
}

#[test]
fn options_out_of_range_are_refused() {
    refused(&["profile", "cornell", "--ct", "-1"], &["Ct = -1"]);
    refused(&["profile", "cornell", "--ct", "nan"], &["Ct = NaN"]);
    refused(&["profile", "cornell", "--ci", "0"], &["Ci = 0"]);
    refused(&["profile", "cornell", "--splits", "perfect"], &["--splits", "--accel kd"]);
    refused(&["profile", "cornell", "--accel", "kd", "--empty-bonus", "0"], &["bonus 0"]);
    refused(&["profile", "cornell", "--accel", "kd", "--max-depth", "65"], &["65", "at most 64"]);
    refused(
        &["profile", "cornell", "--traversal", "restart-trail", "--short-stack", "1000000"],
        &["short stack of 1000000"],
    );
    refused(&["profile", "cornell", "--threads", "0"], &["--threads", "1..=1024"]);
    refused(&["profile", "cornell", "--layout", "tight"], &["--layout", "padded, compact, split"]);
    refused(&["profile", "cornell", "--colour"], &["--colour"]);
    refused(&["frobnicate"], &["frobnicate"]);
}

#[test]
fn scenes_that_are_none_are_refused() {
    let dir = folder();
    refused(&["profile", "cornel"], &["cornel", "cornell", "atrium"]);
    refused(&["profile", arg(dir.path())], &["folder"]);
    let cases: [(&str, &[u8], &str); 7] = [
        ("nan.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "nan.obj:2"),
        ("range.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "range.obj:4"),
        ("faceless.obj", b"v 0 0 0\n", "faceless.obj"),
        ("nothing.obj", b"", "nothing.obj"),
        ("noise.obj.zst", b"not zstd", "noise.obj.zst"),
        ("noise.glb", b"glTF but not", "noise.glb"),
        ("unknown.toml", b"geometry = \"cornell\"\nweather = 3\n", "unknown.toml:2"),
    ];
    for (name, content, expected) in cases {
        let path = file(&dir, name, content);
        let out = dir.path().join("out");
        refused(&["profile", arg(&path), "-o", arg(&out)], &[expected, "; "]);
        assert!(!out.exists(), "{name} left a folder");
    }
}

#[test]
fn descriptions_of_gpus_that_make_no_sense_are_refused_with_their_place() {
    let dir = folder();
    let good = gpumodel::BuiltinGpu::named("adreno-540").expect("it is built in").toml;
    refused(&["profile", "cornell", "--gpu", "adreno-9999"], &["adreno-9999", "adreno-540"]);
    let first_key = good.lines().find(|line| line.contains('=') && !line.starts_with('#')).expect("a key");
    let cases = [
        (
            "unknown.toml",
            good.replacen(first_key, &format!("{first_key}\nfavourite_colour = 3"), 1),
            "favourite_colour",
        ),
        ("empty.toml", String::new(), "empty.toml"),
        ("torn.toml", good[..good.len() / 2].to_owned(), "torn.toml"),
    ];
    for (name, text, expected) in cases {
        let path = file(&dir, name, text);
        refused(&["profile", "cornell", "--gpu", arg(&path)], &[name, expected]);
    }
    let not_text = file(&dir, "binary.toml", [b'a', 0xff]);
    refused(&["profile", "cornell", "--gpu", arg(&not_text)], &["binary.toml", "byte 1"]);
    let costs = file(&dir, "costs.toml", "nonsense = 1\n");
    refused(&["profile", "cornell", "--costs", arg(&costs)], &["costs.toml"]);
}

#[test]
fn trace_files_that_are_torn_flipped_or_foreign_are_refused() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    raybudget(["trace", "cornell", "-o", arg(&trace), "--size", "40x36"]).ok();
    let good = fs::read(&trace).expect("a trace");
    let refuse = |name: &str, bytes: &[u8]| {
        let path = file(&dir, name, bytes);
        let out = dir.path().join("out");
        refused(&["replay", arg(&path), "-o", arg(&out)], &[name, "; "]);
        assert!(!out.exists(), "{name} left a folder");
        fs::remove_file(path).expect("the file is there");
    };
    refuse("empty.rbt", b"");
    refuse(
        "foreign.rbt",
        b"P6 640 480 255 and then a picture, longer than any header and any trailer might be, so there",
    );
    for length in [1, 8, good.len() / 3, good.len() / 2, good.len() - 1] {
        refuse("torn.rbt", &good[..length]);
    }
    for place in (0..good.len()).step_by(good.len() / 40) {
        let mut flipped = good.clone();
        flipped[place] ^= 0x10;
        refuse("flipped.rbt", &flipped);
    }
    refused(&["replay", "no.rbt"], &["no.rbt"]);
    assert_eq!(names_in(dir.path()), ["t.rbt"]);
}

#[test]
fn ray_files_that_are_none_are_refused_before_anything_is_written() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    for (name, bytes, expected) in [("short.bin", &[0_u8; 33][..], "byte 32"), ("none.bin", &[], "none.bin")]
    {
        let rays = file(&dir, name, bytes);
        refused(&["trace", "cornell", "-o", arg(&trace), "--rays", arg(&rays)], &[name, expected]);
    }
    refused(&["trace", "cornell", "-o", arg(&trace), "--rays", "no.bin"], &["no.bin"]);
    assert!(!trace.exists());
}
