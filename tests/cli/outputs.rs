//! Files appear whole or not at all.

use crate::support::{REPORT_FILES, SMALL, arg, command, file, finish, folder, names_in, raybudget};
use std::fs;

#[test]
fn a_folder_gets_every_file_and_they_say_what_was_printed() {
    let dir = folder();
    let out = dir.path().join("a/b");
    let args = ["profile", "cornell", "-o", arg(&out), "--format", "json"];
    let printed = raybudget(args.into_iter().chain(SMALL)).ok();
    assert_eq!(names_in(&out), REPORT_FILES);
    assert_eq!(fs::read_to_string(out.join("report.json")).expect("a file"), printed);
    for map in REPORT_FILES.iter().filter(|name| name.ends_with(".png")) {
        let png = fs::read(out.join(map)).expect("a file");
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "{map}");
    }
}

#[test]
fn files_of_an_earlier_run_are_replaced_and_others_stay() {
    let dir = folder();
    file(&dir, "report.txt", "old");
    file(&dir, "mine.txt", "mine");
    raybudget(["profile", "cornell", "-o", arg(dir.path())].into_iter().chain(SMALL)).ok();
    assert_ne!(fs::read_to_string(dir.path().join("report.txt")).expect("a file"), "old");
    assert_eq!(fs::read_to_string(dir.path().join("mine.txt")).expect("a file"), "mine");
    assert_eq!(names_in(dir.path()).len(), REPORT_FILES.len() + 1);
}

#[test]
#[cfg(unix)]
fn files_have_the_permissions_that_new_files_have() {
    use std::os::unix::fs::PermissionsExt;
    let dir = folder();
    let plain = file(&dir, "plain", "");
    raybudget(["profile", "cornell", "-o", arg(dir.path())].into_iter().chain(SMALL)).ok();
    let mode = |path| fs::metadata(path).expect("a file").permissions().mode();
    assert_eq!(mode(dir.path().join("report.json")), mode(plain));
}

#[test]
fn a_failed_profile_leaves_no_folder_and_an_old_one_as_it_was() {
    let dir = folder();
    let broken = file(&dir, "broken.obj", "v 0 0 0\nf 1 2 3\n");
    let old = dir.path().join("old");
    fs::create_dir(&old).expect("a folder");
    fs::write(old.join("report.txt"), "old").expect("a file");
    for out in [dir.path().join("new/deep"), old.clone()] {
        raybudget(["profile", arg(&broken), "-o", arg(&out)]).refused();
    }
    assert_eq!(names_in(dir.path()), ["broken.obj", "old"]);
    assert_eq!(names_in(&old), ["report.txt"]);
    assert_eq!(fs::read_to_string(old.join("report.txt")).expect("a file"), "old");
}

#[test]
fn outputs_are_opened_before_the_scene_is_loaded() {
    let dir = folder();
    let blocked = file(&dir, "file", "");
    let inside = blocked.join("out");
    let message = raybudget(["profile", "no-such-scene", "-o", arg(&inside)]).refused();
    assert!(message.contains("cannot write") && message.contains("file"), "{message}");
    let message = raybudget(["trace", "no-such-scene", "-o", arg(&inside)]).refused();
    assert!(message.contains("cannot write"), "{message}");
    let message = raybudget(["profile", "no-such-scene", "-o", arg(&blocked)]).refused();
    assert!(message.contains("this is a file; give a folder"), "{message}");
}

#[test]
fn a_folder_or_a_device_is_no_trace_file() {
    let dir = folder();
    let message = raybudget(["trace", "cornell", "-o", arg(dir.path())]).refused();
    assert!(message.contains("this is a folder"), "{message}");
    #[cfg(unix)]
    {
        let message = raybudget(["trace", "cornell", "-o", "/dev/null"]).refused();
        assert!(message.contains("device or a pipe"), "{message}");
        let message =
            raybudget(["trace", "cornell", "-o", arg(&dir.path().join("t.rbt")), "--hits", "/dev/null"]);
        assert!(message.refused().contains("device or a pipe"));
        assert_eq!(names_in(dir.path()), Vec::<String>::new());
    }
}

/// A limit on the size of files stops a write in its middle, as a full disk does.
#[test]
#[cfg(target_os = "linux")]
fn a_write_that_fails_half_way_leaves_nothing() {
    let dir = folder();
    let trace = dir.path().join("t.rbt");
    let hits = dir.path().join("h.csv");
    let program = assert_cmd::cargo::cargo_bin!("raybudget");
    let limited = |kibibytes: u32, args: &str| {
        let blocks = kibibytes * 2;
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {} {args}", program.display());
        finish(assert_cmd::Command::new("sh").args(["-c", &script]))
    };
    let message = limited(8, &format!("trace cornell -o {} --size 256x256", trace.display())).refused();
    assert!(message.contains("t.rbt"), "{message}");
    let message = limited(
        400,
        &format!("trace cornell -o {} --hits {} --size 256x256", trace.display(), hits.display()),
    );
    assert!(message.refused().contains("h.csv: cannot write"));
    let out = dir.path().join("out");
    let message = limited(24, &format!("profile cornell --size 64x64 -o {}", out.display())).refused();
    assert!(message.contains("report.json: cannot write"), "{message}");
    assert_eq!(names_in(dir.path()), Vec::<String>::new());
}

