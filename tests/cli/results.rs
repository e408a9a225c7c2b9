//! What commands print.

use crate::support::{SMALL, command, finish, raybudget};
use serde_json::Value;
use std::process::{Command, Stdio};

#[test]
fn a_profile_answers_in_text_json_and_csv_with_the_same_figures() {
    let run = |format| raybudget(["profile", "cornell", "--format", format].into_iter().chain(SMALL));
    let json = run("json").json();
    let csv = run("csv").ok();
    let text = run("text").ok();
    let rays = json["counters"]["rays"]["value"].as_u64().expect("a count");
    assert!(rays > 40 * 36 && rays <= 2 * 40 * 36, "{rays}");
    assert!(csv.lines().any(|line| line.starts_with(&format!("rays,Rays,,{rays},"))), "{csv}");
    assert!(text.starts_with("cornell on adreno-540\n"), "{text}");
    for part in [
        "What the frame time is made of",
        "Lower bounds of the frame time",
        "Left out",
        "Estimates and assumptions",
        "This run",
        "peak memory",
    ] {
        assert!(text.contains(part), "{part} is missing:\n{text}");
    }
}

#[test]
fn a_profile_keeps_to_the_published_form() {
    let report = raybudget(["profile", "cornell", "--format", "json"].into_iter().chain(SMALL)).json();
    for (part, kind) in [
        ("schema", "number"),
        ("tool", "string"),
        ("inputs", "object"),
        ("left_out", "array"),
        ("run", "object"),
        ("counters", "object"),
        ("passes", "array"),
    ] {
        let found = match &report[part] {
            Value::Number(_) => "number",
            Value::String(_) => "string",
            Value::Object(_) => "object",
            Value::Array(_) => "array",
            _ => "something else",
        };
        assert_eq!(found, kind, "{part}");
    }
    let mut keys: Vec<&str> =
        report["counters"].as_object().expect("an object").keys().map(String::as_str).collect();
    let mut ids: Vec<&str> = gpumodel::COUNTERS.iter().map(|counter| counter.id).collect();
    keys.sort_unstable();
    ids.sort_unstable();
    assert_eq!(keys, ids);
}

#[test]
fn every_traversal_can_be_profiled() {
    for traversal in tracer::Traversal::ALL {
        let args =
            ["profile", "cornell", "--accel", traversal.accel().name(), "--traversal", traversal.name()];
        let report = raybudget(args.into_iter().chain(["--format", "json"]).chain(SMALL)).json();
        assert_eq!(report["inputs"]["traversal"], traversal.name());
        let time = report["counters"]["frame_time_ms"]["value"].as_f64().expect("a time");
        assert!(time > 0.0, "{args:?}: {time}");
    }
}

