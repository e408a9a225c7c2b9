//! `raybudget stereo`: what is reused is the left image's, and all else is as traced.

use crate::support::{arg, folder, names_in, raybudget};
use std::fs::{self, File};
use std::path::Path;

const FILES: [&str; 5] = ["difference.png", "left.png", "right-traced.png", "right.png", "traced-pixels.png"];

/// The pixels of a picture, in rows.
fn pixels(path: &Path) -> Vec<[u8; 3]> {
    let decoder = png::Decoder::new(std::io::BufReader::new(File::open(path).expect("a picture")));
    let mut reader = decoder.read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("it is small")];
    reader.next_frame(&mut bytes).expect("a PNG");
    bytes.as_chunks::<3>().0.to_vec()
}

#[test]
fn eyes_in_one_place_share_the_whole_image() {
    let out = folder();
    let options = ["--size", "61x47", "--interaxial", "0", "-o", arg(out.path())];
    let text = raybudget(["stereo", "cornell"].iter().chain(&options)).ok();
    assert_eq!(names_in(out.path()), FILES);
    for part in [
        "what the left image shows                  2867  100.00 %",
        "PSNR infinite, 0.00 % of the pixels differ",
        "2 / (2 - p (1 - b)) = 2.000 with p = 1.000",
    ] {
        assert!(text.contains(part), "no '{part}' in: {text}");
    }
    let [left, right] =
        ["left.png", "right.png"].map(|name| fs::read(out.path().join(name)).expect("a picture"));
    assert!(left == right);
}

#[test]
fn reflections_are_the_right_eye_s_own() {
    let pictures = |options: &[&str]| {
        let out = folder();
        let all = ["stereo", "cornell", "--size", "80x60", "-o", arg(out.path())];
        let text = raybudget(all.iter().chain(options)).ok();
        (FILES.map(|name| pixels(&out.path().join(name))), text)
    };
    let ([_, _, matte, ..], _) = pictures(&[]);
    let ([difference, left, whole, right, traced], _) = pictures(&["--force", "mirror"]);
    assert!(whole != matte);
    let reused: Vec<usize> = (0..whole.len())
        .filter(|&place| traced[place][0] == traced[place][1] && traced[place][1] == traced[place][2])
        .collect();
    // Many differ from all of their row in the left image, and most are what the right eye sees.
    let is_copied = |place: usize| left[place / 80 * 80..(place / 80 + 1) * 80].contains(&right[place]);
    let own = reused.iter().filter(|&&place| !is_copied(place)).count();
    let as_seen = reused.iter().filter(|&&place| difference[place] == [0; 3]).count();
    assert!(20 * own > reused.len() && 2 * as_seen > reused.len(), "{own} and {as_seen} of {}", reused.len());
    for place in (0..whole.len()).filter(|place| !reused.contains(place)) {
        assert_eq!(right[place], whole[place], "pixel {place}");
    }
    let (_, text) = pictures(&["--force", "mirror", "--interaxial", "0"]);
    assert!(text.contains("PSNR infinite"), "{text}");
}

