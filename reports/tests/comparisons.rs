//! Do all forms of a comparison say the same, keep every figure and every reason, and stay legible?

mod common;

use common::{counter, report};
use reports::chart::{BarChart, Scale};
use reports::comparison::{Comparison, Variant, csv_table, json, markdown, text};
use reports::text::Style;
use reports::{Report, Value};
use serde_json::{Value as Json, json};

/// The report of [`report`] with these figures.
fn with(frame_time: f64, fetches: u64, read: u64) -> Report {
    let more = [
        ("frame_time_ms", counter(Value::Real(frame_time), "ms")),
        ("fps", counter(Value::Real(1e3 / frame_time), "1/s")),
        ("node_fetches", counter(Value::Count(fetches), "fetches")),
        ("sp_memory_read_bytes", counter(Value::Count(read), "B")),
        ("dram_read_bytes", counter(Value::Absent { reason: "no memory | none".into() }, "B")),
    ];
    let counters = more.into_iter().map(|(id, counter)| (id.to_owned(), counter)).collect();
    let mut report = Report { counters, ..report() };
    report.inputs.height = Some(32);
    report
}

fn variant(values: &[&str], report: Report) -> Variant {
    let values = values.iter().map(|&value| value.to_owned()).collect();
    Variant { values, report, ratios_ci95: Default::default() }
}

/// Two scenes, two traversals, one layout.
fn comparison() -> Comparison {
    Comparison {
        title: "Traversals | on <adreno-540>".into(),
        axes: ["scene", "traversal", "layout"].map(str::to_owned).to_vec(),
        variants: vec![
            variant(&["cornell", "stack", "padded"], with(10.0, 2048, 3 << 20)),
            variant(&["cornell", "restart, trail", "padded"], with(8.0, 4096, 6 << 20)),
            variant(&["crytek_sponza", "stack", "padded"], with(15.3, 8192, 1 << 19)),
            variant(&["crytek_sponza", "restart, trail", "padded"], with(31.0, 2048, 0)),
        ],
        remarks: vec![],
    }
}

/// As it stands in the CSV.
fn records(comparison: &Comparison) -> Vec<Vec<String>> {
    let table = csv_table::write(comparison);
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let cells = |record: csv::StringRecord| record.iter().map(str::to_owned).collect();
    reader.records().map(|record| cells(record.expect("a record"))).collect()
}

#[test]
fn the_text_aligns_figures_in_one_unit_with_their_differences() {
    let text = text::write(&comparison(), Style::Plain);
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows[0], "Traversals | on <adreno-540>");
    assert!(rows[2].starts_with("scene          traversal       layout   Frame Time"), "{text}");
    let cells = |row: &str| row.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
    assert_eq!(cells(rows[3]), "ms 1/s MiB B");
    assert_eq!(cells(rows[4]), "cornell stack padded 10.00 100.0 3.000 -");
    assert_eq!(cells(rows[5]), "cornell restart, trail padded 8.000 -20 % 125.0 +25 % 6.000 x2 -");
    assert_eq!(cells(rows[6]), "crytek_sponza stack padded 15.30 +53 % 65.36 -35 % 0.5000 x0.167 -");
    assert_eq!(cells(rows[7]), "crytek_sponza restart, trail padded 31.00 x3.1 32.26 x0.323 0 x0 -");
    let ends: Vec<usize> = ["10.00", "8.000", "15.30", "31.00"]
        .into_iter()
        .zip(&rows[4..])
        .map(|(figure, row)| row.find(figure).expect("a figure") + figure.len())
        .collect();
    assert!(ends.windows(2).all(|pair| pair[0] == pair[1]), "{text}");
}

#[test]
fn the_text_wraps_columns_at_100_characters_and_says_why_figures_are_absent() {
    let text = text::write(&comparison(), Style::Plain);
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    assert_eq!(text.lines().filter(|line| line.starts_with("scene ")).count(), 2, "{text}");
    assert!(text.contains("DRAM Read") && text.contains("ALU issue"), "{text}");
    assert!(text.contains("  - DRAM Read: no memory | none"), "{text}");
    let mut comparison = comparison();
    comparison.variants[1].report.counters = with(1.0, 1, 1)
        .counters
        .iter()
        .filter(|(id, _)| *id != "dram_read_bytes")
        .map(|(id, counter)| (id.to_owned(), counter.clone()))
        .collect();
    let text = text::write(&comparison, Style::Plain);
    let reason =
        "DRAM Read of cornell stack padded, crytek_sponza stack padded, crytek_sponza restart, trail padded:";
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains(reason), "{text}");
}

