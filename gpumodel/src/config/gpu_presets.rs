//! The GPUs that come with the program: `configs/gpus`.

/// A description that comes with the program.
pub struct BuiltinGpu {
    /// Its name on the command line.
    pub name: &'static str,
    /// The text of its file.
    pub toml: &'static str,
}

/// A description of `configs/gpus`, called as its file is.
macro_rules! builtin {
    ($name:literal) => {
        BuiltinGpu { name: $name, toml: include_str!(concat!("../../../configs/gpus/", $name, ".toml")) }
    };
}

/// All descriptions that come with the program, by maker and number.
pub const GPUS: &[BuiltinGpu] = &[
    builtin!("adreno-530"),
    builtin!("adreno-540"),
    builtin!("adreno-630"),
    builtin!("adreno-640"),
    builtin!("adreno-650"),
    builtin!("adreno-660"),
    builtin!("adreno-730"),
    builtin!("adreno-740"),
    builtin!("adreno-750"),
    builtin!("adreno-830"),
    builtin!("adreno-x1-85"),
    builtin!("mali-g57"),
    builtin!("mali-g71"),
    builtin!("mali-g72"),
    builtin!("mali-g76"),
    builtin!("mali-g77"),
    builtin!("mali-g78"),
    builtin!("mali-g710"),
    builtin!("mali-g715"),
    builtin!("mali-g720"),
    builtin!("mali-g925"),
    builtin!("mali-g1-ultra"),
    builtin!("sgrt"),
    builtin!("vulkan-sim-mobile"),
];

impl BuiltinGpu {
    /// The description of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        GPUS.iter().find(|gpu| gpu.name == name)
    }
}
