//! `raybudget compare`: every axis, every form, and what it refuses.

use crate::support::{arg, folder, names_in, raybudget, without_run};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const TINY: [&str; 2] = ["--size", "40x24"];

/// Every axis with the options it needs, and how many values it takes by its name alone.
fn axes() -> Vec<(&'static str, &'static [&'static str], usize)> {
    vec![
        ("traversal", &[], tracer::Traversal::ALL.len()),
        ("ct-ci", &[], 4),
        ("short-stack", &["--traversal", "restart-trail"], 4),
        ("gpu", &[], gpumodel::GPUS.len()),
        ("technique", &["--force", "mirror"], gpumodel::TECHNIQUES.len()),
        ("layout", &[], gpumodel::PrimitiveLayout::ALL.len()),
        ("primitive-order", &[], gpumodel::PrimitiveOrder::ALL.len()),
        ("node-records", &[], gpumodel::NodeRecords::ALL.len()),
        ("node-order", &[], gpumodel::NodeOrder::ALL.len()),
        ("cache.uche.line=64+128", &[], 2),
    ]
}

/// The schema of comparisons, with that of reports in its place.
pub(crate) fn validator() -> jsonschema::Validator {
    let schema = |text: &str| serde_json::from_str::<Value>(text).expect("the schema is JSON");
    let mut whole = schema(reports::comparison::json::SCHEMA_TEXT);
    let mut report = schema(reports::json::SCHEMA_TEXT);
    report["$id"] = json!("urn:raybudget:report-1");
    whole["properties"]["variants"]["items"]["properties"]["report"] = report;
    jsonschema::validator_for(&whole).expect("the schema is a JSON Schema")
}

fn variants(comparison: &Value) -> &[Value] {
    comparison["variants"].as_array().expect("variants")
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn every_axis_alone_gives_a_variant_for_each_value_in_every_form() {
    let validator = validator();
    let dir = folder();
    for (axis, options, count) in axes() {
        let out = dir.path().join(axis.split('=').next().expect("a name"));
        let args = ["compare", "cornell", "--vary", axis, "--format", "json", "-o", arg(&out)];
        let printed = raybudget(args.iter().chain(options).chain(&TINY)).ok();
        let comparison: Value = serde_json::from_str(&printed).expect("JSON");
        let errors: Vec<String> = validator.iter_errors(&comparison).map(|error| error.to_string()).collect();
        assert_eq!(errors, Vec::<String>::new(), "{axis}");
        assert_eq!(variants(&comparison).len(), count, "{axis}");
        assert_eq!(read(&out, "comparison.json"), printed, "{axis}");

        let csv = read(&out, "comparison.csv");
        assert_eq!(csv.lines().count(), 1 + count * gpumodel::COUNTERS.len(), "{axis}");
        assert!(csv.starts_with(axis.split('=').next().expect("a name")), "{axis}");
        for variant in variants(&comparison) {
            let value = variant["values"][0].as_str().expect("a value");
            assert!(csv.contains(&format!("{value},frame_time_ms,ms,")), "{axis} {value}");
            assert!(read(&out, "comparison.md").contains(&format!("| {value} |")), "{axis} {value}");
        }
        assert_pictures(&out, axis);
    }
}

/// Each chart twice, as SVG and PNG; heat maps where there are several traces, or several ways to trace reflections.
fn assert_pictures(out: &Path, axis: &str) {
    let names = names_in(out);
    let charts = names.iter().filter_map(|name| name.strip_suffix(".svg"));
    let charts: Vec<&str> = charts.collect();
    assert!(charts.contains(&"frame-time") && charts.contains(&"frames-per-second"), "{axis}: {names:?}");
    for chart in charts {
        let svg = read(out, &format!("{chart}.svg"));
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "{axis}: {chart}");
        assert!(names.contains(&format!("{chart}.png")), "{axis}: {chart}");
    }
    for name in names.iter().filter(|name| name.ends_with(".png")) {
        let png = fs::read(out.join(name)).expect("a file");
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "{axis}: {name}");
    }
    let traces_differ = ["traversal", "ct-ci", "short-stack", "technique"].contains(&axis);
    for map in ["node-fetches.png", "loaded-bytes.png", "dram-lines.png"] {
        assert_eq!(names.iter().any(|name| name == map), traces_differ, "{axis}: {map}");
    }
}

