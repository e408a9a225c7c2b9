//! Does every wrong configuration get an error that names file, place, expectation and remedy?

use gpumodel::{BuiltinGpu, EnergyTable, GPUS, Gpu, ShaderCosts};

const COSTS: &str = include_str!("../../configs/costs.toml");

fn adreno_540() -> &'static str {
    BuiltinGpu::named("adreno-540").expect("it is built in").toml
}

/// As [`error_of`], of the Adreno 540.
fn gpu_error(from: &str, to: &str) -> (String, usize) {
    error_of(adreno_540(), from, to)
}

/// The message for a description in which `from` is replaced by `to`, and the line at which `from` stands.
fn error_of(text: &str, from: &str, to: &str) -> (String, usize) {
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
            "warp_slots = { value = 16",
            "warp_slots = { value = 1",
            "shader_cores.warp_slots",
            "no fewer than the 2",
        ),
        (
            "lines_in_flight = { value = 64",
            "lines_in_flight = { value = 0",
            "load_store.lines_in_flight",
            "is 0",
        ),
        (
            "lines_in_flight = { value = 64, source = \"nothing published; as",
            "lines_in_flight = { value = 0, source = \"nothing published; as",
            "texture.lines_in_flight",
            "expected 1 to 65536",
        ),
        ("latency_cycles = { value = 80", "latency_cycles = { value = -1", "texture.latency_cycles", "is -1"),
        (
            "latency_cycles = { value = 80",
            "latency_cycles = { value = nan",
            "texture.latency_cycles",
            "is NaN",
        ),
        (
            "latency_cycles = { value = 66",
            "latency_cycles = { value = inf",
            "cache.uche.latency_cycles",
            "is inf",
        ),
        (
            "latency_cycles = { value = 66",
            "latency_cycles = { value = nan",
            "cache.uche.latency_cycles",
            "is NaN",
        ),
        ("bytes_per_clock = { value = 256", "bytes_per_clock = { value = 0", "tp_l1.bytes_per_clock", "is 0"),
        ("mshrs = { value = 256", "mshrs = { value = 0", "cache.uche.mshrs", "expected 1 to 65536"),
        ("banks = { value = 4", "banks = { value = 17", "cache.tp_l1.banks", "no more than the 16 lines"),
        ("size = { value = 131072", "size = { value = 256", "cache.uche", "0.500 sets of 8 ways"),
        (
            "standard = { value = \"lpddr4x\"",
            "standard = { value = \"hbm\"",
            "dram.standard",
            "lpddr4x, lpddr5, lpddr5x",
        ),
        ("channels = { value = 4", "channels = { value = 0", "dram.channels", "is 0"),
        ("efficiency = { value = 0.83", "efficiency = { value = 0.0", "dram.efficiency", "0.01 to 1"),
        ("peak_gbs = { value = 29.8", "peak_gbs = { value = inf", "dram.peak_gbs", "is inf"),
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

/// The built-in Adreno 540 with parts of its text replaced, as read.
fn with(replacements: &[(&str, &str)]) -> Result<Gpu, String> {
    let mut text = adreno_540().to_owned();
    for (from, to) in replacements {
        assert!(text.contains(from), "the description has '{from}'");
        text = text.replacen(from, to, 1);
    }
    Gpu::parse(&text, "my-gpu.toml").map_err(|error| error.to_string())
}

