//! Are files of addresses read as documented, and hostile ones refused with their place?

use std::io::{BufReader, Read};
use std::path::Path;

use cachesim::{
    Access, AddressFormat, AddressReader, Bytes, Error, Hierarchy, LevelConfig, Levels, LineSize,
    MAX_ACCESS_BYTES, Policy, StackDistances, Ways,
};
use proptest::prelude::*;

fn line() -> LineSize {
    LineSize::new(64).expect("64 is a power of two")
}

/// Unit, and per access the line and whether it is written.
type Block = (u32, Vec<(u64, bool)>);

fn read(bytes: &[u8], format: AddressFormat) -> Result<Vec<Block>, Error> {
    let mut reader = AddressReader::new(bytes, format, "a.trace", 2);
    let (mut block, mut blocks) = (Vec::new(), Vec::new());
    while let Some(unit) = reader.next_block(line(), &mut block)? {
        let shown = |access: &Access| (access.line().get(), access.is_write());
        blocks.push((unit, block.iter().map(shown).collect()));
    }
    Ok(blocks)
}

fn refusal(bytes: &[u8], format: AddressFormat) -> String {
    read(bytes, format).expect_err("must be refused").to_string()
}

#[test]
fn dinero_text_gives_reads_writes_and_fetches() {
    let text = b"0 10000040\n1 7f comment to the end\n\n2 0xffffffffffffffff";
    let blocks = read(text, AddressFormat::Din).expect("good text");
    assert_eq!(blocks, [(0, vec![(0x40_0001, false), (1, true), (u64::MAX >> 6, false)])]);
}

#[test]
fn a_csv_access_touches_every_line_that_its_bytes_overlap() {
    let text = b"op,address,size\nread,0x3f,1\nr,0x3f,2\nwrite,64,129\n";
    let blocks = read(text, AddressFormat::Csv).expect("good text");
    let lines = vec![(0, false), (0, false), (1, false), (1, true), (2, true), (3, true)];
    assert_eq!(blocks, [(0, lines)]);
}

#[test]
fn a_csv_access_may_name_its_unit() {
    let text = b"op,address,size,unit\r\nr,0,1\r\nr,0,1,1\r\nr,64,1,1\r\nw,0,1,0\r\n";
    let blocks = read(text, AddressFormat::Csv).expect("good text");
    assert_eq!(blocks, [(0, vec![(0, false)]), (1, vec![(0, false), (1, false)]), (0, vec![(0, true)])]);
}

#[test]
fn raw_addresses_are_little_endian_reads_however_the_input_is_cut() {
    struct Drops<'a>(&'a [u8]);
    impl Read for Drops<'_> {
        fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
            let count = 3.min(to.len());
            self.0.read(&mut to[..count])
        }
    }
    let addresses = [0_u64, 63, 64, u64::MAX];
    let bytes: Vec<u8> = addresses.iter().flat_map(|address| address.to_le_bytes()).collect();
    let mut reader =
        AddressReader::new(BufReader::with_capacity(1, Drops(&bytes)), AddressFormat::U64, "a.u64", 1);
    let mut block = Vec::new();
    assert_eq!(reader.next_block(line(), &mut block).expect("good bytes"), Some(0));
    let lines: Vec<u64> = block.iter().map(|access| access.line().get()).collect();
    assert_eq!(lines, [0, 0, 1, u64::MAX >> 6]);
    assert_eq!(reader.next_block(line(), &mut block).expect("the end"), None);
}

