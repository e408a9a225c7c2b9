//! Which DRAM descriptions are refused, and is the message one that helps?

use cachesim::{DRAM_STANDARDS, Dram, DramConfig, DramStandard, RowTally};

fn refusal(standard: &str, replace: &str, with: &str) -> String {
    let text = DRAM_STANDARDS.iter().find(|builtin| builtin.name == standard).unwrap().toml;
    assert!(text.contains(replace), "'{replace}' is not in {standard}");
    let changed = text.replacen(replace, with, 1);
    DramStandard::parse(&changed, "my.toml").expect_err("expected a refusal").to_string()
}

#[test]
fn every_built_in_standard_is_accepted_and_says_where_its_figures_come_from() {
    for builtin in DRAM_STANDARDS {
        let standard = DramStandard::builtin(builtin.name).unwrap();
        assert_eq!(standard.name, builtin.name);
        assert_eq!(standard.burst_bytes(), 32);
        assert_eq!(standard.row_bytes(), 2048);
        for line in builtin.toml.lines().filter(|line| line.contains("tag = \"standard\"")) {
            assert!(line.contains("source = \"JESD209-") || line.starts_with("tag"), "{line}");
        }
        let estimate = |key: &str| standard.estimates.iter().any(|estimate| estimate == key);
        assert!(estimate("controller.channel_bytes") && !estimate("timing.trcd"), "{:?}", standard.estimates);
    }
    assert!(DramStandard::builtin("lpddr5x").unwrap().estimates.contains(&"speed.9600".to_owned()));
}

#[test]
fn an_unknown_standard_is_answered_with_the_known_ones() {
    let error = DramStandard::builtin("ddr9").unwrap_err().to_string();
    assert_eq!(
        error,
        "DRAM 'ddr9': no such standard, expected lpddr4x, lpddr5, lpddr5x; name one of them, or give a file"
    );
}

#[test]
fn contradictions_are_refused_with_file_line_key_and_remedy() {
    for (replace, with, expected) in [
        (
            "trc = { ns = 60",
            "trc = { ns = 59.9",
            "timing.trc: is 59.9 ns, less than tras + trp_pb = 60 ns; raise trc",
        ),
        ("tras = { ns = 42", "tras = { ns = 17", "timing.tras: is 17 ns, less than trcd = 18 ns; raise tras"),
        ("tfaw = { ns = 40", "tfaw = { ns = 9", "timing.tfaw: is 9 ns, less than trrd = 10 ns; raise tfaw"),
        (
            "trefi = { ns = 3904",
            "trefi = { ns = 2240",
            "timing.trefi: is 2240 ns, not more than trp_pb + trfc_pb + trcd and twice 8 x tpbr2pbr = 2240 ns",
        ),
        ("trcd = { ns = 18", "trcd = { ns = nan", "timing.trcd.ns: is NaN, expected 0 to 1000000; correct"),
        ("trcd = { ns = 18", "trcd = { ns = inf", "timing.trcd.ns: is inf, expected 0 to 1000000; correct"),
        (
            "trcd = { ns = 18, clocks = 4",
            "trcd = { ns = 18, clocks = -1",
            "timing.trcd.clocks: is -1, expected 0 to 10000",
        ),
        (
            "width_bits = { value = 16",
            "width_bits = { value = 12",
            "organisation.width_bits: is 12, expected whole bytes; give a multiple of 8",
        ),
        (
            "burst_length = { value = 16",
            "burst_length = { value = 15",
            "organisation.burst_length: is 15, which is no whole number of clocks of 2",
        ),
        (
            "bank_groups = { value = 1",
            "bank_groups = { value = 3",
            "organisation.banks: is 8, expected a multiple of the 3 bank groups",
        ),
        ("banks = { value = 8", "banks = { value = 65", "organisation.banks: is 65, expected 1 to 64"),
        (
            "refresh_banks = { value = 1",
            "refresh_banks = { value = 3",
            "organisation.refresh_banks: is 3, expected 1 to 2",
        ),
        (
            "refresh_postponed = { value = 8",
            "refresh_postponed = { value = 9",
            "controller.refresh_postponed: is 9, expected 0 to 8",
        ),
        (
            "row_bytes = { value = 2048",
            "row_bytes = { value = 2050",
            "organisation.row_bytes: is 2050, expected a multiple of a burst's 32",
        ),
        (
            "channel_bytes = { value = 256",
            "channel_bytes = { value = 48",
            "controller.channel_bytes: is 48, expected a multiple of a burst's 32",
        ),
        (
            "group_bytes = { value = 2048",
            "group_bytes = { value = 96",
            "controller.group_bytes: is 96, which does not divide a row of 2048",
        ),
        (
            "write_low = { value = 0.5",
            "write_low = { value = 0.9",
            "controller.write_low: is 0.9, not less than write_high = 0.85; lower",
        ),
        ("mbps = 1066", "mbps = 533", "speed 2.mbps: is 533, not more than the 533 before it; sort"),
        ("read_latency = 6", "read_latency = 0", "speed 1.read_latency: is 0, expected 1 to 10000"),
        ("name = \"lpddr4x\"", "name = \" \"", "name: is empty; name the standard"),
    ] {
        let error = refusal("lpddr4x", replace, with);
        let line = error.strip_prefix("my.toml:").and_then(|rest| rest.split(": ").next());
        assert!(line.is_some_and(|line| line.parse::<u32>().is_ok()), "{error}");
        assert!(error.contains(expected), "{error}, expected {expected}");
    }
}