#[test]
fn a_variant_equals_the_profile_with_the_same_options() {
    let vary = "traversal,layout=padded+split,technique=fragment+hybrid";
    let comparison =
        raybudget(["compare", "cornell", "--vary", vary, "--format", "json"].iter().chain(&TINY));
    let comparison = comparison.json();
    assert_eq!(comparison["axes"], json!(["traversal", "layout", "technique"]));
    let mut compared = variants(&comparison).iter();
    for traversal in tracer::Traversal::ALL {
        for layout in ["padded", "split"] {
            for technique in ["fragment", "hybrid"] {
                let variant = compared.next().expect("a variant for each combination");
                let name = format!("{}-{}", traversal.accel().name(), traversal.name());
                assert_eq!(variant["values"], json!([name, layout, technique]));
                let machine = ["--layout", layout, "--technique", technique];
                let frame = ["--accel", traversal.accel().name(), "--traversal", traversal.name()];
                let fixed = ["profile", "cornell", "--format", "json"];
                let profile = raybudget(fixed.iter().chain(&machine).chain(&frame).chain(&TINY)).json();
                assert_eq!(without_run(&variant["report"]), without_run(&profile), "{:?}", variant["values"]);
            }
        }
    }
    assert_eq!(compared.next(), None);
}

#[test]
fn options_of_the_frame_hold_for_every_variant_and_its_axis_wins() {
    let args = ["compare", "cornell", "--vary", "ct-ci=1:1+3:1.5,cache.uche.line=64+128"];
    let more = ["--ct", "9", "--set", "cache.uche.size=65536", "--layout", "split", "--format", "json"];
    let comparison = raybudget(args.iter().chain(&more).chain(&TINY)).json();
    assert_eq!(variants(&comparison).len(), 4);
    let inputs = |index: usize| &variants(&comparison)[index]["report"]["inputs"];
    assert_eq!(inputs(1)["layout"], "split");
    assert_eq!(inputs(1)["gpu"], "adreno-540 with cache.uche.size=65536, cache.uche.line=128");
    assert_eq!((&inputs(1)["sah_costs"], &inputs(2)["sah_costs"]), (&json!([1.0, 1.0]), &json!([3.0, 1.5])));
}

#[test]
fn several_scenes_are_the_first_axis() {
    let args = ["compare", "cornell", "teapot", "--vary", "layout=padded+split", "--format", "json"];
    let comparison = raybudget(args.iter().chain(&TINY)).json();
    assert_eq!(comparison["axes"], json!(["scene", "layout"]));
    let values: Vec<&Value> = variants(&comparison).iter().map(|variant| &variant["values"]).collect();
    let expected = [["cornell", "padded"], ["cornell", "split"], ["teapot", "padded"], ["teapot", "split"]];
    assert_eq!(values, expected.map(|pair| json!(pair)).iter().collect::<Vec<_>>());
}