#[test]
fn wrong_files_are_refused_with_place_and_remedy() {
    use AddressFormat::{Csv, Din, U64};
    let long = vec![b'0'; 5000];
    let cases: [(&[u8], AddressFormat, &str); 17] = [
        (
            b"0 10\n3 10\n",
            Din,
            "a.trace:2: label '3', expected 0 (read), 1 (write) or 2 (fetch); write lines such as",
        ),
        (b"0 10\n0 xyz\n", Din, "a.trace:2: address 'xyz', expected a hexadecimal number of up to 64 bits"),
        (b"0 10000000000000000\n", Din, "a.trace:1: address '10000000000000000'"),
        (b"0 +10\n", Din, "address '+10'"),
        (b"0\n", Din, "a.trace:1: the address is missing"),
        (b"\xff\xfe\x00", Din, "a.trace:1: the line is not text"),
        (&long, Din, "a.trace:1: the line is longer than 1024 bytes"),
        (b"", Din, "a.trace: the file holds no accesses"),
        (b"op,address,size\n", Csv, "a.trace: the file holds no accesses"),
        (b"r,0\n", Csv, "a.trace:1: 2 columns, expected op,address,size"),
        (b"r,0,4\nx,0,4\n", Csv, "a.trace:2: op 'x', expected read or write"),
        (b"r,0,0\n", Csv, "a.trace:1: size 0, expected 1 to 1048576 bytes; split the access"),
        (b"r,0xffffffffffffffff,2\n", Csv, "2 bytes at 0xffffffffffffffff run past the last address"),
        (b"r,0,4,2\n", Csv, "a.trace:1: unit 2, expected less than 2"),
        (b"", U64, "a.trace: the file holds no accesses"),
        (b"1234567", U64, "a.trace: byte 0: 7 bytes are left over, expected whole 8-byte addresses"),
        (b"12345678123", U64, "a.trace: byte 8: 3 bytes are left over"),
    ];
    for (bytes, format, expected) in cases {
        let refusal = refusal(bytes, format);
        assert!(refusal.contains(expected), "got '{refusal}', expected '{expected}'");
    }
}

#[test]
fn the_size_of_an_access_is_limited_tightly() {
    let text = |size: u64| format!("r,0,{size}\n").into_bytes();
    assert!(read(&text(MAX_ACCESS_BYTES), AddressFormat::Csv).is_ok());
    assert!(read(&text(MAX_ACCESS_BYTES + 1), AddressFormat::Csv).is_err());
    assert!(read(b"r,0xffffffffffffffff,1\n", AddressFormat::Csv).is_ok());
}

#[test]
fn the_extension_names_the_format() {
    for (name, format) in
        [("a.din", AddressFormat::Din), ("b/c.csv", AddressFormat::Csv), ("d.e.u64", AddressFormat::U64)]
    {
        assert_eq!(AddressFormat::of(Path::new(name)).expect("a known format"), format);
    }
    for name in ["a", "a.txt", ".din", "a.u64.zst"] {
        let refusal = AddressFormat::of(Path::new(name)).expect_err("an unknown format").to_string();
        assert!(refusal.contains("expected a name that ends in .din, .csv or .u64"), "{refusal}");
    }
}

#[test]
fn a_replay_and_its_stack_distances_see_the_same_accesses() {
    let text = b"r,0,64\nr,64,64\nr,128,64\nr,0,64\n";
    let config = LevelConfig::new("L", Bytes(2 * 64), line(), Ways::Full, Policy::Lru);
    let levels = Levels::new(vec![config]).expect("a plain level");
    let (mut hierarchy, path) = Hierarchy::chain(&levels).expect("a plain level");
    let reader = || AddressReader::new(&text[..], AddressFormat::Csv, "a.csv", 1);
    reader().replay(&mut hierarchy, path).expect("good text");
    let mut distances = StackDistances::new();
    reader().for_each_line(line(), |line| distances.touch(line)).expect("good text");
    let curve = distances.curve();
    assert_eq!((hierarchy.counts(0).accesses, curve.accesses()), (4, 4));
    assert_eq!((hierarchy.counts(0).misses, curve.misses(2)), (4, 4));
    assert_eq!(curve.misses(3), 3);
}

proptest! {
    #[test]
    fn no_bytes_whatever_make_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for format in [AddressFormat::Din, AddressFormat::Csv, AddressFormat::U64] {
            let _ = read(&bytes, format);
        }
    }

    #[test]
    fn no_text_whatever_makes_a_reader_panic(text in "[rw012,x \nfe9-]{0,60}") {
        for format in [AddressFormat::Din, AddressFormat::Csv] {
            let _ = read(text.as_bytes(), format);
        }
    }
}
