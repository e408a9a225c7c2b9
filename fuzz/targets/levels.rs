//! Descriptions of caches. One that is accepted and small is also built and run.
#![no_main]

use cachesim::{Hierarchy, Levels, LineId};

/// Building a larger hierarchy would only slow the search.
const MOST_LINES: u64 = 1 << 14;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let Ok(levels) = Levels::parse(text, "fuzz.toml") else { return };
    let lines: u64 = levels.as_slice().iter().map(|level| level.lines() * u64::from(level.count)).sum();
    if lines > MOST_LINES {
        return;
    }
    let (mut hierarchy, path) =
        Hierarchy::chain(&levels).expect("levels that were accepted can be simulated");
    let run: Vec<LineId> = (0..256).map(|i| LineId::new(i * i % 97)).collect();
    hierarchy.read(path, 0, &run);
    hierarchy.write(path, hierarchy.units() - 1, &run);
    hierarchy.flush();
});
