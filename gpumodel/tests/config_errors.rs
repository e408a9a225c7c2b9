//! Does every wrong configuration get an error that names file, place, expectation and remedy?

use gpumodel::{BuiltinGpu, GPUS, Gpu, ShaderCosts};

const COSTS: &str = include_str!("../../configs/costs.toml");

fn adreno_540() -> &'static str {
    BuiltinGpu::named("adreno-540").expect("it is built in").toml
}

/// The message for a description in which `from` is replaced by `to`, and the line at which `from` stands.
fn gpu_error(from: &str, to: &str) -> (String, usize) {
    let text = adreno_540();
    let at = text.find(from).unwrap_or_else(|| panic!("the description has '{from}'"));
    let changed = text.replacen(from, to, 1);
    let error = Gpu::parse(&changed, "my-gpu.toml").err().unwrap_or_else(|| panic!("'{to}' is refused"));
    (error.to_string(), text[..at].matches('\n').count() + 1)
}

#[test]
fn wrong_figures_are_refused_with_their_key_line_and_range() {
    for (from, to, key, expectation) in [
        ("mhz = { value = 710", "mhz = { value = 0", "clock.mhz", "expected 0.000001 to 10000000"),
        ("mhz = { value = 710", "mhz = { value = -1.5", "clock.mhz", "is -1.5"),
        ("mhz = { value = 710", "mhz = { value = nan", "clock.mhz", "is NaN"),
        ("mhz = { value = 710", "mhz = { value = inf", "clock.mhz", "is inf"),
        ("count = { value = 4", "count = { value = 0", "shader_cores.count", "expected 1 to 256"),
        ("count = { value = 4", "count = { value = 257", "shader_cores.count", "expected 1 to 256"),
        ("warp_slots = { value = 16", "warp_slots = { value = 0", "shader_cores.warp_slots", "is 0"),
        ("alu_lanes = { value = 64", "alu_lanes = { value = 0", "shader_cores.alu_lanes", "is 0"),
        ("efu_lanes = { value = 12.8", "efu_lanes = { value = 0.0", "shader_cores.efu_lanes", "is 0"),
        ("vec4 = { value = 48", "vec4 = { value = 0", "registers.vec4", "is 0"),
        ("granularity = { value = 2", "granularity = { value = 0", "registers.granularity", "is 0"),
        (
            "bytes_per_clock = { value = 16",
            "bytes_per_clock = { value = 0",
            "load_store.bytes_per_clock",
            "is 0",
        ),
        ("warp_pixels = { value = [8, 4]", "warp_pixels = { value = [8, 8]", "warp_pixels", "warp width 32"),
        ("warp_pixels = { value = [8, 4]", "warp_pixels = { value = [32, 1]", "warp_pixels", "powers of two"),
        ("size = { value = 131072", "size = { value = 131073", "cache.uche", "expected a whole number"),
        ("size = { value = 131072", "size = { value = 0", "cache.uche", "size"),
        ("ways = { value = 8", "ways = { value = 0", "cache.uche", "ways"),
        ("ways = { value = 8", "ways = { value = 3", "cache.uche", "3 ways"),
        (
            "latency_cycles = { value = 66",
            "latency_cycles = { value = 0",
            "cache.uche.latency_cycles",
            "is 0",
        ),
        ("texture = { value = [\"tp_l1\"", "texture = { value = [\"l9\"", "paths.texture", "'l9'"),
        ("ssbo = { value = [\"uche\"]", "ssbo = { value = []", "paths.ssbo", "at least one cache"),
        ("peak_gbs = { value = 29.8", "peak_gbs = { value = 0", "dram.peak_gbs", "is 0"),
        ("efficiency = { value = 0.83", "efficiency = { value = 1.01", "dram.efficiency", "0.01 to 1"),
        ("latency_ns = { value = 300", "latency_ns = { value = 0", "dram.latency_ns", "is 0"),
        ("name = \"adreno-540\"", "name = \"\"", "identity.name", "is empty"),
        (
            "source = \"Linux msm8998.dtsi, highest operating point\"",
            "source = \" \"",
            "clock.mhz",
            "empty source",
        ),
    ] {
        let (message, line) = gpu_error(from, to);
        // A cache as a whole is reported at its name.
        let at_line = message.starts_with(&format!("my-gpu.toml:{line}: "));
        let at_table = key.starts_with("cache.") && message.starts_with("my-gpu.toml:");
        assert!(at_line || at_table, "line {line}: {message}");
        assert!(message.contains(key), "{key}: {message}");
        assert!(message.contains(expectation), "{expectation}: {message}");
        assert!(message.contains("; "), "a remedy: {message}");
    }
}

