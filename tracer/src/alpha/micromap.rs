//! Opacity micromaps: what is known of the mask in each part of a triangle that is cut in 4^level, as `VK_EXT_opacity_micromap` has them.
//!
//! Micro-triangles lie along the curve that the extension prescribes, one or two bits each. All alpha-tested triangles have the same mask here, and yet
//! each has a micromap of its own in memory, as masks of real scenes differ.

use super::{fence, fence_over};
use serde::{Deserialize, Serialize};

/// How far barycentrics of a hit may be from their exact values for a micro-triangle to say what the mask does.
const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// What a micro-triangle can say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MicromapStates {
    /// Opaque or transparent, as the mask is in its middle: no shader is ever called, and hits differ from the mask's along its outlines.
    #[serde(rename = "2")]
    Two,
    /// Opaque or transparent, or unknown, in two ways: an any-hit shader decides.
    #[serde(rename = "4")]
    Four,
}

impl MicromapStates {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Two, Self::Four];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Two => "2",
            Self::Four => "4",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|states| states.name() == name)
    }

    fn bits(self) -> u32 {
        match self {
            Self::Two => 1,
            Self::Four => 2,
        }
    }
}

/// What a micromap holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MicromapFormat {
    /// How often a triangle is cut in four.
    pub level: u32,
    /// States of a micro-triangle.
    pub states: MicromapStates,
}

impl MicromapFormat {
    /// The finest: with four states it takes 64 bytes, a line of most caches. A step does not say which part of a micromap it reads.
    pub const MAX_LEVEL: u32 = 4;

    /// Micro-triangles of a triangle.
    pub fn micro_triangles(self) -> u32 {
        1 << (2 * self.level)
    }

    /// Bytes of a triangle's micromap: whole ones, as the extension demands.
    pub fn bytes(self) -> u32 {
        (self.micro_triangles() * self.states.bits()).div_ceil(8)
    }

    /// # Errors
    /// A sentence when it is too fine.
    pub(super) fn check(self) -> Result<(), String> {
        if self.level > Self::MAX_LEVEL {
            return Err(format!(
                "opacity micromaps of level {}, at most {} expected",
                self.level,
                Self::MAX_LEVEL
            ));
        }
        Ok(())
    }
}

/// The micromap of a triangle.
#[derive(Clone, Debug)]
pub struct Micromap {
    format: MicromapFormat,
    /// Packed, the first micro-triangle in the lowest bits: transparent 0, opaque 1, unknown and rather transparent 2, unknown and
    /// rather opaque 3.
    words: Vec<u32>,
}

impl Micromap {
    /// That of the mask [`fence`]. With four states a micro-triangle is opaque or transparent only if the mask is so all over it.
    ///
    /// # Panics
    /// When the format is finer than [`MicromapFormat::MAX_LEVEL`].
    pub fn of_fence(format: MicromapFormat) -> Self {
        assert!(format.level <= MicromapFormat::MAX_LEVEL);
        let edge = 1_u32 << format.level;
        let width = 1.0 / f64::from(edge);
        let bits = format.states.bits();
        let mut words = vec![0; (format.micro_triangles() * bits).div_ceil(32) as usize];
        for (column, row) in (0..edge).flat_map(|column| (0..edge - column).map(move |row| (column, row))) {
            let from = f64::from(column) * width;
            for upper in [false, true] {
                if upper && column + row + 1 == edge {
                    continue;
                }
                let third = if upper { 2.0 } else { 1.0 } / 3.0;
                let middle = fence((from + third * width) as f32);
                let state = match (format.states, fence_over(from - MARGIN, from + width + MARGIN)) {
                    (MicromapStates::Two, _) => u32::from(middle),
                    (MicromapStates::Four, Some(opaque)) => u32::from(opaque),
                    (MicromapStates::Four, None) => 2 | u32::from(middle),
                };
                let bit = on_curve(column, row, upper, format.level) * bits;
                words[bit as usize / 32] |= state << (bit % 32);
            }
        }
        Self { format, words }
    }

    /// What it says of a hit at these barycentrics; `None` for unknown.
    pub fn opacity(&self, u: f32, v: f32) -> Option<bool> {
        let bits = self.format.states.bits();
        let bit = micro_triangle(u, v, self.format.level) * bits;
        let state = self.words[bit as usize / 32] >> (bit % 32) & ((1 << bits) - 1);
        (state < 2).then_some(state == 1)
    }

    /// Micro-triangles that are unknown.
    pub fn unknown(&self) -> u32 {
        match self.format.states {
            MicromapStates::Two => 0,
            MicromapStates::Four => self.words.iter().map(|word| (word & 0xAAAA_AAAA).count_ones()).sum(),
        }
    }
}

