//! `raybudget sweep`: grids, lists, what is left of a sweep that was killed, and what it refuses.

use crate::support::{arg, command, finish, folder, names_in, raybudget};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// 200 points: 2 scenes, 5 GPUs, 5 traversals, 2 layouts, 2 orders of nodes.
const PLAN: &str = r#"
minimize = ["frame_time_ms", "dram_read_bytes"]

[base]
size = "24x16"

[grid]
scene = ["cornell", "teapot"]
gpu = ["adreno-540", "adreno-640", "adreno-740", "mali-g78", "mali-g715"]
tree = [
    { accel = "bvh", traversal = "stack" },
    { accel = "bvh", traversal = "parent-link" },
    { accel = "bvh", traversal = "restart-trail" },
    { accel = "kd", traversal = "push-down" },
    { accel = "kd", traversal = "restart" },
]
layout = ["padded", "split"]
node-order = ["depth-first", "breadth-first"]
"#;

/// A plan in a folder, and where its results go.
fn planned(folder: &Path, text: &str) -> [String; 4] {
    let plan = folder.join("plan.toml");
    fs::write(&plan, text).expect("the plan is written");
    ["sweep".to_owned(), arg(&plan).to_owned(), "-o".to_owned(), arg(&folder.join("out")).to_owned()]
}

/// All files of a folder and of the folders in it.
fn contents(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        let name = entry.file_name().expect("a name").to_string_lossy().into_owned();
        if entry.is_dir() {
            let inner = contents(&entry).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes));
            files.extend(inner);
        } else {
            files.insert(name, fs::read(&entry).expect("a file"));
        }
    }
    files
}

fn points(out: &Path) -> usize {
    names_in(&out.join("points")).iter().filter(|name| name.ends_with(".json")).count()
}

#[test]
fn a_point_has_the_figures_that_profile_gives() {
    let folder = folder();
    let text = "[base]\nsize = \"24x16\"\n[[point]]\nscene = \"teapot\"\naccel = \"kd\"\ntraversal = \"push-down\"\ncache.uche.size = 65536\n";
    let args = planned(folder.path(), text);
    let swept = raybudget(args.iter().map(String::as_str).chain(["--format", "json"])).json();
    let options = ["--accel", "kd", "--traversal", "push-down", "--set", "cache.uche.size=65536"];
    let profiled =
        raybudget(["profile", "teapot", "--size", "24x16", "--format", "json"].into_iter().chain(options))
            .json();
    assert_eq!(swept["points"][0]["counters"], profiled["counters"]);
    assert_eq!(swept["points"][0]["within"], profiled["run"]["within"]);
}

#[test]
fn a_sweep_that_is_killed_again_and_again_ends_with_the_bytes_of_one_that_is_not() {
    let (whole, killed) = (folder(), folder());
    let args = planned(whole.path(), PLAN);
    let start = Instant::now();
    raybudget(&args).ok();
    let took = start.elapsed();
    let out = whole.path().join("out");
    assert_eq!(fs::read_to_string(out.join("sweep.csv")).expect("the table").lines().count(), 201);

    let args = planned(killed.path(), PLAN);
    let out_killed = killed.path().join("out");
    let mut random = 0x9e37_79b9_u32;
    // Grows while nothing comes of it: how long a start takes depends on what else the machine does.
    let mut longest = took / 8;
    let (mut kills, mut before) = (0, 0);
    while kills < 10 {
        let mut child = Command::new(command().get_program())
            .args(&args)
            .arg("--resume")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        // Numerical Recipes' generator; its high bits.
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        std::thread::sleep(longest.mul_f64(f64::from(random >> 16) / 65536.0));
        child.kill().expect("it can be killed");
        let ended = child.wait().expect("it has ended");
        let killed_or_done = ended.code().is_none_or(|code| code == 0);
        assert!(killed_or_done, "it ended by itself with {ended}");
        kills += 1;
        let now = if out_killed.join("points").exists() { points(&out_killed) } else { 0 };
        assert!(now >= before, "{now} points after the kill, {before} before");
        if now == before {
            longest *= 2;
        }
        before = now;
    }
    assert!(before > 0, "no point outlived ten kills");
    raybudget(args.iter().map(String::as_str).chain(["--resume"])).ok();
    let [expected, found] = [&out, &out_killed].map(|out| contents(out));
    assert_eq!(expected.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{name} differs");
    }
}