#[test]
fn a_farther_cache_must_not_answer_sooner_than_a_nearer_one_on_the_same_path() {
    // An image reaches the UCHE after 66 + 80 cycles, its own cache after 76.
    let uche = |cycles: &'static str| ("latency_cycles = { value = 66", cycles);
    let texture = |cycles: &'static str| ("latency_cycles = { value = 80", cycles);
    with(&[uche("latency_cycles = { value = 66"), texture("latency_cycles = { value = 10")])
        .expect("as soon");
    let message = with(&[texture("latency_cycles = { value = 9")]).expect_err("one cycle sooner");
    for part in ["paths.texture: ", "'uche' in 75 cycles", "76 of 'tp_l1'", "texture.latency_cycles"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    // A buffer does not pass the texture unit, unless its path begins there.
    let private = ("private = { value = [\"uche\"]", "private = { value = [\"tp_l1\", \"uche\"]");
    with(&[private]).expect("through the texture unit");
    let message = with(&[private, texture("latency_cycles = { value = 9")]).expect_err("neither is right");
    assert!(message.contains("fewer than"), "{message}");
}

#[test]
fn a_cache_is_shared_by_a_divisor_of_the_cores() {
    let per = |cores: &'static str| [("per = \"gpu\"", cores)];
    for (cores, copies) in [("per = 1", 4), ("per = 2", 2), ("per = 4", 1), ("per = \"core\"", 4)] {
        assert_eq!(with(&per(cores)).expect("a divisor").caches[1].copies, copies, "{cores}");
    }
    for cores in ["per = 3", "per = 0", "per = 8"] {
        let message = with(&per(cores)).expect_err("no divisor");
        assert!(message.contains("cache.uche.per: ") && message.contains("4 cores"), "{message}");
    }
    assert!(with(&per("per = \"chip\"")).expect_err("no such word").contains("how many cores share"));
}

#[test]
fn extremes_that_are_legal_are_read() {
    let one_warp = [
        ("warp_slots = { value = 16", "warp_slots = { value = 1"),
        ("granularity = { value = 2", "granularity = { value = 1"),
    ];
    assert_eq!(with(&one_warp).expect("one warp").cores.warp_slots, 1);
    let two_warps = [("warp_slots = { value = 16", "warp_slots = { value = 2")];
    assert_eq!(with(&two_warps).expect("as many as the granularity").cores.warp_slots, 2);
    let one_line =
        [("size = { value = 1024", "size = { value = 64"), ("banks = { value = 4", "banks = { value = 1")];
    assert_eq!(with(&one_line).expect("one line").levels().as_slice()[0].lines(), 1);
    let one_set = [
        ("ways = { value = 8", "ways = { value = 1024"),
        ("size = { value = 131072", "size = { value = 65536"),
    ];
    assert_eq!(with(&one_set).expect("as many ways as lines").levels().as_slice()[1].sets(), 1);
    let all_banks = [("banks = { value = 4", "banks = { value = 16")];
    assert_eq!(with(&all_banks).expect("a bank for every line").caches[0].banks, 16);
    assert_eq!(with(&[("mhz = { value = 710", "mhz = { value = 1e7")]).expect("10 THz").clock.hz, 1e13);
    let slow = with(&[("peak_gbs = { value = 29.8", "peak_gbs = { value = 1e-9")]).expect("1 B/s");
    assert!((slow.dram.peak_bytes_per_second - 1.0).abs() < 1e-12);
    for cachesim::BuiltinDram { name: standard, .. } in cachesim::DRAM_STANDARDS {
        let to = format!("standard = {{ value = \"{standard}\"");
        assert_eq!(
            with(&[("standard = { value = \"lpddr4x\"", &to)]).expect("known").dram.standard.name,
            *standard
        );
    }
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
    }
    let estimates = Gpu::builtin("adreno-540").expect("listed").expect("sound").estimates();
    assert!(estimates.contains(&"cache.uche.ways".to_owned()));
    assert!(!estimates.contains(&"clock.mhz".to_owned()));
    assert!(Gpu::builtin("adreno-541").is_none());
}