#[test]
fn files_are_the_same_bytes_on_any_number_of_threads() {
    for axis in ["traversal", "technique", "ct-ci"] {
        let dir = folder();
        let [one, two] = ["1", "2"].map(|threads| {
            let out = dir.path().join(threads);
            let args = ["compare", "teapot", "--vary", axis, "--threads", threads, "-o", arg(&out)];
            raybudget(args.iter().chain(&["--size", "100x70", "--force", "mirror"])).ok();
            out
        });
        assert_eq!(names_in(&one), names_in(&two));
        for name in names_in(&one) {
            if name == "comparison.json" {
                let reports = |folder: &Path| -> Vec<Value> {
                    let comparison: Value = serde_json::from_str(&read(folder, &name)).expect("JSON");
                    variants(&comparison).iter().map(|variant| without_run(&variant["report"])).collect()
                };
                assert_eq!(reports(&one), reports(&two), "{axis}");
            } else {
                let bytes = |folder: &Path| fs::read(folder.join(&name)).expect("a file");
                assert!(bytes(&one) == bytes(&two), "{axis}: {name} differs");
            }
        }
    }
}

#[test]
fn combinations_without_meaning_are_left_out_and_named() {
    let json = |vary: &str| {
        let args = ["compare", "cornell", "--vary", vary, "--format", "json"];
        raybudget(args.iter().chain(&TINY)).json_with_warning()
    };
    let (comparison, warnings) = json("traversal,ct-ci");
    assert_eq!(variants(&comparison).len(), 11 * 4);
    assert_eq!(warnings.lines().count(), 4, "{warnings}");
    assert!(warnings.contains("left out grid-dda 3:1.5: a grid is not built by costs"), "{warnings}");

    let (comparison, warnings) = json("traversal=bvh-stack+bvh-parent-link,node-records=packed+child-boxes");
    assert_eq!(variants(&comparison).len(), 3);
    assert!(warnings.starts_with("warning: left out bvh-parent-link child-boxes: "), "{warnings}");

    let (comparison, warnings) = json("traversal=bvh-stack+kd-push-down,short-stack=0+4");
    assert_eq!(variants(&comparison).len(), 2);
    assert!(
        warnings.contains("left out bvh-stack 4: only restart-trail, push-down and short-stack"),
        "{warnings}"
    );
}

#[test]
fn every_ray_unit_is_compared_where_it_has_a_part() {
    let args = ["compare", "cornell", "--gpu", "adreno-830", "--accel", "wide-bvh", "--vary", "ray-unit"];
    let all = [&args[..], &["--traversal", "short-stack", "--format", "json"]].concat();
    let comparison = raybudget(all.iter().chain(&TINY)).json();
    let boxes = |variant: &Value| variant["report"]["counters"]["ray_unit_box_nodes"]["value"].as_f64();
    let values: Vec<&Value> = variants(&comparison).iter().map(|variant| &variant["values"][0]).collect();
    assert_eq!(values, ["none", "warp", "ray", "instruction"]);
    let boxes: Vec<Option<f64>> = variants(&comparison).iter().map(boxes).collect();
    assert!(boxes[0].is_none() && boxes[3] >= boxes[1], "{boxes:?}");
    assert_eq!(boxes[2], boxes[3], "each ray by itself, whoever walks");

    let all = [&args[..], &["--traversal", "stack", "--format", "json"]].concat();
    let (comparison, warnings) = raybudget(all.iter().chain(&TINY)).json_with_warning();
    assert_eq!(variants(&comparison).len(), 3);
    assert!(
        warnings.contains("left out instruction: the instruction of a ray unit tests nodes"),
        "{warnings}"
    );
}

#[test]
fn traversals_that_an_option_of_the_frame_does_not_fit_are_left_out() {
    for (option, value, left, reason) in [
        ("--ct", "2", 11, "a grid is not built by costs"),
        ("--ci", "2", 11, "a grid is not built by costs"),
        ("--short-stack", "4", 4, "have a short stack"),
        ("--trail-bits", "32", 1, "only restart-trail has a trail"),
        ("--splits", "perfect", 4, "only kd-trees"),
        ("--empty-bonus", "0.8", 4, "only kd-trees"),
        ("--max-depth", "9", 4, "only kd-trees"),
        ("--flat-cells", "allowed", 3, "backtracking cannot leave"),
        ("--node-records", "child-boxes", 2, "boxes of both children"),
        ("--node-format", "full-4", 4, "only nodes of wide BVHs"),
        ("--node-order", "van-emde-boas", 9, "parts the children"),
    ] {
        let args = ["compare", "cornell", "--vary", "traversal", option, value, "--format", "json"];
        let (comparison, warnings) = raybudget(args.iter().chain(&TINY)).json_with_warning();
        assert_eq!(variants(&comparison).len(), left, "{option}: {warnings}");
        assert!(warnings.contains(reason), "{option}: {warnings}");
    }
}