#[test]
fn unknown_keys_missing_keys_and_empty_sources_are_refused() {
    let error = refusal("lpddr5", "[timing]", "[timing]\ntrfc2 = 1");
    assert!(error.starts_with("my.toml:") && error.contains("unknown field `trfc2`"), "{error}");
    let error = refusal("lpddr5", "twr = {", "twr_ = {");
    assert!(error.contains("unknown field `twr_`"), "{error}");
    let text = DRAM_STANDARDS[1].toml;
    let without: String =
        text.lines().filter(|line| !line.starts_with("tfaw")).map(|line| format!("{line}\n")).collect();
    let error = DramStandard::parse(&without, "my.toml").unwrap_err().to_string();
    assert!(error.contains("missing field `tfaw`"), "{error}");
    let error = refusal("lpddr5", "tag = \"standard\"", "tag = \"rumour\"");
    assert!(error.contains("unknown variant `rumour`"), "{error}");
    let error = refusal("lpddr5", "source = \"JESD209-5B, addressing", "source = \"\", text = \"");
    assert!(error.contains("unknown field `text`"), "{error}");
    let start = text.find("write_low = { value = 0.5, source = \"").unwrap();
    let end = start + text[start..].find("\", tag").unwrap();
    let emptied = format!("{}write_low = {{ value = 0.5, source = \"  {}", &text[..start], &text[end..]);
    let error = DramStandard::parse(&emptied, "my.toml").unwrap_err().to_string();
    assert!(error.contains("controller.write_low: has an empty source; say where"), "{error}");
}

#[test]
fn a_memory_out_of_range_is_refused_and_the_limits_are_accepted() {
    let standard = DramStandard::builtin("lpddr5").unwrap();
    let good = DramConfig { standard, channels: 4, bytes_per_second: 51.2e9, queue: 32 };
    let refused = |config: &DramConfig, key: &str| {
        let error = Dram::new(config).unwrap_err().to_string();
        assert!(error.starts_with(&format!("DRAM of lpddr5: {key}: is ")), "{error}");
        assert_eq!(RowTally::new(config).unwrap_err().to_string(), error);
    };
    for channels in [0, 65, u32::MAX] {
        refused(&DramConfig { channels, ..good.clone() }, "channels");
    }
    for bytes_per_second in [0.0, -1.0, 0.999, 1.01e16, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        refused(&DramConfig { bytes_per_second, ..good.clone() }, "bytes_per_second");
    }
    for queue in [0, 4097] {
        refused(&DramConfig { queue, ..good.clone() }, "queue");
    }
    for (channels, bytes_per_second, queue) in [(1, 1.0, 1), (64, 1e16, 4096), (1, 1e16, 1), (64, 1.0, 4096)]
    {
        let config = DramConfig { channels, bytes_per_second, queue, ..good.clone() };
        assert!(Dram::new(&config).is_ok() && RowTally::new(&config).is_ok());
    }
}

#[test]
fn the_latency_entry_is_the_smallest_that_reaches_the_data_rate() {
    let standard = DramStandard::builtin("lpddr4x").unwrap();
    // In clocks of the data rate; by the table 32 up to 3733 and 36 up to 4267.
    for (mbps, clocks) in
        [(533.0, 6.0), (540.0, 10.0), (3725.0, 32.0), (3733.3, 32.0), (3760.0, 36.0), (4267.5, 36.0)]
    {
        let config =
            DramConfig { standard: standard.clone(), channels: 4, bytes_per_second: mbps * 8e6, queue: 32 };
        let expected = clocks * 2e6 / mbps;
        let latency = config.timings().unwrap().read_latency as f64;
        assert!(
            (latency - expected).abs() < 1.0 + expected * 0.001,
            "{mbps}: {latency}, expected {expected}"
        );
    }
    // Beyond the fastest the nanoseconds stay: 36 clocks of 4267.
    let config = DramConfig { standard, channels: 1, bytes_per_second: 1e15, queue: 32 };
    assert_eq!(config.timings().unwrap().read_latency, 16_874);
}