#[test]
fn bold_text_is_the_same_otherwise() {
    let plain = text::write(&comparison(), Style::Plain);
    let bold = text::write(&comparison(), Style::Ansi);
    assert!(!plain.contains('\x1b') && bold.contains('\x1b'));
    assert_eq!(bold.replace("\x1b[1m", "").replace("\x1b[0m", ""), plain);
}

#[test]
fn the_csv_has_a_row_for_each_variant_and_counter_and_keeps_every_digit() {
    let mut comparison = comparison();
    comparison.variants[0].report = with(10.0, 9_007_199_254_740_993, 3);
    let heading = csv_table::write(&comparison).lines().next().map(str::to_owned);
    assert_eq!(
        heading.as_deref(),
        Some("scene,traversal,layout,id,unit,value,relative,absent,relative_low,relative_high")
    );
    let records = records(&comparison);
    assert_eq!(records.len(), 4 * 5);
    let fetches =
        ["cornell", "stack", "padded", "node_fetches", "fetches", "9007199254740993", "1", "", "", ""];
    assert_eq!(records[2], fetches);
    let time = ["crytek_sponza", "stack", "padded", "frame_time_ms", "ms", "15.3", "1.53", "", "", ""];
    assert_eq!(records[10], time);
    let absent =
        ["cornell", "restart, trail", "padded", "dram_read_bytes", "B", "", "", "no memory | none", "", ""];
    assert_eq!(records[9], absent);
}

#[test]
fn the_markdown_has_as_many_cells_in_each_row_whatever_the_text() {
    let markdown = markdown::write(&comparison());
    let rows: Vec<&str> = markdown.lines().filter(|line| line.starts_with('|')).collect();
    let cells = |row: &&str| row.replace("\\|", "").matches('|').count();
    assert_eq!(rows.len(), 2 + 4, "{markdown}");
    assert!(rows.iter().all(|row| cells(row) == cells(&rows[0])), "{markdown}");
    assert!(markdown.starts_with("## Traversals \\| on &lt;adreno-540>\n\n| scene | "), "{markdown}");
    assert!(rows[3].contains("| 8.000 (-20 %) | 125.0 (+25 %) | 6.000 (x2) |"), "{markdown}");
    assert!(markdown.contains("\n- DRAM Read: no memory \\| none\n"), "{markdown}");
}

/// Validates against the schema of comparisons, which refers to that of reports.
fn validates(comparison: &Json) -> bool {
    let schema = |text: &str| serde_json::from_str::<Json>(text).expect("the schema is JSON");
    let mut whole = schema(json::SCHEMA_TEXT);
    let report = &mut whole["properties"]["variants"]["items"]["properties"]["report"];
    assert_eq!(*report, json!({"$ref": "report-1.schema.json"}));
    // Embedded with an identifier of its own, so that its references stay within it.
    let mut embedded = schema(reports::json::SCHEMA_TEXT);
    embedded["$id"] = json!("urn:raybudget:report-1");
    *report = embedded;
    jsonschema::validator_for(&whole).expect("the schema is a JSON Schema").is_valid(comparison)
}

#[test]
fn a_comparison_keeps_to_the_published_schema_and_holds_its_reports_whole() {
    let comparison = comparison();
    let good: Json = serde_json::from_str(&json::write(&comparison)).expect("a comparison is JSON");
    assert!(validates(&good));
    assert_eq!(good["variants"][1]["values"], json!(["cornell", "restart, trail", "padded"]));
    let text = good["variants"][1]["report"].to_string();
    assert_eq!(reports::json::read(&text, "nested"), Ok(comparison.variants[1].report.clone()));
    let empty = Comparison { variants: vec![], ..comparison };
    assert!(validates(&serde_json::from_str(&json::write(&empty)).expect("JSON")));

    type Break = fn(&mut Json);
    let breaks: [(&str, Break); 5] = [
        ("another schema", |json| json["schema"] = json!(2)),
        ("a missing title", |json| drop(json.as_object_mut().expect("an object").remove("title"))),
        ("a value that is no text", |json| json["variants"][0]["values"][0] = json!(1)),
        ("a report that is none", |json| json["variants"][0]["report"] = json!({})),
        ("a wrong counter", |json| {
            json["variants"][0]["report"]["counters"]["fps"]["value"] = Json::Null;
        }),
    ];
    for (what, break_it) in breaks {
        let mut bad = good.clone();
        break_it(&mut bad);
        assert!(!validates(&bad), "{what} passed");
    }
}