#[test]
fn what_cannot_vary_is_refused_before_the_scene_is_loaded() {
    let dir = folder();
    let out = dir.path().join("deep/out");
    for (vary, expected) in [
        (&["colour"][..], "--vary colour: no such axis; use: traversal, ct-ci"),
        (&["traversal=bvh-zigzag"], "no such one; use: bvh-stack"),
        (&["traversal=stack"], "no such one; use: bvh-stack"),
        (&["ct-ci=3"], "expected Ct:Ci"),
        (&["ct-ci=a:b"], "expected Ct:Ci"),
        (&["short-stack=-1"], "expected a number of entries"),
        (&["gpu=adreno-9999"], "--gpu adreno-9999"),
        (&["technique=magic"], "--technique magic"),
        (&["layout=tight"], "--layout tight: no such choice; use one of: padded, compact, split"),
        (&["primitive-order=random"], "--primitive-order random"),
        (&["node-records=huge"], "--node-records huge"),
        (&["node-order=random"], "--node-order random"),
        (&["cache.uche.line"], "a figure of the GPU needs values"),
        (&["cache.l9.line=1+2"], "has no figure 'cache.l9.line'"),
        (&["cache.uche.line=64+3"], "cache.uche.line"),
        (&["layout=split+"], "a value is empty or given twice"),
        (&["layout=split+split"], "a value is empty or given twice"),
        (&["layout,layout"], "given twice"),
        (&["layout", "layout=split"], "given twice"),
        (&["ct-ci=fine,traversal,layout,technique"], "more than 1000 combinations"),
        (
            &["short-stack"],
            "no combination is left to compare, for only restart-trail, push-down and short-stack",
        ),
    ] {
        let given = vary.iter().flat_map(|vary| ["--vary", vary]);
        let message =
            raybudget(["compare", "no-such-scene", "-o", arg(&out)].into_iter().chain(given)).refused();
        assert!(message.contains(expected), "{vary:?}: {message}");
        assert_eq!(names_in(dir.path()), Vec::<String>::new(), "{vary:?}");
    }
    let message = raybudget(["compare", "cornell"]);
    assert_eq!(message.code, Some(2));
    assert!(message.stderr.contains("--vary"), "{}", message.stderr);
}

#[test]
fn a_comparison_that_fails_half_way_leaves_no_folder() {
    let dir = folder();
    let out = dir.path().join("deep/out");
    for (args, expected) in [
        (&["cornell", "no-such-scene", "--vary", "layout"][..], "no-such-scene"),
        (&["cornell", "--vary", "ct-ci=3:1.5+3:0"], "Ci = 0"),
        (&["cornell", "--vary", "short-stack=0+1000000", "--traversal", "restart-trail"], "1000000"),
    ] {
        let message = raybudget(["compare", "-o", arg(&out)].iter().chain(args).chain(&TINY)).refused();
        assert!(message.contains(expected), "{args:?}: {message}");
        assert_eq!(names_in(dir.path()), Vec::<String>::new(), "{args:?}");
    }
}

