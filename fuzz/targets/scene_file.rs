//! Scene files.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    drop(scenes::scene_file::parse(bytes, "fuzz.toml"));
});
