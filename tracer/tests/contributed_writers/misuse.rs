//! What does not fit is refused by both writers, in the same words, and leaves no file.

use crate::listing::small;
use crate::programs::{Program, Programs};
use crate::read;

/// Misuse, as a change of a small sound listing, and what both writers say.
const MISUSES: [(&str, &str, &str); 34] = [
    // Rays and steps.
    ("0 1 -1 1 3 0", "0 1 -1 1 8 0", "a step of kind 8, below 8 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 3 2", "a Node step with id 2, below 2 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 2 3", "a Up step with id 3, below 3 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 4 4", "a Push step with id 4, below 4 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 6 2", "a Primitive step with id 2, below 2 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 7 2", "a AnyHit step with id 2, below 2 expected"),
    ("0 1 -1 1 3 0", "0 1 -1 1 5 0", "a Instance step with id 0, below 0 expected"),
    ("0 1 -1 1 3 0", "0 1 2 1 3 0", "a hit of triangle 2 of 2"),
    ("0 1 -1 1 3 0", "0 2 -1 1 3 0", "ray 2 of a tile of 2"),
    ("0 1 -1 1 3 0", "2 1 -1 1 3 0", "ray set 2 of 2"),
    ("0 1 -1 1 3 0", "0 0 -1 1 3 0", "ray 0 of set 0 of tile 0 comes twice"),
    ("0 3\n0 1 -1 1 3 0\n", "0 2\n", "ray 1 of set 0 of tile 0 is missing"),
    ("0 3\n", "0 2\n", "ray 0 of set 1 of tile 0 is missing"),
    // Tiles.
    ("\n1\n0 3", "\n1\n1 3", "tile 1 of 1"),
    ("\n1\n0 3", "\n0\n0 3", "1 tiles of 1 are missing"),
    (
        "\n1\n0 3\n0 1 -1 1 3 0\n0 0 1 3 3 0 3 1 6 1\n1 0 -1 1 3 0\n",
        "\n2\n0 3\n0 1 -1 1 3 0\n0 0 1 3 3 0 3 1 6 1\n1 0 -1 1 3 0\n0 3\n0 1 -1 1 3 0\n0 0 1 3 3 0 3 1 6 1\n1 0 -1 1 3 0\n",
        "tile 0 is written where tile 1 is expected",
    ),
    // The header.
    ("0 2 1 0\n", "0 0 1 0\n", "an image of 1 to 32768 pixels per edge or a list of 1 to 2^30 rays expected"),
    ("0 2 1 0\n", "0 2 1 1\n", "an image of 1 to 32768 pixels per edge or a list of 1 to 2^30 rays expected"),
    (
        "0 2 1 0\n",
        "0 2 32769 0\n",
        "an image of 1 to 32768 pixels per edge or a list of 1 to 2^30 rays expected",
    ),
    ("2 primary 0 0 shadow 0 0", "0", "0 ray sets, 1 to 1024 expected"),
    ("shadow 0 0", "shade 0 0", "ray set \"shade\" is not known"),
    (
        "shadow 0 0",
        "diffuse-shadow 0 0",
        "ray set 1 (diffuse-shadow) without the set before it from whose hits it starts",
    ),
    ("bvh stack - pair", "bhv stack - pair", "accel \"bhv\" is not known"),
    (
        "bvh stack - pair",
        "bvh stack full-4 pair",
        "node_format belongs to wide-bvh, perhaps to two-level, and to no other",
    ),
    ("bvh stack - pair", "bvh dda - pair", "bvh has no traversal \"dda\""),
    ("bvh stack - pair", "two-level short-stack - pair", "a short-stack without a node_format"),
    ("3 1.5 1 0 0", "nan 1.5 1 0 0", "sah_costs are not finite"),
    ("3 1.5 1 0 0", "3 -inf 1 0 0", "sah_costs are not finite"),
    ("while-while\n4 0 0", "while-while\n4 0 16", "trail_bits of 16, 0, 32 or 64 expected"),
    ("while-while\n4 0 0", "while-while\n65537 0 0", "stacks of 0 to 65536 entries expected"),
    // The tree.
    ("0 1 2 0\n", "0 0 2 0\n", "node 0 leads to 2 from 0: children lie behind it, and nothing leads outside"),
    ("1 1 1 0\n", "1 1 2 0\n", "node 2 leads to 2 from 1: children lie behind it, and nothing leads outside"),
    ("1 1 1 0\n", "2 0 0 1\n", "node 2 is of a kind that this structure does not have"),
    ("2 0 1\n", "2 0 2\n", "reference 1 is to 2 of 2"),
];

#[test]
fn misuse_is_refused_by_both_writers_in_the_same_words_and_leaves_no_file() {
    let programs = Programs::new("rewrite");
    let sound = small();
    for program in &programs.all {
        let path = programs.folder.path().join(format!("small-{}.rbt", program.name));
        program.run(&[path.as_ref()], &sound).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(read(&path).steps(), 5);
        std::fs::remove_file(&path).expect("it is there");
        for (part, change, expected) in MISUSES {
            assert_eq!(sound.matches(part).count(), 1, "{part} in {sound}");
            let said = program.run(&[path.as_ref()], sound.replace(part, change)).expect_err(expected);
            assert_eq!(said.trim_end(), expected, "{} on {change}", program.name);
        }
    }
    assert_no_file_is_left(&programs);
}

