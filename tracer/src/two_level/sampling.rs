//! Evenly spread numbers, the same on any machine.

/// A sequence of numbers in `[0, 1)`: SplitMix64 (Steele, Lea & Flood 2014), from seed 0.
pub(super) struct Uniform {
    state: u64,
}

impl Uniform {
    pub(super) fn new() -> Self {
        Self { state: 0 }
    }

    pub(super) fn next(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.state;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^= mixed >> 31;
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }
}