#[test]
fn wrong_costs_are_refused() {
    const LOOP_SOURCE: &str = "Mesa 22.3.6 ir3 for Adreno 540, docs/shaders/bvh-stack.glsl and all others: a comparison per trip; \
                               the jump is no operation";
    ShaderCosts::parse(COSTS, "costs.toml").expect("the built-in costs are sound");
    for (from, to, expectation) in [
        ("alu = 63", "alu = 65537", "bvh-stack.node"),
        ("alu = 63", "alu = -1", "-1"),
        ("[bvh-stack]", "[bvh-stak]", "bvh-stak"),
        ("loop = {", "lop = {", "lop"),
        ("registers = { value = 9", "registers = { value = 0", "bvh-stack.registers"),
        (LOOP_SOURCE, "", "shared.loop"),
        ("march_step = { alu = 14", "march_step = { alu = 65537", "reflections.march_step"),
        ("march_step = {", "march_stride = {", "march_stride"),
        ("uber = { value = 9", "uber = { value = 0", "reflections.registers.uber"),
        ("[[4, 297]", "[[8, 297]", "reflections.uber_sizes"),
        ("record_bytes = { value = 32", "record_bytes = { value = 0", "reflections.pipeline.record_bytes"),
        ("any_hit = { alu = 33", "any_hit = { alu = 65537", "alpha.any_hit"),
        ("mask_bytes = { value = 262144", "mask_bytes = { value = 63", "alpha.mask_bytes"),
        ("[alpha]\nregisters = { value = 6", "[alpha]\nregisters = { value = 0", "alpha.registers"),
        ("live_bytes = { value = 32", "live_bytes = { value = 1025", "reflections.pipeline.live_bytes"),
        (
            "saved_registers = { value = 4",
            "saved_registers = { value = 0",
            "reflections.pipeline.saved_registers",
        ),
    ] {
        assert!(COSTS.contains(from), "the costs have '{from}'");
        let error =
            ShaderCosts::parse(&COSTS.replacen(from, to, 1), "my-costs.toml").unwrap_err().to_string();
        assert!(error.starts_with("my-costs.toml:") && error.contains(expectation), "{error}");
    }
    ShaderCosts::parse(&COSTS.replacen("alu = 63", "alu = 65536", 1), "x")
        .expect("the limit itself is allowed");
}

#[test]
fn passes_of_reflections_have_costs_unless_the_table_is_older() {
    let costs = ShaderCosts::builtin().expect("sound");
    assert!(costs.reflections().is_some());
    // What no compiler counted is called an estimate, and nothing else.
    let estimates: Vec<&str> = costs.reflection_estimates().iter().map(String::as_str).collect();
    let by_hand = |table: &str| -> Vec<String> {
        let lines = COSTS.lines().skip_while(|line| *line != format!("[{table}]")).skip(1);
        let lines = lines.take_while(|line| !line.starts_with('['));
        let by_hand = lines.filter(|line| line.contains("by hand") || line.contains("nothing published"));
        by_hand.filter_map(|line| Some(format!("{table}.{}", line.split_once(" = ")?.0))).collect()
    };
    let mut expected = [by_hand("reflections"), by_hand("reflections.pipeline")].concat();
    expected.sort_unstable();
    assert_eq!(estimates, expected);

    let (before, from) = COSTS.split_once("[reflections]").expect("a table");
    let (_, after) = from.split_once("[ray-query]").expect("the next table");
    let older = ShaderCosts::parse(&format!("{before}[ray-query]{after}"), "older.toml").expect("sound");
    assert!(older.reflections().is_none() && older.reflection_estimates().is_empty());
}

#[test]
fn all_built_in_gpus_have_figures_for_atomics_and_a_description_may_go_without() {
    for gpu in GPUS {
        let atomics =
            Gpu::builtin(gpu.name).expect("listed").expect("sound").atomics.expect("it has figures");
        assert!(atomics.dispatch_seconds < 1e-3, "{}: seconds, not microseconds", gpu.name);
    }
    let (before, from) = adreno_540().split_once("[atomics]").expect("a table");
    let (_, after) = from.split_once("[dram]").expect("the next table");
    let without = Gpu::parse(&format!("{before}[dram]{after}"), "my-gpu.toml").expect("sound");
    assert_eq!(without.atomics, None);
}

#[test]
fn wrong_figures_of_atomics_are_refused() {
    for (from, to, key, expectation) in [
        ("lane_clocks = { value = 1", "lane_clocks = { value = 0", "atomics.lane_clocks", "is 0"),
        ("warp_clocks = { value = 0", "warp_clocks = { value = -1", "atomics.warp_clocks", "is -1"),
        (
            "shared_lane_clocks = { value = 1",
            "shared_lane_clocks = { value = nan",
            "shared_lane_clocks",
            "NaN",
        ),
        ("barrier_clocks = { value = 20", "barrier_clocks = { value = inf", "barrier_clocks", "is inf"),
        ("dispatch_us = { value = 5", "dispatch_us = { value = -5", "atomics.dispatch_us", "is -5"),
        ("joins_uniform = { value = true", "joins_uniform = { value = 1", "boolean", "1"),
    ] {
        let (message, line) = gpu_error(from, to);
        assert!(message.starts_with(&format!("my-gpu.toml:{line}: ")), "line {line}: {message}");
        assert!(message.contains(key) && message.contains(expectation), "{message}");
    }
}