fn assert_no_file_is_left(programs: &Programs) {
    let left = std::fs::read_dir(programs.folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path());
    let left: Vec<_> = left.filter(|path| path.to_string_lossy().contains(".rbt")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn text_that_is_not_utf_8_is_refused_by_both_writers() {
    let programs = Programs::new("rewrite");
    let wrong: [&[u8]; 9] = [
        b"\x80",
        b"\xc3",
        b"\xc3(",
        b"\xc0\xaf",
        b"\xe0\x80\xaf",
        b"\xed\xa0\x80",
        b"\xf0\x80\x80\xaf",
        b"\xf4\x90\x80\x80",
        b"\xf8\x88\x80\x80\x80",
    ];
    let sound = small();
    let rest = sound.strip_prefix("small\nsmall\n\n").expect("three texts").as_bytes();
    let notes: [&[u8]; 2] = [b"\"remarks\":{\"left_out\":[],\"notes\":[\"", b"\"]}"];
    for program in &programs.all {
        let path = programs.folder.path().join("wrong.rbt");
        for wrong in wrong {
            for (texts, expected) in [
                ([wrong, b"small", b""].join(&b'\n'), "generator is not UTF-8"),
                ([b"small", wrong, b""].join(&b'\n'), "scene is not UTF-8"),
                ([b"small", &b"small"[..], &notes.join(wrong)].join(&b'\n'), "more is not UTF-8"),
            ] {
                let listing = [&texts, rest].join(&b'\n');
                let said = program.run(&[path.as_ref()], &listing).expect_err(expected);
                assert_eq!(said.trim_end(), expected, "{} on {wrong:x?}", program.name);
            }
        }
    }
    assert_no_file_is_left(&programs);
}

/// Runs a program that tries things on traces of its own, and returns what it says of each.
fn tried(program: &Program, programs: &Programs) -> Vec<String> {
    let path = programs.folder.path().join("tried.rbt");
    let said = program.run(&[path.as_ref()], "").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read(&path).steps(), 1, "one is finished in spite of all");
    std::fs::remove_file(&path).expect("it is there");
    assert_no_file_is_left(programs);
    said.lines().map(str::to_owned).collect()
}

#[test]
fn tiles_of_another_writer_or_after_the_end_are_refused_by_both_writers() {
    let programs = Programs::new("order");
    for program in &programs.all {
        let expected = [
            "another: tile 0 is of another writer",
            "abandoned: no trace is open",
            "abandoned: no trace is open",
            "finished: no trace is open",
            "finished: no trace is open",
        ];
        assert_eq!(tried(program, &programs), expected, "{}", program.name);
    }
}

#[test]
fn tiles_in_c_outlive_their_writer_and_keep_an_error_until_they_begin_again() {
    let programs = Programs::new("tiles");
    for program in &programs.all {
        let expected = [
            "begin: tile 1 of 1",
            "ray: tile 1 of 1",
            "end: tile 1 of 1",
            "again: nothing",
            "end: no trace is open",
            "begin: no trace is open",
        ];
        assert_eq!(tried(program, &programs), expected);
    }
}

#[test]
fn numbers_and_keys_that_only_python_can_get_wrong_are_refused_before_anything_is_written() {
    let programs = Programs::new("limits");
    for program in &programs.all {
        let expected = [
            "ValueError: a sample of -1, 0 to 2^32 - 1 expected",
            "ValueError: a light of 1099511627776, 0 to 2^32 - 1 expected",
            "ValueError: a depth of -1, 0 to 2^32 - 1 expected",
            "ValueError: a depth of 1099511627776, 0 to 2^32 - 1 expected",
            "TypeError: 'float' object cannot be interpreted as an integer",
            "TypeError: 'float' object cannot be interpreted as an integer",
            "ValueError: a scene_hash of -1, 0 to 2^64 - 1 expected",
            "ValueError: sah_costs of 1 numbers, 2 expected",
            "ValueError: sah_costs are not finite",
            "ValueError: scene is not UTF-8",
            "ValueError: more is not JSON",
            "ValueError: more has \"depth\", which the header has already",
            "ValueError: more has \"node_format\", which the header has already",
            "ValueError: node 0 leads to 0 from 4294967296: children lie behind it, and nothing leads outside",
            "ValueError: node 0 is of a kind that this structure does not have",
            "ValueError: a number of stalls of -1, 0 to 2^64 - 1 expected",
            "ValueError: a number of stalls of 18446744073709551616, 0 to 2^64 - 1 expected",
        ];
        assert_eq!(tried(program, &programs), expected);
    }
}

#[test]
fn python_writes_numbers_of_other_packages_as_its_own() {
    let programs = Programs::new("foreign");
    for program in &programs.all {
        assert_eq!(tried(program, &programs), ["the same"]);
    }
}

#[cfg(unix)]
#[test]
fn a_trace_from_python_has_the_mode_of_any_file_and_the_mask_of_the_process_stays() {
    let programs = Programs::new("mode");
    for program in &programs.all {
        assert_eq!(tried(program, &programs), ["0o640"]);
    }
}