#[test]
fn scenes_that_are_missing_or_of_one_name_are_refused_before_any_work() {
    for (scenes, expected) in
        [(["cornell", "no-such-scene"], "no-such-scene"), (["cornell", "cornell"], "cannot be told apart")]
    {
        let ran = raybudget(["compare", scenes[0], scenes[1], "--vary", "layout", "--size", "8x8"]);
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains(expected) && ran.stdout.is_empty(), "{}", ran.stderr);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_and_nothing_else_is_left() {
    let folder = folder();
    fs::create_dir(folder.path().join("comparison.csv")).expect("a folder in the way");
    let ran =
        raybudget(["compare", "cornell", "--vary", "layout", "--size", "8x8", "-o", arg(folder.path())]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("this is a folder"), "{}", ran.stderr);
    assert_eq!(names_in(folder.path()), ["comparison.csv"]);
}

#[test]
fn finished_reports_are_compared_as_they_are() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (name, accel) in [("before.json", "bvh"), ("after.json", "kd")] {
        let report =
            raybudget(["profile", "teapot", "--accel", accel, "--format", "json"].into_iter().chain(TINY))
                .ok();
        fs::write(path(name), report).expect("a file");
    }
    let (before, after) = (path("before.json"), path("after.json"));
    let of_reports = |options: &[&str]| {
        raybudget(["compare", arg(&before), arg(&after)].into_iter().chain(options.iter().copied()))
    };
    let json = of_reports(&["--format", "json"]).json();
    assert!(validator().is_valid(&json));
    assert_eq!(json["axes"], json!(["report", "accel", "primitive-order"]));
    let read: Value = serde_json::from_str(&fs::read_to_string(&after).expect("a text")).expect("JSON");
    assert_eq!(variants(&json)[1]["report"], read);

    for (options, expected) in [
        (&["--vary", "layout"][..], "compared as they are"),
        (&["--size", "8x8"], "compared as they are"),
        (&["cornell"], "compared as they are"),
        (&[arg(&before)], "given twice"),
    ] {
        let ran = of_reports(options);
        assert_eq!(ran.code, Some(2));
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    }
    let nothing = raybudget(["compare", "cornell"]);
    assert!(nothing.code == Some(2) && nothing.stderr.contains("nothing varies"), "{}", nothing.stderr);
}

#[test]
fn the_parts_of_a_difference_add_up_to_what_the_counters_say() {
    let folder = folder();
    let args = [
        "compare",
        "teapot",
        "--vary",
        "traversal=bvh-stack+kd-push-down",
        "--format",
        "json",
        "-o",
        arg(folder.path()),
    ];
    let json = raybudget(args.into_iter().chain(TINY)).json();
    let number = |value: &Value| value.as_f64().expect("a number");
    let [first, other] = variants(&json) else { panic!("two variants") };
    let counter = |variant: &Value, id: &str| number(&variant["report"]["counters"][id]["value"]);
    let bytes = |variant: &Value| counter(variant, "dram_read_bytes") + counter(variant, "dram_write_bytes");
    let time = |variant: &Value| counter(variant, "frame_time_ms");
    let totals = [
        ("DRAM bytes", bytes(first), bytes(other)),
        ("frame time", time(first), time(other)),
        ("frame time by pass", time(first), time(other)),
    ];
    let made = other["attributions"].as_array().expect("attributions");
    assert_eq!(made.len(), totals.len());
    for (made, (what, before, after)) in made.iter().zip(totals) {
        assert_eq!(made["what"], what);
        for (key, total) in [("before", before), ("after", after)] {
            let sum: f64 =
                made["parts"].as_array().expect("parts").iter().map(|part| number(&part[key])).sum();
            let near = |figure: f64| (figure - total).abs() <= 1e-9 * total;
            assert!(near(sum) && near(number(&made[key])), "{what} {key}: {sum} of {total}");
        }
    }
    let page = read(folder.path(), "comparison.html");
    for part in [
        "<section id=\"attribution\">",
        "<section id=\"counters\">",
        "<svg",
        "kd-push-down",
        "within 13.80 %",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(
        !page.contains("http://") || page.contains("http://www.w3.org/2000/svg"),
        "a page that asks the network"
    );
}
