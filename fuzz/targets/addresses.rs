//! Address files through a small hierarchy and through miss-ratio curves. The first byte chooses the format.
#![no_main]

use cachesim::{
    AddressFormat, AddressReader, Aet, Bytes, Hierarchy, LevelConfig, Levels, LineSize, Policy,
    StackDistances, Ways,
};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, file)) = bytes.split_first() else { return };
    let format = [AddressFormat::Din, AddressFormat::Csv, AddressFormat::U64][usize::from(choice % 3)];
    let line = LineSize::new(64).expect("a power of two");
    let levels = Levels::new(vec![
        LevelConfig { count: 2, ..LevelConfig::new("L1", Bytes(1 << 10), line, Ways::Count(4), Policy::Lru) },
        LevelConfig::new("L2", Bytes(8 << 10), line, Ways::Full, Policy::Lru),
    ])
    .expect("a plain hierarchy");
    let (mut hierarchy, path) = Hierarchy::chain(&levels).expect("a plain hierarchy");
    let reader = |units| AddressReader::new(file, format, "fuzz", units);
    let replayed = reader(hierarchy.units()).replay(&mut hierarchy, path).is_ok();
    let (mut distances, mut aet) = (StackDistances::new(), Aet::new());
    let measured = reader(hierarchy.units()).for_each_line(line, |line| {
        distances.touch(line);
        aet.touch(line);
    });
    assert_eq!(replayed, measured.is_ok());
    if replayed {
        for curve in [distances.curve(), aet.curve()] {
            assert_eq!(curve.accesses(), hierarchy.counts(0).accesses);
        }
    }
});