/// A small disk of its own, where the tests may mount one.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_in_the_middle_of_a_trace_leaves_nothing() {
    struct Disk(tempfile::TempDir);
    impl Drop for Disk {
        fn drop(&mut self) {
            let _ = std::process::Command::new("umount").arg(self.0.path()).status();
        }
    }
    let dir = folder();
    let mounted = std::process::Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=64k", "raybudget-test"])
        .arg(dir.path())
        .output();
    if !mounted.is_ok_and(|mounted| mounted.status.success()) {
        eprintln!("skipped: no right to mount a small disk");
        return;
    }
    let disk = Disk(dir);
    let trace = disk.0.path().join("t.rbt");
    let message = raybudget(["trace", "soup", "-o", arg(&trace), "--size", "256x256"]).refused();
    assert!(message.contains("t.rbt") && message.contains("No space left"), "{message}");
    assert_eq!(names_in(disk.0.path()), Vec::<String>::new());
}

#[test]
fn hits_are_one_row_per_ray_in_the_order_of_the_rays() {
    let dir = folder();
    let (trace, hits) = (dir.path().join("t.rbt"), dir.path().join("h.csv"));
    let args = ["trace", "cornell", "-o", arg(&trace), "--hits", arg(&hits)];
    raybudget(args.into_iter().chain(SMALL)).ok();
    let text = fs::read_to_string(&hits).expect("a file");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("ray,primitive,t,u,v"));
    let mut rays = 0;
    for (number, line) in lines.enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!((fields.len(), fields[0]), (5, number.to_string().as_str()));
        match fields[1] {
            "" => assert_eq!(fields[2..], ["", "", ""]),
            primitive => {
                assert!(primitive.parse::<u32>().expect("a number") < 32);
                let [t, u, v] = [2, 3, 4].map(|field| fields[field].parse::<f32>().expect("a number"));
                assert!(t > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6, "{line}");
            }
        }
        rays += 1;
    }
    assert_eq!(rays, 40 * 36);
}

#[test]
fn hits_do_not_depend_on_the_threads() {
    let dir = folder();
    let hits = |threads| {
        let (trace, hits) = (dir.path().join("t.rbt"), dir.path().join("h.csv"));
        raybudget([
            "trace",
            "teapot",
            "-o",
            arg(&trace),
            "--hits",
            arg(&hits),
            "--size",
            "200x150",
            "--threads",
            threads,
        ])
        .ok();
        (fs::read(&trace).expect("a file"), fs::read(&hits).expect("a file"))
    };
    assert_eq!(hits("1"), hits("3"));
}

#[test]
fn rays_from_a_file_are_traced_one_by_one() {
    let dir = folder();
    // Into the Cornell Box from the front, past it, and without any length.
    let rays: [[f32; 8]; 3] = [
        [278.0, 500.0, -800.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY],
        [278.0, 500.0, -800.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [278.0, 500.0, -800.0, 0.0, 0.0, 0.0, 1.0, 10.0],
    ];
    let bytes: Vec<u8> = rays.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let rays = file(&dir, "rays.bin", bytes);
    let (trace, hits) = (dir.path().join("t.rbt"), dir.path().join("h.csv"));
    raybudget(["trace", "cornell", "-o", arg(&trace), "--rays", arg(&rays), "--hits", arg(&hits)]).ok();
    let text = fs::read_to_string(&hits).expect("a file");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 3);
    let t: f32 = rows[0].split(',').nth(2).expect("a column t").parse().expect("a number");
    assert!((t - 1359.2).abs() < 0.01, "the back wall: {}", rows[0]);
    assert_eq!(rows[1..], ["1,,,,", "2,,,,"]);
    let report = raybudget(["replay", arg(&trace), "--format", "json"]).json();
    assert_eq!(report["counters"]["rays"]["value"], 3);
    assert_eq!(report["inputs"]["width"], serde_json::Value::Null);
    let ran = finish(command().args(["replay", arg(&trace), "-o", arg(&dir.path().join("out"))]));
    assert_eq!(ran.code, Some(0));
    assert!(ran.stderr.contains("no heat map"), "{}", ran.stderr);
    assert_eq!(
        names_in(&dir.path().join("out")),
        ["counters.csv", "report.html", "report.json", "report.txt", "timeline.json"]
    );
}
