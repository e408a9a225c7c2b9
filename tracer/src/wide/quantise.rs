//! Boxes in steps of a power of two from an origin, never smaller than the boxes that they stand for.
//!
//! Ylitie, Karras and Laine 2017: per node an origin, per axis an 8-bit exponent; per child and plane an 8-bit number of steps, rounded
//! down for lower planes and up for upper ones. There the planes are compared without being computed; here, as in a shader that
//! computes `origin + steps * 2^exponent` in f32, the rounding of that sum counts too.

use super::format::Origin;
use crate::aabb::Aabb;
use glam::Vec3;

/// Most steps of a plane from the origin.
const MOST_STEPS: f64 = 255.0;
/// Exponents that the 8 bits of an f32's exponent can stand for, without denormals and infinities.
const EXPONENTS: std::ops::RangeInclusive<i32> = -126..=127;

/// Where the planes of a node's children can lie: per axis, at multiples of a step from an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    origin: [f32; 3],
    step: [f32; 3],
}

impl Grid {
    /// The finest grid that holds `bounds`, a box that is not empty.
    ///
    /// # Errors
    /// The coordinate that an origin of that kind cannot lie below.
    pub fn around(bounds: &Aabb, kind: Origin) -> Result<Self, f32> {
        let mut grid = Self { origin: [0.0; 3], step: [0.0; 3] };
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let origin = match kind {
                Origin::Single => low,
                Origin::UpperHalf => upper_half_below(low),
            };
            if !origin.is_finite() {
                return Err(low);
            }
            grid.origin[axis] = origin;
            let extent = f64::from(high) - f64::from(origin);
            let mut exponent = ((extent / MOST_STEPS).log2().ceil() as i32).max(*EXPONENTS.start());
            grid.step[axis] = power_of_two(exponent);
            // The logarithm is rounded, and so is a plane's sum.
            while f64::from(high) > f64::from(grid.plane(axis, MOST_STEPS as u8)) {
                exponent += 1;
                grid.step[axis] = power_of_two(exponent);
            }
        }
        Ok(grid)
    }

    /// Where a plane lies, as a shader computes it.
    #[inline]
    pub fn plane(&self, axis: usize, steps: u8) -> f32 {
        self.origin[axis] + f32::from(steps) * self.step[axis]
    }

    /// The smallest box of the grid around `bounds`, which lies in the box that the grid was made for.
    pub fn snap(&self, bounds: &Aabb) -> Aabb {
        let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
        for axis in 0..3 {
            let steps =
                |plane: f32| (f64::from(plane) - f64::from(self.origin[axis])) / f64::from(self.step[axis]);
            let mut low = steps(bounds.min[axis]).floor().clamp(0.0, MOST_STEPS) as u8;
            while low > 0 && self.plane(axis, low) > bounds.min[axis] {
                low -= 1;
            }
            let mut high = steps(bounds.max[axis]).ceil().clamp(0.0, MOST_STEPS) as u8;
            while high < u8::MAX && self.plane(axis, high) < bounds.max[axis] {
                high += 1;
            }
            (min[axis], max[axis]) = (self.plane(axis, low), self.plane(axis, high));
        }
        Aabb { min, max }
    }
}

