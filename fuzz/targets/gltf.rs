//! `.gltf` texts and `.glb` containers. Every file beside them holds the same 64 bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    drop(scenes::gltf::parse(bytes, "fuzz.glb", |_, limit| match limit {
        64.. => Ok((0..64).collect()),
        _ => Err("too large".to_owned()),
    }));
});