#[test]
fn pixels_that_were_traced_are_those_of_an_image_that_is_traced_whole() {
    let out = folder();
    let options = ["--size", "90x70", "-o", arg(out.path())];
    raybudget(["stereo", "atrium"].iter().chain(&options)).ok();
    let [difference, left, whole, right, traced] = FILES.map(|name| pixels(&out.path().join(name)));
    let (mut reused, mut by_tracing) = (0, 0);
    for (place, pixel) in right.iter().enumerate() {
        // Pixels that were traced are marked in a colour, others are grey.
        let [r, g, b] = traced[place];
        if r == g && g == b {
            reused += 1;
            let row = place / 90 * 90..(place / 90 + 1) * 90;
            assert!(left[row].contains(pixel), "pixel {place} is nowhere in its row of the left image");
        } else {
            by_tracing += 1;
            assert_eq!((pixel, difference[place]), (&whole[place], [0; 3]), "pixel {place}");
        }
    }
    assert!(reused > 5000 && by_tracing > 100, "{reused}, {by_tracing}");
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads_or_on_the_traversal() {
    let run = |options: &[&str]| {
        let out = folder();
        let text =
            raybudget(["stereo", "teapot", "--size", "50x40", "-o", arg(out.path())].iter().chain(options))
                .ok();
        (FILES.map(|name| fs::read(out.path().join(name)).expect("a picture")), text)
    };
    let first = run(&["--threads", "1"]);
    assert!(run(&["--threads", "3"]) == first);
    assert!(run(&["--accel", "kd", "--traversal", "backtrack"]).0 == first.0);
}

#[test]
fn eyes_that_cannot_be_are_refused_and_leave_nothing() {
    let dir = folder();
    let out = dir.path().join("pair");
    for (options, problem) in [
        (
            ["--interaxial", "-1"],
            "--interaxial -1: a distance between two eyes expected; give a finite number from 0 on",
        ),
        (["--interaxial", "inf"], "--interaxial inf: a distance between two eyes expected"),
        (
            ["--convergence", "0"],
            "--convergence 0: a depth in front of the eyes expected; give a number above 0, or inf",
        ),
        (["--convergence", "nan"], "--convergence NaN: a depth"),
        (["--interaxial", "1e39"], "--interaxial 1.000e39: more than 10 times the convergence of "),
        (["--convergence", "1e-30"], "more than 10 times the convergence of 1.000e-30; give a smaller one"),
        (["--interaxial", "1e-7"], "coordinates of 32 bits put the eyes 0 apart; give a larger one"),
        (["--leave-out", "normals"], "a picture is shaded by the flat normal"),
    ] {
        let [option, value] = options;
        let joined = format!("{option}={value}");
        let refused = raybudget(["stereo", "cornell", "--size", "8x8", "-o", arg(&out), &joined]).refused();
        assert!(refused.contains(problem), "{refused}");
        assert!(!out.exists());
    }
}

const ON_SGRT: [&str; 6] = ["--gpu", "sgrt", "--accel", "wide-bvh", "--node-format", "full-4"];
const REPORTS: [&str; 4] = ["left-traced.json", "left.json", "right-traced.json", "right.json"];

/// A counter of a pass, or of the frame.
fn counter(report: &serde_json::Value, pass: Option<&str>, counter: &str) -> f64 {
    let counters = match pass {
        None => &report["counters"],
        Some(name) => {
            let passes = report["passes"].as_array().expect("a list");
            let found = passes.iter().find(|pass| pass["name"] == name);
            &found.unwrap_or_else(|| panic!("no pass {name}"))["counters"]
        }
    };
    counters[counter]["value"].as_f64().unwrap_or_else(|| panic!("no {counter}"))
}

#[test]
fn on_a_gpu_both_eyes_have_reports_and_what_is_answered_is_not_traced() {
    let out = folder();
    let options = ["--size", "96x64", "--force", "mirror", "-o", arg(out.path())];
    let text = raybudget(["stereo", "cornell"].iter().chain(&ON_SGRT).chain(&options)).ok();
    let mut all = [&FILES[..], &REPORTS, &["timeline.json"]].concat();
    all.sort_unstable();
    assert_eq!(names_in(out.path()), all);
    for part in [
        "on sgrt, stereo\n",
        "\n  reprojection errors, ms",
        "of which kernels wait ",
        "32x16",
        "  as modelled\n",
        "96x1",
    ] {
        assert!(text.contains(part), "no '{part}' in: {text}");
    }
    let [left_traced, left, right_traced, right] = REPORTS.map(|name| {
        let bytes = fs::read(out.path().join(name)).expect("a report");
        serde_json::from_slice::<serde_json::Value>(&bytes).expect("JSON")
    });
    let traced: f64 = {
        let line = |what: &str| {
            let line = text.lines().find(|line| line.starts_with(what)).expect("it is told");
            line[what.len()..].split_whitespace().next().and_then(|count| count.parse::<f64>().ok())
        };
        line("traced: nothing lands there").expect("a count")
            + line("traced: covered, by the row test").expect("a count")
    };
    assert!(traced > 0.0);
    assert_eq!(counter(&left, Some("primary rays"), "rays"), 96.0 * 64.0);
    assert_eq!(counter(&right, Some("primary rays"), "rays"), traced);
    assert_eq!(
        counter(&right, Some("reflection rays"), "rays"),
        counter(&right_traced, Some("reflection rays"), "rays")
    );
    assert!(counter(&left, Some("reprojection"), "frame_time_ms") > 0.0);
    assert!(counter(&right, Some("reprojection errors"), "frame_time_ms") > 0.0);
    for whole in [&left_traced, &right_traced] {
        assert!(!whole["passes"].to_string().contains("reprojection"));
    }
    // What the table says is what the reports say.
    let sum = |eyes: [&serde_json::Value; 2]| {
        eyes.map(|eye| counter(eye, None, "frame_time_ms")).iter().sum::<f64>()
    };
    let speed_up = sum([&left_traced, &right_traced]) / sum([&left, &right]);
    assert!(text.contains(&format!("with reuse {speed_up:.3} times as fast")), "{speed_up}: {text}");
}

#[test]
fn machines_that_cannot_have_two_eyes_are_refused_and_leave_nothing() {
    let dir = folder();
    let out = dir.path().join("pair");
    for (options, problem) in [
        (&["--layout", "split"][..], "without --gpu: name the GPU"),
        (
            &["--gpu", "adreno-740", "--technique", "compute"],
            "--technique compute: has one eye; use one of: stereo",
        ),
        (&["--gpu", "adreno-740", "--technique", "stereo"], "use stereo-memory, or --gpu sgrt"),
        (&["--gpu", "sgrt", "--fidelity", "timed"], "use --fidelity replay"),
        (
            &["--gpu", "sgrt", "--set", "tiler.tile_memory_bytes=4096"],
            "bytes of internal memory for tiles of 32x16",
        ),
    ] {
        let refused =
            raybudget(["stereo", "cornell", "--size", "64x64", "-o", arg(&out)].iter().chain(options))
                .refused();
        assert!(refused.contains(problem), "{refused}");
        assert!(!out.exists());
    }
}