/// The micro-triangle that holds a point. A rounding outside of the triangle it is the nearest one.
fn micro_triangle(u: f32, v: f32, level: u32) -> u32 {
    let edge = 1_u32 << level;
    let scaled = |weight: f32| weight.clamp(0.0, 1.0) * edge as f32;
    let (u, v) = (scaled(u), scaled(v));
    let mut column = (u as u32).min(edge - 1);
    let row = (v as u32).min(edge - 1);
    // Beyond the third edge, by a rounding.
    column -= (column + row + 1).saturating_sub(edge).min(column);
    let upper = u - column as f32 + (v - row as f32) >= 1.0 && column + row + 1 < edge;
    on_curve(column, row, upper, level)
}

/// Place of a micro-triangle on the space-filling curve of `VK_EXT_opacity_micromap`, each part of which fills a triangle. `upper` is the one
/// beyond the diagonal of its cell.
fn on_curve(column: u32, row: u32, upper: bool, level: u32) -> u32 {
    let edge = (1_u32 << level) - 1;
    let third = !(column + row) - u32::from(upper);
    let outer = !(column ^ third) & edge;
    let turned = (column ^ row) & outer;
    let mut flips = turned;
    for shift in [1, 2, 4, 8] {
        flips ^= flips >> shift;
    }
    let inner = ((flips ^ column) & !outer) | turned;
    (0..level)
        .fold(0, |place, bit| place | (outer >> bit & 1) << (2 * bit) | (inner >> bit & 1) << (2 * bit + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn formats() -> impl Iterator<Item = MicromapFormat> {
        (0..=MicromapFormat::MAX_LEVEL)
            .flat_map(|level| MicromapStates::ALL.map(|states| MicromapFormat { level, states }))
    }

    #[test]
    fn the_curve_goes_through_every_micro_triangle_once_and_stays_in_each_quarter_until_it_is_done() {
        for level in 0..=MicromapFormat::MAX_LEVEL {
            let edge = 1_u32 << level;
            let mut seen = vec![false; 1 << (2 * level)];
            for column in 0..edge {
                for row in 0..edge - column {
                    for upper in [false, true].into_iter().filter(|&upper| !upper || column + row + 1 < edge)
                    {
                        let place = on_curve(column, row, upper, level);
                        assert!(!std::mem::replace(&mut seen[place as usize], true), "level {level}");
                        let third = if upper { 2.0 } else { 1.0 } / 3.0;
                        let middle = |cell: u32| (cell as f32 + third) / edge as f32;
                        assert_eq!(micro_triangle(middle(column), middle(row), level), place);
                        if level > 0 {
                            let coarser = micro_triangle(middle(column), middle(row), level - 1);
                            assert_eq!(place >> 2, coarser, "level {level}");
                        }
                    }
                }
            }
            assert!(seen.iter().all(|&seen| seen), "level {level}");
        }
    }

    #[test]
    fn sizes_are_those_of_the_extension() {
        for (level, states, bytes) in [
            (0, MicromapStates::Two, 1),
            (0, MicromapStates::Four, 1),
            (2, MicromapStates::Two, 2),
            (3, MicromapStates::Four, 16),
            (4, MicromapStates::Two, 32),
            (4, MicromapStates::Four, 64),
        ] {
            assert_eq!(MicromapFormat { level, states }.bytes(), bytes, "level {level}, {states:?}");
        }
    }

    #[test]
    fn finer_micromaps_leave_less_to_the_shader() {
        let unknown = |level| {
            let micromap = Micromap::of_fence(MicromapFormat { level, states: MicromapStates::Four });
            f64::from(micromap.unknown()) / f64::from(micromap.format.micro_triangles())
        };
        assert_eq!(unknown(0), 1.0);
        assert!(unknown(4) < unknown(3) && (0.3..0.7).contains(&unknown(4)), "{}", unknown(4));
    }

    proptest! {
        #[test]
        fn what_is_known_is_so(u in -1e-6_f32..1.000_001, share in -1e-6_f32..1.000_001) {
            let v = (1.0 - u) * share;
            for format in formats() {
                match (format.states, Micromap::of_fence(format).opacity(u, v)) {
                    (MicromapStates::Four, Some(opaque)) => prop_assert_eq!(opaque, fence(u)),
                    (MicromapStates::Four, None) => {}
                    (MicromapStates::Two, state) => prop_assert!(state.is_some()),
                }
            }
        }

        #[test]
        fn points_on_the_lattice_and_its_edges_are_known_rightly(column in 0_u32..=16, row in 0_u32..=16, ulps in -2_i32..=2) {
            let near = |weight: f32| f32::from_bits((weight.to_bits() as i32 + ulps).max(0) as u32);
            let (u, v) = (near(column as f32 / 16.0), near(row.min(16 - column) as f32 / 16.0));
            for format in formats().filter(|format| format.states == MicromapStates::Four) {
                if let Some(opaque) = Micromap::of_fence(format).opacity(u, v) {
                    prop_assert_eq!(opaque, fence(u));
                }
            }
        }
    }
}