#[test]
fn the_files_do_not_depend_on_the_number_of_threads() {
    let folders = [folder(), folder()];
    let text = PLAN.replace(r#", "mali-g78", "mali-g715""#, "");
    for (folder, threads) in folders.iter().zip(["1", "3"]) {
        let args = planned(folder.path(), &text);
        raybudget(args.iter().map(String::as_str).chain(["--threads", threads])).ok();
    }
    let [one, other] = folders.map(|folder| contents(&folder.path().join("out")));
    assert!(one.contains_key("pareto.svg") && one.contains_key("effect-tree.png"), "{:?}", one.keys());
    assert_eq!(one, other);
}

#[test]
fn a_torn_point_is_replayed_again_and_a_whole_one_is_not() {
    let folder = folder();
    let text = "[base]\nsize = \"8x8\"\n[grid]\nscene = [\"cornell\"]\nlayout = [\"padded\", \"split\"]\n";
    let args = planned(folder.path(), text);
    raybudget(&args).ok();
    let out = folder.path().join("out");
    let before = contents(&out);
    let names: Vec<&String> = before.keys().filter(|name| name.ends_with(".json")).collect();
    fs::write(out.join(names[0]), &before[names[0]][..50]).expect("it is written");
    let unfinished = out.join("points/.raybudget-abC123");
    fs::write(&unfinished, "half").expect("it is written");
    let whole = out.join(names[1]);
    let modified = fs::metadata(&whole).and_then(|file| file.modified()).expect("its time");
    let ran = raybudget(args.iter().map(String::as_str).chain(["--resume"]));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("not figures of a point") && ran.stderr.contains("replaying"),
        "{}",
        ran.stderr
    );
    assert_eq!(contents(&out), before);
    assert_eq!(fs::metadata(&whole).and_then(|file| file.modified()).expect("its time"), modified);
}

#[test]
fn another_input_is_another_point_even_under_the_same_name() {
    let folder = folder();
    let gpu = folder.path().join("gpu.toml");
    let described = gpumodel::GPUS.iter().find(|gpu| gpu.name == "adreno-540").expect("it is described").toml;
    let text = format!("[[point]]\nscene = \"cornell\"\nsize = \"8x8\"\ngpu = {:?}\n", arg(&gpu));
    fs::write(&gpu, described).expect("it is written");
    let args = planned(folder.path(), &text);
    raybudget(&args).ok();
    fs::write(&gpu, described.replace("adreno-540", "adreno-541")).expect("it is written");
    raybudget(args.iter().map(String::as_str).chain(["--resume"])).ok();
    assert_eq!(points(&folder.path().join("out")), 2);
}

#[test]
fn a_combination_without_meaning_has_its_reason_in_the_table() {
    let folder = folder();
    let text =
        "[base]\nscene = \"cornell\"\nsize = \"8x8\"\n[grid]\naccel = [\"grid\", \"bvh\"]\nct = [1, 3]\n";
    let args = planned(folder.path(), text);
    let swept = raybudget(args.iter().map(String::as_str).chain(["--format", "json"])).json();
    let failures: Vec<&Value> = (0..4).map(|index| &swept["points"][index]["failure"]).collect();
    assert_eq!(failures[0], "not replayed, for a grid is not built by costs");
    assert_eq!((failures[2], failures[3]), (&Value::Null, &Value::Null));
}

#[test]
fn what_cannot_be_swept_is_refused_before_a_folder_is_made() {
    for (text, expected) in [
        ("", "no points"),
        ("[grid]\nweather = [1]\n", "no such option"),
        (
            "[[point]]\naccel = \"kd\"\ntraversal = \"parent-link\"\n",
            "point 1 (scene atrium, accel kd, traversal parent-link): ",
        ),
        ("[[point]]\nsize = \"8y8\"\n", "point 1 (scene atrium, size 8y8): --size 8y8: expected"),
        (
            "[grid]\ngpu = [\"adreno-540\", \"voodoo\"]\n",
            "grid.gpu: no point can have voodoo: --gpu voodoo: neither",
        ),
        ("[[point]]\nscene = \"nowhere.obj\"\n", "nowhere.obj: "),
        ("[[point]]\nfidelity = \"sampled\"\n", "--fidelity sampled"),
        (
            "[[point]]\naccel = \"grid\"\nct = 1\n",
            "no point is left to replay, for a grid is not built by costs",
        ),
    ] {
        let folder = folder();
        let args = planned(folder.path(), text);
        let ran = finish(command().args(&args));
        assert_eq!(ran.code, Some(2), "{text}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{text}: {}", ran.stderr);
        assert_eq!(names_in(folder.path()), ["plan.toml"], "{text}");
    }
}

#[test]
fn the_points_of_an_earlier_sweep_and_a_folder_at_work_are_not_touched() {
    let folder = folder();
    let args = planned(folder.path(), "[[point]]\nscene = \"cornell\"\nsize = \"8x8\"\n");
    raybudget(&args).ok();
    let out = folder.path().join("out");
    let before = contents(&out);
    let again = raybudget(&args);
    assert_eq!(again.code, Some(2));
    assert!(again.stderr.contains("add --resume"), "{}", again.stderr);
    assert_eq!(contents(&out), before);

    let lock = fs::File::open(out.join("points/.lock")).expect("it stays");
    lock.lock().expect("it is free");
    let locked = raybudget(args.iter().map(String::as_str).chain(["--resume"]));
    assert_eq!(locked.code, Some(2));
    assert!(locked.stderr.contains("another sweep is at work"), "{}", locked.stderr);
}

