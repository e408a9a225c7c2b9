//! Do streams of known rates give back what was measured of memory's supplies, and are contradictory rows refused?

use gpumodel::{Fidelity, Gpu};
use reports::hardware::{Apart, Found, Kind, MEASUREMENTS, Row, Summary, parse, set_interface_rate};

fn rows() -> Vec<Row> {
    let rows = parse(MEASUREMENTS, "measurements.toml").expect("sound");
    rows.into_iter().filter(|row| row.kind == Kind::Power).collect()
}

fn found(row: &Row) -> f64 {
    let mut gpu = Gpu::builtin(&row.gpu).expect("built in").expect("sound");
    let gbs = row.interface_gbs.expect("a row of power");
    set_interface_rate(&mut gpu, gbs).expect("its energy is known");
    let observed = row.pattern.observe(&gpu, Fidelity::Replay).expect("a stream");
    match row.found(&[observed]) {
        Found::Value(value) => value,
        other => panic!("{other:?}"),
    }
}

#[test]
fn streams_at_a_ladder_of_rates_give_back_the_laws_of_the_supplies() {
    println!("{:<22}{:>10}{:>10}{:>10}", "row", "expected", "got", "off");
    let rows = rows();
    for row in &rows {
        let gbs: f64 = row.interface_gbs.expect("a row of power");
        // Of one x32 interface in mW, and in pJ/B beyond the floors.
        let expected = match (row.gpu.as_str(), row.rail.as_deref()) {
            ("adreno-650", Some("DRAM devices")) => 45.7 + 160.06 * gbs.sqrt(),
            ("adreno-650", Some("DRAM interface")) => 118.9 + 144.4 * gbs.sqrt(),
            ("adreno-650", None) => (160.06 + 144.4) / gbs.sqrt(),
            ("adreno-540", None) => 90.0,
            other => panic!("no law is known for {other:?}"),
        };
        let got = found(row);
        let off = got / expected - 1.0;
        println!("{:<22}{expected:>10.2}{got:>10.2}{:>9.3} %", row.id, 100.0 * off);
        // The stream is a little slower than the memory at its peak.
        assert!(off.abs() < 0.005, "{}: {got}, expected {expected}", row.id);
    }
    assert_eq!(rows.len(), 13);
}

#[test]
fn rows_of_power_keep_their_limit() {
    for row in rows() {
        let verdict = row.judge(Found::Value(found(&row)), &[]);
        assert!(verdict.outcome, "{}: {:?}", row.id, verdict.error);
    }
}

#[test]
fn formulas_and_ranges_are_in_no_mean_of_errors() {
    let rows = rows();
    let of = |apart: Option<Apart>| rows.iter().filter(move |row| row.apart == apart);
    assert_eq!(of(Some(Apart::Formula)).count(), 4);
    assert!(of(Some(Apart::Range)).all(|row| row.id.ends_with("-rule")));
    // One of each is far off, and still only measurements count.
    let off = |row: &Row| row.judge(Found::Value(3.0 * found(row)), &[]);
    let formula_or_range: Vec<_> = rows.iter().filter(|row| row.apart.is_some()).map(off).collect();
    assert_eq!(Summary::new(&formula_or_range).groups, []);
    let all: Vec<_> = rows.iter().map(|row| row.judge(Found::Value(found(row)), &[])).collect();
    let summary = Summary::new(&all);
    assert_eq!((summary.groups[0].rows, summary.groups[0].count, summary.count), ("all rows", 7, 13));
}

#[test]
fn rows_of_power_that_contradict_themselves_are_refused() {
    let good = "[[row]]\nid = \"p\"\ngpu = \"adreno-650\"\nstatement = \"s\"\nkind = \"power\"\nquantity = \"rail_mw\"\n\
        pattern = { stream = { route = \"buffer\", footprint = 16777216, element = 16 } }\ninterface_gbs = 1\n\
        rail = \"DRAM devices\"\npublished = 1\nsource = \"s\"\n";
    parse(good, "m.toml").expect("sound");
    for (from, to, expected) in [
        ("kind = \"power\"", "kind = \"bandwidth\"", "kind power goes with"),
        ("quantity = \"rail_mw\"", "quantity = \"gbs\"", "kind power goes with"),
        ("quantity = \"rail_mw\"", "quantity = \"pj_per_byte\"", "kind power goes with"),
        ("interface_gbs = 1\n", "", "kind power goes with"),
        ("rail = \"DRAM devices\"\n", "", "kind power goes with"),
        ("rail = \"DRAM devices\"", "rail = \"DRAM\"", "name one of: DRAM devices, DRAM interface"),
        ("interface_gbs = 1", "interface_gbs = 0", "interface_gbs is no rate"),
        ("interface_gbs = 1", "interface_gbs = inf", "interface_gbs is no rate"),
    ] {
        assert!(good.contains(from), "{from}");
        let error = parse(&good.replace(from, to), "m.toml").expect_err(to).to_string();
        assert!(error.contains("m.toml: row 'p'") && error.contains(expected), "{error}");
    }
}
