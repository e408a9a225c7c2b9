//! OBJ texts, and the MTL libraries that they name.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    drop(scenes::obj::parse(bytes, "fuzz.obj"));
    scenes::mtl::parse(bytes);
});