#[test]
fn a_combination_that_cannot_be_is_left_out_and_said_so() {
    let folder = folder();
    let text = "[base]\nscene = \"cornell\"\nsize = \"8x8\"\n[grid]\ngpu = [\"adreno-540\", \"mali-g715\"]\ncache.uche.size = [65536, 131072]\n\
                [[point]]\ngpu = \"mali-g715\"\n";
    // Of the second GPU no point can have such a cache; a GPU of which none can be is a mistake.
    let args = planned(folder.path(), text);
    let refused = raybudget(&args);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("grid.gpu: no point can have mali-g715"), "{}", refused.stderr);

    let text = "[base]\nscene = \"cornell\"\nsize = \"8x8\"\n[grid]\naccel = [\"bvh\", \"kd\"]\ntraversal = [\"stack\", \"restart\"]\n";
    let args = planned(folder.path(), text);
    let swept = raybudget(args.iter().map(String::as_str).chain(["--format", "json"])).json();
    let failure = |index: usize| swept["points"][index]["failure"].as_str().unwrap_or_default().to_owned();
    assert!(failure(1).starts_with("not replayed, for ") && failure(1).contains("restart"), "{}", failure(1));
    assert_eq!([0, 2, 3].map(failure), ["", "", ""]);
}

#[test]
fn shading_normals_make_another_point() {
    let folder = folder();
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let smooth = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 1\nvn 1 0 1\nf 1//1 2//2 3//3\n";
    let scene = folder.path().join("scene.obj");
    let args = planned(folder.path(), &format!("[[point]]\nscene = {:?}\nsize = \"8x8\"\n", arg(&scene)));
    for (count, text) in [(1, plain), (2, smooth)] {
        fs::write(&scene, text).expect("it is written");
        let swept = raybudget(args.iter().map(String::as_str).chain(["--resume", "--format", "json"])).json();
        let profiled = raybudget(["profile", arg(&scene), "--size", "8x8", "--format", "json"]).json();
        assert_eq!(swept["points"][0]["counters"], profiled["counters"]);
        assert_eq!(points(&folder.path().join("out")), count);
    }
}

#[test]
fn charts_of_an_earlier_plan_go_and_other_files_stay() {
    let folder = folder();
    let grid = "[base]\nsize = \"8x8\"\n[grid]\nscene = [\"cornell\"]\nlayout = [\"padded\", \"split\"]\n";
    raybudget(planned(folder.path(), grid)).ok();
    let out = folder.path().join("out");
    for name in ["notes.txt", ".raybudget-notes"] {
        fs::write(out.join(name), "mine").expect("it is written");
    }
    assert!(out.join("effect-layout.svg").exists() && out.join("pareto.png").exists());
    let list = "minimize = [\"fps\"]\n[[point]]\nscene = \"cornell\"\nsize = \"8x8\"\n";
    let args = planned(folder.path(), list);
    raybudget(args.iter().map(String::as_str).chain(["--resume"])).ok();
    assert_eq!(
        names_in(&out),
        [".raybudget-notes", "columns.csv", "notes.txt", "pareto.csv", "points", "sweep.csv"]
    );
}

#[cfg(unix)]
#[test]
fn a_lock_that_is_a_link_is_not_followed() {
    let folder = folder();
    let args = planned(folder.path(), "[[point]]\nscene = \"cornell\"\nsize = \"8x8\"\n");
    let precious = folder.path().join("precious.txt");
    fs::write(&precious, "precious").expect("it is written");
    fs::create_dir_all(folder.path().join("out/points")).expect("a folder");
    std::os::unix::fs::symlink(&precious, folder.path().join("out/points/.lock")).expect("a link");
    let ran = raybudget(&args);
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("this is a link"), "{}", ran.stderr);
    assert_eq!(fs::read_to_string(&precious).expect("it is there"), "precious");
}

#[test]
fn figures_of_another_point_or_of_nothing_are_not_believed() {
    let folder = folder();
    let text = "[base]\nsize = \"8x8\"\n[grid]\nscene = [\"cornell\"]\nlayout = [\"padded\", \"split\"]\n";
    let args = planned(folder.path(), text);
    raybudget(&args).ok();
    let out = folder.path().join("out");
    let before = contents(&out);
    let names: Vec<&String> = before.keys().filter(|name| name.ends_with(".json")).collect();
    fs::write(out.join(names[0]), &before[names[1]]).expect("it is written");
    fs::write(out.join(names[1]), [0xff, 0xfe]).expect("it is written");
    let ran = raybudget(args.iter().map(String::as_str).chain(["--resume"]));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("the figures of another point") && ran.stderr.contains("not UTF-8"),
        "{}",
        ran.stderr
    );
    assert_eq!(contents(&out), before);
}