#[test]
fn a_line_of_the_wrong_size_is_refused_on_both_sides() {
    for (line, expectation) in
        [("8", "expected 16 to 4096"), ("8192", "expected 16 to 4096"), ("48", "power of two")]
    {
        let from = "line = { value = 64, source = \"as measured";
        let (message, _) = gpu_error(from, &from.replace("64", line));
        assert!(message.contains("cache.uche.line") && message.contains(expectation), "{message}");
    }
}

#[test]
fn unknown_missing_and_malformed_keys_are_refused_with_their_line() {
    for (from, to, expectation) in [
        ("[clock]\n", "[clock]\nghz = 1\n", "ghz"),
        ("[dram]\n", "[dramm]\n", "dramm"),
        ("mhz = {", "mhzz = {", "mhzz"),
        ("granularity = {", "# granularity = {", "granularity"),
        ("tag = \"driver\"", "tag = \"rumour\"", "rumour"),
        ("policy = { value = \"lru\"", "policy = { value = \"mru\"", "mru"),
        ("family = \"adreno\"", "family = \"voodoo\"", "voodoo"),
        ("count = { value = 4", "count = { value = 4.5", "4.5"),
        ("count = { value = 4", "count = { value = \"four\"", "four"),
        ("[registers]", "[registers", "my-gpu.toml:"),
    ] {
        let (message, _) = gpu_error(from, to);
        assert!(message.starts_with("my-gpu.toml:"), "{message}");
        assert!(message.contains(expectation), "{expectation}: {message}");
    }
    let empty = Gpu::parse("", "empty.toml").unwrap_err().to_string();
    assert!(empty.starts_with("empty.toml") && empty.contains("missing"), "{empty}");
}

#[test]
fn every_figure_is_needed() {
    let text = adreno_540();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| line.contains(" = ")) {
        if line.starts_with('#') {
            continue;
        }
        let without: Vec<_> =
            text.lines().enumerate().filter(|&(at, _)| at != number).map(|(_, l)| l).collect();
        assert!(Gpu::parse(&without.join("\n"), "x").is_err(), "without '{line}'");
    }
}

#[test]
fn built_in_descriptions_are_sound_and_say_where_their_figures_come_from() {
    for gpu in GPUS {
        let parsed = Gpu::builtin(gpu.name).expect("listed").expect("sound");
        assert_eq!(parsed.name(), gpu.name);
        let provenance = parsed.provenance();
        let figures =
            gpu.toml.lines().filter(|line| line.contains("tag = ") && !line.starts_with('#')).count();
        let counted = provenance.measured
            + provenance.vendor
            + provenance.driver
            + provenance.aggregator
            + provenance.estimate;
        assert_eq!(counted, figures);
        assert_eq!(parsed.estimates().len(), provenance.estimate);
        assert!(parsed.estimates().contains(&"cache.uche.ways".to_owned()));
        assert!(!parsed.estimates().contains(&"clock.mhz".to_owned()));
    }
    assert!(Gpu::builtin("adreno-541").is_none());
}

#[test]
fn wrong_costs_are_refused() {
    ShaderCosts::parse(COSTS, "costs.toml").expect("the built-in costs are sound");
    for (from, to, expectation) in [
        ("alu = 76", "alu = 65537", "bvh-stack.node"),
        ("alu = 76", "alu = -1", "-1"),
        ("[bvh-stack]", "[bvh-stak]", "bvh-stak"),
        ("loop = {", "lop = {", "lop"),
        ("registers = { value = 12", "registers = { value = 0", "bvh-stack.registers"),
        ("source = \"compare and branch per trip\"", "source = \"\"", "shared.loop"),
    ] {
        assert!(COSTS.contains(from), "the costs have '{from}'");
        let error =
            ShaderCosts::parse(&COSTS.replacen(from, to, 1), "my-costs.toml").unwrap_err().to_string();
        assert!(error.starts_with("my-costs.toml:") && error.contains(expectation), "{error}");
    }
    ShaderCosts::parse(&COSTS.replacen("alu = 76", "alu = 65536", 1), "x")
        .expect("the limit itself is allowed");
}
