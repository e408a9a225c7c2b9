//! Does a description of levels mean what it says, and does a wrong one get a clear answer?

use cachesim::{Bytes, Levels, Policy, Ways, WriteMiss, WritePolicy};

const GOOD: &str = "
[[level]]
name = \"L1\"
size = 16384
line = 64
ways = 4
policy = \"lru\"
count = 4

[[level]]
name = \"L2\"
size = 1048576
line = 128
ways = \"full\"
policy = \"lru\"
sector = 32
write = \"through\"
write_miss = \"around\"
";

fn refusal(text: &str) -> String {
    Levels::parse(text, "l.toml").expect_err("must be refused").to_string()
}

#[test]
fn every_key_arrives() {
    let levels = Levels::parse(GOOD, "l.toml").expect("a good description");
    let [l1, l2] = levels.as_slice() else { panic!("two levels") };
    assert_eq!((l1.name.as_str(), l1.size, l1.line.bytes()), ("L1", Bytes(16384), 64));
    assert_eq!((l1.ways, l1.policy, l1.count, l1.sector), (Ways::Count(4), Policy::Lru, 4, None));
    assert_eq!((l1.write, l1.write_miss), (WritePolicy::Back, WriteMiss::Fetch));
    assert_eq!((l2.ways, l2.granule().bytes()), (Ways::Full, 32));
    assert_eq!((l2.write, l2.write_miss), (WritePolicy::Through, WriteMiss::Around));
    assert_eq!(levels.units(), 4);
}

#[test]
fn a_wrong_description_is_refused_with_file_line_level_and_remedy() {
    for (from, to, expected) in [
        ("size = 16384", "sise = 16384", "l.toml:4: [[level]] 1: unknown field `sise`, expected one of"),
        ("line = 64\n", "", "l.toml:2: [[level]] 1: missing field `line`"),
        ("line = 64", "line = 48", "line is 48 bytes, expected a power of two from 8 to 4096"),
        ("line = 64", "line = 0", "line is 0 bytes"),
        ("line = 64", "line = -64", "l.toml:5: [[level]] 1"),
        ("size = 16384", "size = 0", "l.toml:2: [[level]] 1 (L1): size is 0 bytes"),
        ("ways = 4", "ways = 0", "ways is 0, expected 1 to 1024 or \"full\""),
        (
            "ways = 4",
            "ways = 3",
            "85.333 sets of 3 ways of 64 bytes, expected a whole number; make size a multiple of 192",
        ),
        ("ways = 4", "ways = \"all\"", "ways must be a number from 1 or \"full\""),
        ("count = 4", "count = 0", "count is 0"),
        (
            "size = 1048576",
            "size = 1099511627776",
            "l.toml:10: [[level]] 2 (L2): 1 x 1099511627776 bytes hold more than",
        ),
        (
            "size = 16384",
            "size = 18446744073709551615",
            "(L1): 4 x 18446744073709551615 bytes hold more than",
        ),
        ("name = \"L2\"", "name = \"L1\"", "l.toml:10: [[level]] 2 (L1): another level has the same name"),
        ("sector = 32", "sector = 256", "sector is 256 bytes in a line of 128"),
        ("sector = 32", "seed = 3", "seed has no meaning here"),
        ("policy = \"lru\"\ncount", "policy = \"plru\"\nseed = 1\ncount", "seed has no meaning here"),
        ("\"around\"", "\"araund\"", "l.toml:18: [[level]] 2: unknown variant `araund`, expected one of"),
        ("ways = 4", "ways = ", "l.toml:6"),
    ] {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "{from} is in the text");
        let refusal = refusal(&text);
        assert!(refusal.contains(expected), "{to}: got '{refusal}', expected '{expected}'");
        assert!(refusal.starts_with("l.toml:"), "{refusal}");
    }
}

#[test]
fn three_ways_in_64_sets_of_0_bytes_are_refused() {
    let text = GOOD.replacen("size = 16384", "size = 0", 1).replacen("ways = 4", "ways = 3", 1);
    assert!(
        refusal(&text).contains("size is 0 bytes, expected a cache that holds at least one line; raise size")
    );
}

#[test]
fn an_empty_description_is_refused() {
    assert!(refusal("").contains("missing field `level`"));
    assert!(refusal("level = []").contains("0 levels, expected 1 to 8"));
}

#[test]
fn the_number_of_lines_is_limited_tightly() {
    let text = |lines: u64| {
        format!("[[level]]\nname=\"a\"\nsize={}\nline=64\nways=\"full\"\npolicy=\"lru\"\n", lines * 64)
    };
    assert!(Levels::parse(&text(cachesim::MAX_LINES), "l.toml").is_ok());
    assert!(Levels::parse(&text(cachesim::MAX_LINES + 1), "l.toml").is_err());
}

#[test]
fn tree_plru_wants_a_power_of_two_ways() {
    let text = |ways: u32| {
        format!("[[level]]\nname=\"a\"\nsize={}\nline=64\nways={ways}\npolicy=\"plru\"\n", ways * 64 * 8)
    };
    for good in [1, 2, 16, 64] {
        assert!(Levels::parse(&text(good), "l.toml").is_ok(), "{good} ways");
    }
    for bad in [3, 12, 128] {
        assert!(refusal(&text(bad)).contains("use policy = \"lru\""), "{bad} ways");
    }
}
