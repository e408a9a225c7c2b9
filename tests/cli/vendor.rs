//! Are counters printed under the names of the profiler of the GPU's maker, each with a formula that can be looked up?

use crate::support::raybudget;
use serde_json::Value;
use std::collections::BTreeMap;

fn profile(gpu: &str, format: &str) -> Vec<String> {
    ["profile", "cornell", "--size", "40x24", "--gpu", gpu, "--format", format].map(str::to_owned).to_vec()
}

/// Formula by the name under which a counter is printed, from `list counters`; empty where a profiler's counter is absent.
fn listed() -> BTreeMap<String, String> {
    let rows = raybudget(["list", "counters", "--format", "json"]).json();
    let text = |row: &Value, column: &str| row[column].as_str().unwrap_or_default().to_owned();
    rows.as_array().expect("rows").iter().map(|row| (text(row, "name"), text(row, "formula"))).collect()
}

/// Names of the counters that a text report prints.
fn printed(text: &str) -> Vec<&str> {
    let (counters, _) = text.split_once("\nAbsent counters").expect("some are absent");
    let rows = counters.lines().filter(|line| line.starts_with("  "));
    rows.map(|line| line.trim_start().split_once("  ").expect("a name and its figures").0).collect()
}

#[test]
fn every_printed_counter_has_its_formula_in_the_list_on_every_gpu() {
    let listed = listed();
    for gpu in gpumodel::GPUS {
        let text = raybudget(profile(gpu.name, "text")).ok();
        let names = printed(&text);
        assert!(names.len() > 30, "{text}");
        for name in names {
            let formula = listed.get(name).unwrap_or_else(|| panic!("{name} of {} is not listed", gpu.name));
            assert!(!formula.is_empty(), "{name} of {} has no formula", gpu.name);
        }
    }
}

#[test]
fn adrenos_speak_snapdragon_profiler_and_malis_streamline() {
    let text = |gpu| raybudget(profile(gpu, "text")).ok();
    let (adreno, mali, neither) = (text("adreno-540"), text("mali-g715"), text("vulkan-sim-mobile"));
    for name in ["GPU % Bus Busy", "% Shaders Busy", "% Time ALUs Working", "% Wave Context Occupancy"] {
        assert!(printed(&adreno).contains(&name), "{name}: {adreno}");
        assert!(!mali.contains(name) && !neither.contains("% Shaders Busy"), "{name}");
    }
    for name in
        ["MaliSCBusLSL2RdBt", "MaliL2CacheRdMissRate", "MaliExtBusRdBy", "MaliALUUtil", "MaliLSIssueCy"]
    {
        assert!(printed(&mali).contains(&name), "{name}: {mali}");
        assert!(!adreno.contains(name) && !neither.contains(name), "{name}");
    }
    // What a profiler renames is not printed twice.
    assert!(!printed(&adreno).contains(&"Shaders Busy") && printed(&mali).contains(&"Shaders Busy"));
    assert!(!printed(&mali).contains(&"L2 Miss Ratio") && printed(&adreno).contains(&"L2 Miss Ratio"));
    assert!(printed(&neither).contains(&"L2 Miss Ratio") && printed(&neither).contains(&"Shaders Busy"));
}

