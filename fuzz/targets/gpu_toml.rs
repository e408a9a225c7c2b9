//! GPU descriptions, tables of shader costs and of energies, phones.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    drop(gpumodel::Gpu::parse(text, "fuzz.toml"));
    drop(gpumodel::ShaderCosts::parse(text, "fuzz.toml"));
    drop(gpumodel::EnergyTable::parse(text, "fuzz.toml"));
    drop(gpumodel::Technique::parse(text, "fuzz.toml"));
    drop(thermal::Phone::parse(text, "fuzz.toml"));
});