fn chart(comparison: &Comparison, stem: &str) -> Option<BarChart> {
    comparison.charts().into_iter().find_map(|(name, chart)| (name == stem).then_some(chart))
}

#[test]
fn the_last_axis_that_varies_becomes_the_series_and_the_others_the_groups() {
    let chart = chart(&comparison(), "frame-time").expect("a chart");
    assert_eq!(chart.groups, ["cornell", "crytek_sponza"]);
    assert_eq!(chart.series[0].name, "stack");
    assert_eq!(chart.series[1].name, "restart, trail");
    assert_eq!(chart.series[1].values, [Some(8.0), Some(31.0)]);
    assert_eq!(chart.value_label, "Frame time (ms)");
    assert!(chart.subtitle.ends_with("; padded"), "{}", chart.subtitle);
}

#[test]
fn only_counters_with_figures_get_charts_and_all_of_them_can_be_drawn() {
    let charts = comparison().charts();
    let stems: Vec<&str> = charts.iter().map(|(stem, _)| stem.as_str()).collect();
    assert_eq!(stems, ["frames-per-second", "frame-time", "node-fetches-per-pixel", "sp-memory-read"]);
    for (stem, chart) in charts {
        assert!(chart.svg().is_ok() && chart.png().is_ok(), "{stem}");
    }
}

#[test]
fn figures_of_charts_are_scaled_and_those_per_pixel_divided() {
    let comparison = comparison();
    let read = chart(&comparison, "sp-memory-read").expect("a chart");
    assert_eq!(read.value_label, "SP memory read (MiB)");
    assert_eq!(read.series[0].values, [Some(3.0), Some(0.5)]);
    let fetches = chart(&comparison, "node-fetches-per-pixel").expect("a chart");
    assert_eq!(fetches.series[1].values, [Some(2.0), Some(1.0)]);
}

#[test]
fn wide_figures_take_a_logarithmic_scale_but_not_with_a_0() {
    let scale = |reads: [u64; 2]| {
        let variants = reads.map(|read| variant(&["a", &read.to_string()], with(1.0, 1, read))).to_vec();
        let comparison = Comparison {
            title: String::new(),
            axes: vec!["a".into(), "b".into()],
            variants,
            remarks: vec![],
        };
        chart(&comparison, "sp-memory-read").expect("a chart").scale
    };
    assert_eq!(scale([10, 1000]), Scale::Log);
    assert_eq!(scale([10, 999]), Scale::Linear);
    assert_eq!(scale([0, 999]), Scale::Linear);
}

#[test]
fn an_axis_with_too_many_values_for_a_legend_becomes_groups() {
    let variants = (0..34).map(|index| {
        let (ct, gpu) = ((index / 2).to_string(), (index % 2).to_string());
        variant(&[&gpu, &ct], with(1.0 + f64::from(index), 1, 1))
    });
    let axes = vec!["gpu".into(), "ct".into()];
    let comparison = Comparison { title: "many".into(), axes, variants: variants.collect(), remarks: vec![] };
    let chart = chart(&comparison, "frame-time").expect("a chart");
    assert_eq!((chart.groups.len(), chart.series.len()), (17, 2));
    assert!(chart.svg().is_ok());
}

#[test]
fn a_variant_that_is_missing_is_a_gap_and_one_variant_alone_is_a_bar() {
    let mut comparison = comparison();
    comparison.variants.remove(1);
    let frame_time = chart(&comparison, "frame-time").expect("a chart");
    assert_eq!(frame_time.series[1].values, [None, Some(31.0)]);
    comparison.variants.truncate(1);
    let frame_time = chart(&comparison, "frame-time").expect("a chart");
    assert_eq!((frame_time.groups.len(), frame_time.series.len()), (1, 1));
    assert!(frame_time.svg().is_ok());
    comparison.variants.clear();
    assert!(comparison.charts().is_empty());
    assert_eq!(text::write(&comparison, Style::Plain).lines().next(), Some("Traversals | on <adreno-540>"));
}