#[test]
fn the_view_in_json_follows_from_the_counters_beside_it() {
    let report = raybudget(profile("mali-g715", "json")).json();
    let ours = |id: &str| report["counters"][id]["value"].as_f64().expect("a figure");
    let view = &report["vendor"];
    assert_eq!(view["profiler"], "Streamline");
    let theirs = |name: &str| view["counters"][name]["value"].as_f64().expect("a figure");
    assert_eq!(theirs("MaliL2CacheLookup"), ours("l2_accesses"));
    assert!((theirs("MaliL2CacheRdMissRate") - 100.0 * ours("l2_miss_ratio")).abs() < 1e-9);
    assert_eq!(theirs("MaliExtBusRdBt"), ours("dram_read_bytes") / 16.0);
    assert_eq!(theirs("MaliSCBusLSL2RdBt"), 4.0 * ours("load_store_l2_accesses"));
    assert_eq!(view["counters"]["MaliExtBusRdBt"]["formula"], "external_read_bytes / 16");
    assert!(view["counters"]["MaliExtBusRdBt"]["value"].is_u64(), "a count made of counts");
    for (name, counter) in view["counters"].as_object().expect("counters") {
        let has_reason = counter["reason"].as_str().is_some_and(|reason| !reason.is_empty());
        assert_eq!(counter["value"].is_null(), has_reason, "{name}");
    }
    assert_eq!(view["counters"]["MaliRTURay"]["reason"], "no ray unit walks the structure");
    let passes = view["passes"].as_array().expect("passes");
    assert_eq!(passes.len(), report["passes"].as_array().expect("passes").len());
    let sum: f64 = passes.iter().filter_map(|pass| pass["counters"]["MaliLSIssueCy"].as_f64()).sum();
    assert_eq!(sum, theirs("MaliLSIssueCy"));
    // A texture is read by nobody here: absent, neither 0 nor NaN.
    assert!(
        view["counters"]["MaliSCBusTexL2RdBt"]["reason"]
            .as_str()
            .is_some_and(|reason| reason.contains("Texture L2"))
    );

    // Behind a system cache, what the GPU itself reads is not counted apart.
    let behind = raybudget(profile("mali-g720", "json")).json();
    let reason = behind["vendor"]["counters"]["MaliExtBusRdBy"]["reason"].as_str().expect("absent");
    assert!(reason.contains("the system cache"), "{reason}");

    let report = raybudget(profile("adreno-540", "json")).json();
    let busy = &report["vendor"]["counters"]["% Shaders Busy"];
    assert_eq!(busy["unit"], "%");
    let ratio = report["counters"]["shaders_busy"]["value"].as_f64().expect("a ratio");
    assert!((busy["value"].as_f64().expect("a share") - 100.0 * ratio).abs() < 1e-9);
    assert_eq!(report["vendor"]["counters"]["Clocks / Second"]["value"], 710e6);

    assert!(raybudget(profile("vulkan-sim-mobile", "json")).json().get("vendor").is_none());
}

#[test]
fn the_list_gives_formula_or_reason_for_every_name() {
    let text = raybudget(["list", "counters"]).ok();
    for heading in [
        "Snapdragon Profiler: GPU Memory Stats",
        "Streamline: Ray Tracing Unit",
        "Figures of the GPU in these formulas",
    ] {
        assert!(text.contains(heading), "{heading}");
    }
    for profiler in reports::vendor::Profiler::all().expect("sound") {
        for info in &profiler.counters {
            let at = text.find(&format!("  {} [", info.name)).expect("it is listed");
            let paragraph: Vec<&str> = text[at..].lines().take(2).collect();
            match &info.formula {
                reports::vendor::Formula::Known(formula) => assert!(paragraph[1].contains(formula.text())),
                reports::vendor::Formula::Absent { reason } => {
                    assert_eq!(paragraph[1].trim(), format!("absent: {reason}"));
                }
            }
        }
    }
}

#[test]
fn the_list_of_gpus_says_how_much_of_each_is_known() {
    let rows = raybudget(["list", "gpus", "--format", "json"]).json();
    for (row, builtin) in rows.as_array().expect("rows").iter().zip(gpumodel::GPUS) {
        let count = |column: &str| row[column].as_u64().expect("a count");
        let known = count("measured") + count("vendor") + count("driver");
        let all = known + count("aggregator") + count("estimate");
        assert_eq!(row["gpu"], builtin.name);
        assert_eq!(row["known"], format!("{} %", 100 * known / all));
        assert!(known > 0 && known < all, "{row}");
    }
}