/// The built-in Adreno 660, which has figures for translation, with one part replaced.
fn translating(from: &str, to: &str) -> Result<Gpu, gpumodel::Error> {
    let toml = BuiltinGpu::named("adreno-660").expect("it is built in").toml;
    assert!(toml.contains(from), "{from}");
    Gpu::parse(&toml.replace(from, to), "my-gpu.toml")
}

#[test]
fn pages_that_cannot_be_are_refused_and_the_smallest_and_largest_are_read() {
    for (from, to, key, expectation) in [
        (
            "page_bytes = { value = 65536",
            "page_bytes = { value = 65535",
            "translation.page_bytes",
            "power of two",
        ),
        ("page_bytes = { value = 65536", "page_bytes = { value = 2048", "translation.page_bytes", "4096 to"),
        ("entries = { value = 64", "entries = { value = 0", "translation.entries", "is 0"),
        ("entries = { value = 64", "entries = { value = 4097", "translation.entries", "1 to 4096"),
        ("walk_ns = { value = 31.6", "walk_ns = { value = nan", "translation.walk_ns", "is NaN"),
    ] {
        let message = translating(from, to).expect_err(key).to_string();
        assert!(message.contains(key) && message.contains(expectation), "{message}");
    }
    for bytes in ["4096", "1073741824"] {
        let to = format!("page_bytes = {{ value = {bytes}");
        let gpu = translating("page_bytes = { value = 65536", &to).expect("legal");
        assert_eq!(gpu.translation.expect("it has figures").tlb.page_bytes.to_string(), bytes);
    }
}

#[test]
fn wrong_figures_of_a_ray_unit_are_refused() {
    let text = BuiltinGpu::named("mali-g715").expect("it is built in").toml;
    for (from, to, key, expectation) in [
        (
            "scheduling = { value = \"warp\"",
            "scheduling = { value = \"wave\"",
            "expected one of `warp`, `ray`, `instruction`",
            "unknown variant",
        ),
        (
            "boxes_per_clock = { value = 4",
            "boxes_per_clock = { value = 0",
            "ray_unit.boxes_per_clock",
            "is 0",
        ),
        (
            "triangles_per_clock = { value = 2",
            "triangles_per_clock = { value = nan",
            "ray_unit.triangles_per_clock",
            "is NaN",
        ),
        ("rays_together = { value = 4", "rays_together = { value = 65", "ray_unit.rays_together", "1 to 64"),
        ("return_cycles = { value = 40", "return_cycles = { value = -1", "ray_unit.return_cycles", "is -1"),
        ("path = { value = [\"lsc\", \"l2\"]", "path = { value = [\"l9\"]", "ray_unit.path", "'l9'"),
        ("path = { value = [\"lsc\", \"l2\"]", "path = { value = [\"l2\", \"lsc\"]", "paths", ""),
    ] {
        let (error, at) = error_of(text, from, to);
        assert!(error.contains(key) && error.contains(expectation), "{error}");
        assert!(key == "paths" || error.contains(&format!("my-gpu.toml:{at}")), "{error}");
    }
}