/// 2 to the power of `exponent`, which the exponent's bits can hold.
fn power_of_two(exponent: i32) -> f32 {
    debug_assert!(EXPONENTS.contains(&exponent));
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// The largest number of 16 bits, with 16 zeros behind them, that is not above `value`.
fn upper_half_below(value: f32) -> f32 {
    const LOWER: u32 = 0xFFFF;
    let bits = value.to_bits();
    let cut = bits & !LOWER;
    // To cut bits off moves towards zero, which is up for negative numbers.
    let below = if value.is_sign_negative() && bits & LOWER != 0 { cut + LOWER + 1 } else { cut };
    f32::from_bits(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_coordinate() -> impl Strategy<Value = f32> {
        let bits = any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |value| value.is_finite());
        prop_oneof![-1e3_f32..1e3, bits, Just(0.0), Just(-0.0), Just(f32::MIN_POSITIVE), Just(1e-45)]
    }

    fn any_box() -> impl Strategy<Value = Aabb> {
        let point = || [any_coordinate(), any_coordinate(), any_coordinate()].prop_map(Vec3::from);
        (point(), point()).prop_map(|(a, b)| Aabb { min: a.min(b), max: a.max(b) })
    }

    /// A point of `bounds`, from three shares.
    fn within(bounds: &Aabb, shares: [f64; 3]) -> Vec3 {
        let point = |axis: usize| {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let at = f64::from(low) + shares[axis] * (f64::from(high) - f64::from(low));
            (at as f32).clamp(low, high)
        };
        Vec3::new(point(0), point(1), point(2))
    }

    proptest! {
        #[test]
        fn a_snapped_box_holds_the_box_and_sticks_out_by_less_than_two_steps(
            bounds in any_box(),
            shares in prop::array::uniform2(prop::array::uniform3(0.0_f64..=1.0)),
        ) {
            for kind in [Origin::Single, Origin::UpperHalf] {
                let Ok(grid) = Grid::around(&bounds, kind) else {
                    prop_assert!(kind == Origin::UpperHalf && bounds.min.min_element() < -3.3e38);
                    continue;
                };
                let [a, b] = shares.map(|shares| within(&bounds, shares));
                let inner = Aabb { min: a.min(b), max: a.max(b) };
                let snapped = grid.snap(&inner);
                prop_assert!(snapped.union(inner) == snapped, "{snapped:?} {inner:?}");
                for axis in 0..3 {
                    // The planes' own rounding is at most half an ulp of the largest coordinate.
                    let ulp = f64::from(bounds.max[axis].abs().max(grid.origin[axis].abs())) * f64::from(f32::EPSILON);
                    let most = 2.0 * f64::from(grid.step[axis]) + 2.0 * ulp;
                    let out = [
                        f64::from(inner.min[axis]) - f64::from(snapped.min[axis]),
                        f64::from(snapped.max[axis]) - f64::from(inner.max[axis]),
                    ];
                    prop_assert!(out.iter().all(|&out| out <= most), "{out:?} {most}");
                }
            }
        }

        #[test]
        fn steps_are_no_coarser_than_they_have_to_be(bounds in any_box()) {
            let grid = Grid::around(&bounds, Origin::Single).expect("every coordinate is an origin");
            for axis in 0..3 {
                let finer = grid.step[axis] / 2.0;
                if finer >= power_of_two(-126) {
                    let reach = f64::from(grid.origin[axis]) + MOST_STEPS * f64::from(finer);
                    let ulp = f64::from(bounds.max[axis].abs().max(grid.origin[axis].abs())) * f64::from(f32::EPSILON);
                    prop_assert!(reach - ulp < f64::from(bounds.max[axis]), "{:?} {grid:?}", bounds);
                }
            }
        }

        #[test]
        fn the_upper_half_is_the_next_one_below(value in any_coordinate()) {
            let below = upper_half_below(value);
            prop_assert!(below <= value && below.to_bits() & 0xFFFF == 0);
            let above = if below > 0.0 || below.to_bits() == 0 {
                f32::from_bits(below.to_bits() + 0x1_0000)
            } else {
                f32::from_bits(below.to_bits() - 0x1_0000)
            };
            prop_assert!(below == value || below.to_bits() == 0x8000_0000 || above > value, "{below} {value} {above}");
        }
    }

    #[test]
    fn what_steps_can_hold_exactly_stays_exact() {
        let bounds =
            Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(-1.0 + 255.0 / 256.0, 255.0, 2.0) };
        for kind in [Origin::Single, Origin::UpperHalf] {
            let grid = Grid::around(&bounds, kind).expect("coordinates are small");
            assert_eq!(grid.snap(&bounds), bounds, "{kind:?}");
            let inner = Aabb { min: Vec3::new(-0.5, 7.0, 2.0), max: Vec3::new(-0.5, 8.0, 2.0) };
            assert_eq!(grid.snap(&inner), inner, "{kind:?}");
        }
    }

    #[test]
    fn an_origin_of_16_bits_cannot_lie_below_the_lowest_numbers() {
        let bounds = Aabb { min: Vec3::splat(f32::MIN), max: Vec3::ZERO };
        assert_eq!(Grid::around(&bounds, Origin::UpperHalf), Err(f32::MIN));
        assert!(Grid::around(&bounds, Origin::Single).is_ok());
    }
}