#[test]
fn every_layout_and_a_gpu_from_a_file_can_be_profiled() {
    let report = |args: &[&str]| {
        let fixed = ["profile", "cornell", "--format", "json"];
        raybudget(fixed.iter().chain(args).chain(&SMALL)).json()
    };
    for layout in gpumodel::PrimitiveLayout::ALL {
        assert_eq!(report(&["--layout", layout.name()])["inputs"]["layout"], layout.name());
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/gpus/adreno-540.toml");
    let (mut by_path, mut by_name) = (report(&["--gpu", path]), report(&["--gpu", "adreno-540"]));
    for report in [&mut by_path, &mut by_name] {
        report.as_object_mut().expect("an object").remove("run");
    }
    assert_eq!(by_path, by_name);
}

#[test]
fn lists_name_what_the_other_commands_take() {
    let list = |what| raybudget(["list", what, "--format", "json"]).json().as_array().expect("rows").clone();
    let column = |what, column: &str| -> Vec<String> {
        list(what).iter().map(|row| row[column].as_str().expect("a name").to_owned()).collect()
    };
    assert_eq!(column("gpus", "gpu"), gpumodel::GPUS.iter().map(|gpu| gpu.name).collect::<Vec<_>>());
    assert_eq!(
        column("scenes", "scene"),
        scenes::BUILTINS.iter().map(|scene| scene.name).collect::<Vec<_>>()
    );
    assert_eq!(column("layouts", "layout"), ["padded", "compact", "split"]);
    assert_eq!(
        column("techniques", "technique"),
        gpumodel::TECHNIQUES.iter().map(|technique| technique.name).collect::<Vec<_>>()
    );
    let traversals = tracer::Traversal::ALL;
    assert_eq!(column("traversals", "accel"), traversals.map(|traversal| traversal.accel().name()));
    assert_eq!(column("traversals", "traversal"), traversals.map(tracer::Traversal::name));
    let ours = list("counters").into_iter().filter(|row| row["profiler"] == "");
    let ours: Vec<String> = ours.map(|row| row["counter"].as_str().expect("an id").to_owned()).collect();
    assert_eq!(ours, gpumodel::COUNTERS.iter().map(|info| info.id).collect::<Vec<_>>());
}

#[test]
fn a_list_can_be_a_table_in_markdown() {
    let markdown = raybudget(["list", "layouts", "--format", "markdown"]).ok();
    let lines: Vec<&str> = markdown.lines().collect();
    let columns = "| layout | bytes per triangle with normals | of these in a second buffer, for shading |";
    assert_eq!(lines[..2], [columns, "| --- | --- | --- |"]);
    assert_eq!(lines.len(), 2 + gpumodel::PrimitiveLayout::ALL.len());
    assert!(lines[2].starts_with("| padded | "), "{markdown}");
}

#[test]
fn the_list_of_counters_gives_each_its_unit_formula_and_denominator() {
    let text = raybudget(["list", "counters"]).ok();
    for counter in gpumodel::COUNTERS {
        for part in [counter.id, counter.name, counter.unit, counter.formula, counter.denominator] {
            assert!(text.contains(part), "{part} is missing");
        }
    }
    let csv = raybudget(["list", "counters", "--format", "csv"]).ok();
    assert_eq!(
        csv.lines().next(),
        Some("counter,name,group,unit,denominator,formula,profiler,definition,absent")
    );
}

#[test]
fn help_version_completions_and_the_manual_come_from_one_definition() {
    let help = raybudget(["--help"]).ok();
    let manual = raybudget(["man"]).ok();
    let completions = raybudget(["completions", "bash"]).ok();
    for command in [
        "profile",
        "render",
        "trace",
        "replay",
        "compare",
        "whatif",
        "check",
        "verify",
        "cache",
        "list",
        "completions",
        "man",
    ] {
        for (name, text) in [("help", &help), ("manual", &manual), ("completions", &completions)] {
            assert!(text.contains(command), "{command} is missing in the {name}");
        }
        let page = raybudget(["man", command]).ok();
        assert!(page.contains(&format!("raybudget-{command} 1")), "{page}");
    }
    assert!(raybudget(["--version"]).ok().starts_with("raybudget "));
}

#[test]
fn results_go_to_standard_output_and_nothing_else_does() {
    let ran = raybudget(["profile", "cornell"].into_iter().chain(SMALL));
    assert_eq!(ran.stderr, "");
    assert!(!ran.stdout.contains('\x1b'));
}

#[test]
fn a_reader_that_has_had_enough_is_a_success() {
    for args in [&["list", "counters"][..], &["profile", "cornell", "--size", "40x36", "--format", "json"]] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = Command::new(assert_cmd::cargo::cargo_bin!("raybudget"))
            .args(args)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .expect("the program starts");
        assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()), "{args:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_an_error() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let output = Command::new(assert_cmd::cargo::cargo_bin!("raybudget"))
        .args(["list", "scenes"])
        .stdout(full)
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(stderr.starts_with("error: standard output: cannot write"), "{stderr}");
}

/// On a terminal, made by `script` of util-linux.
#[test]
#[cfg(target_os = "linux")]
fn a_terminal_gets_bold_headings_unless_no_color_is_set() {
    let program = assert_cmd::cargo::cargo_bin!("raybudget");
    let on_terminal = |no_color: Option<&str>| {
        let line = format!("{} profile cornell --size 8x8", program.display());
        let mut script = Command::new("script");
        script.args(["-qec", &line, "/dev/null"]).env_remove("NO_COLOR").stdin(Stdio::null());
        if let Some(value) = no_color {
            script.env("NO_COLOR", value);
        }
        script.output().map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let Ok(coloured) = on_terminal(None) else {
        eprintln!("skipped: there is no `script` to make a terminal with");
        return;
    };
    assert!(coloured.contains("\x1b[1mLower bounds of the frame time\x1b[0m"), "{coloured}");
    assert!(on_terminal(Some("")).expect("as before").contains("\x1b[1m"));
    assert!(!on_terminal(Some("1")).expect("as before").contains("\x1b[1mBounds"));
}

#[test]
fn without_a_command_the_default_scene_is_profiled_into_a_folder() {
    let folder = crate::support::folder();
    let text = finish(command().current_dir(folder.path())).ok();
    assert!(text.starts_with("atrium on adreno-540\n"), "{text}");
    assert_eq!(crate::support::names_in(folder.path()), ["raybudget-out"]);
    assert_eq!(crate::support::names_in(&folder.path().join("raybudget-out")), crate::support::REPORT_FILES);
}