#[test]
fn wrong_energies_are_refused_with_their_key_and_line() {
    let text = EnergyTable::builtin_text();
    for (from, to, key, expectation) in [
        ("alu_operation = { value = 2.3", "alu_operation = { value = -1", "logic.alu_operation", "is -1"),
        ("alu_operation = { value = 2.3", "alu_operation = { value = nan", "logic.alu_operation", "is NaN"),
        (
            "2.3, process = \"45nm\"",
            "2.3, process = \"44nm\"",
            "logic.alu_operation.process",
            "one of: 45nm, 16nm",
        ),
        (
            "2.3, process = \"45nm\", boundary = \"unit\"",
            "2.3, process = \"45nm\", boundary = \"all\"",
            "all",
            "unknown variant",
        ),
        ("word = { value = 10", "wordy = { value = 10", "wordy", "unknown field"),
        ("name = \"14nm\"", "name = \"16nm\"", "process.name", "stands twice"),
        ("standard = \"lpddr5x\"", "standard = \"lpddr5\"", "dram.standard", "stands twice"),
        ("energy = { value = 0.172", "energy = { value = 0", "process.16nm.energy", "is 0"),
        ("volts = { value = 0.9,", "volts = { value = 0,", "process.45nm.volts", "0.1 to 10"),
        (
            "interface_bits = { value = 32",
            "interface_bits = { value = 0",
            "dram.lpddr5.interface_bits",
            "is 0",
        ),
        (
            "floor_mw = { value = 45.7",
            "floor_mw = { value = inf",
            "dram.lpddr5.DRAM devices.floor_mw",
            "is inf",
        ),
        (
            "mw_per_root_gbs = { value = 160.06",
            "mw_per_mbs = { value = 160.06",
            "mw_per_mbs",
            "unknown field",
        ),
        (
            "value = [32499, 20283, -238, 6]",
            "value = [-9e8, 0, 0, 0]",
            "leakage.temperature_scale",
            "positive",
        ),
        (
            "value = [32499, 20283, -238, 6]",
            "value = [32499, 20283, -238, 1e10]",
            "leakage.temperature_scale",
            "has a coefficient of 10000000000",
        ),
        (
            "value = [32499, 20283, -238, 6]",
            "value = [1e6, 0, 0, 0]",
            "leakage.temperature_scale",
            "positive values that grow",
        ),
        ("value = [50, 95]", "value = [50, 50]", "leakage.fit_celsius", "the lower first"),
        ("value = [50, 95]", "value = [50, 151]", "leakage.fit_celsius", "-40 to 150"),
        (
            "reference_celsius = { value = 50",
            "reference_celsius = { value = 151",
            "reference_celsius",
            "-40 to 150",
        ),
        (
            "source = \"nothing measured; a phone at work",
            "source = \"\", tag = \"estimate\" } #",
            "leakage.reference_celsius",
            "empty source",
        ),
    ] {
        let at = text.find(from).unwrap_or_else(|| panic!("the table has '{from}'"));
        let changed = text.replacen(from, to, 1);
        let message = EnergyTable::parse(&changed, "my-energy.toml").expect_err(to).to_string();
        let line = text[..at].matches('\n').count() + 1;
        assert!(message.starts_with("my-energy.toml:") && message.contains(key), "{message}");
        assert!(message.contains(expectation), "{message}");
        // A supply is named at its own line, and what is a whole table at its first.
        assert!(message.starts_with(&format!("my-energy.toml:{line}: ")), "line {line}: {message}");
    }
    let line = "mw_per_root_gbs = { value = 160.06";
    let at = text.find(line).expect("it is there");
    let end = at + text[at..].find('\n').expect("it ends");
    let without = format!("{}{}", &text[..at], &text[end..]);
    let message = EnergyTable::parse(&without, "my-energy.toml").expect_err("no law").to_string();
    assert!(message.contains("expected one of mw_per_gbs and mw_per_root_gbs"), "{message}");
    let both = text.replacen(
        line,
        "mw_per_gbs = { value = 1, source = \"x\", tag = \"vendor\" }\nmw_per_root_gbs = { value = 160.06",
        1,
    );
    assert!(EnergyTable::parse(&both, "my-energy.toml").is_err());
}

#[test]
fn a_process_needs_its_source_and_a_description_may_go_without_energy() {
    let (error, _) = gpu_error("source = \"MSM8998 in cpufetch: src/arm/soc.c\"", "source = \" \"");
    assert!(error.contains("energy.process") && error.contains("empty source"), "{error}");
    let (before, _) = adreno_540().split_once("[energy]").expect("the last table");
    assert_eq!(Gpu::parse(before, "my-gpu.toml").expect("sound").energy, None);
}
