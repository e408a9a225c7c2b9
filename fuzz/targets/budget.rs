//! Budget files, and the reports that a check holds against them.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    drop(reports::budget::Budget::parse(text, "fuzz.toml"));
    drop(reports::budget::Accepted::parse(text, "fuzz.toml"));
    drop(reports::json::read(text, "fuzz.json"));
});
