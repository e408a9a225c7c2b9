//! Points of the unit square that are spread more evenly than random ones: Sobol' points, scrambled anew for every pixel and set.
//!
//! The first two dimensions of Sobol' 1967, with the scrambling and shuffling by hashes of Burley, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4), 2020; the permutation is that of Laine & Karras, "Stratified Sampling for Stochastic Transparency", 2011. Of
//! the first 2^k points of a set, each rectangle of 2^i by 2^(k - i) equal parts of the square holds exactly one.

/// The points of one set of rays in one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points {
    order: u32,
    scramble: [u32; 2],
}

impl Points {
    /// Those of `set`, any number that tells the sets of a pixel apart.
    pub(crate) fn new(seed: u32, pixel: u64, set: u32) -> Self {
        let first = mixed(mixed(pixel) ^ (u64::from(seed) << 32 | u64::from(set)));
        let second = mixed(first);
        Self { order: first as u32, scramble: [second as u32, (second >> 32) as u32] }
    }

    /// Point `sample`, each coordinate in `[0, 1)`.
    pub(crate) fn point(&self, sample: u32) -> [f32; 2] {
        let index = scrambled(sample, self.order);
        let sobol = [index.reverse_bits(), second_dimension(index)];
        // 24 bits, as many as f32 holds: the largest stays below 1.
        std::array::from_fn(|axis| {
            (scrambled(sobol[axis], self.scramble[axis]) >> 8) as f32 / (1 << 24) as f32
        })
    }
}

/// The second dimension of Sobol's sequence: its matrix is Pascal's triangle modulo 2.
fn second_dimension(index: u32) -> u32 {
    let (mut point, mut column, mut rest) = (0, 1_u32 << 31, index);
    while rest != 0 {
        if rest & 1 != 0 {
            point ^= column;
        }
        column ^= column >> 1;
        rest >>= 1;
    }
    point
}

/// Owen's nested uniform scrambling in base 2: a bit is flipped or not by those above it and the seed.
fn scrambled(value: u32, seed: u32) -> u32 {
    let mut x = value.reverse_bits().wrapping_add(seed);
    // Even factors, so that no bit depends on those above it.
    for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// The finaliser of SplitMix64 (Steele, Lea & Flood 2014), after its increment.
fn mixed(value: u64) -> u64 {
    let mut x = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether no two of the first 2^`log2` points lie in one of the 2^`columns_log2` by 2^(`log2` - `columns_log2`) parts of the square.
    fn one_in_each(points: &Points, log2: u32, columns_log2: u32) -> bool {
        let (columns, rows) = ((1 << columns_log2) as f32, (1 << (log2 - columns_log2)) as f32);
        let mut found = vec![false; 1 << log2];
        (0..1 << log2).all(|sample| {
            let [x, y] = points.point(sample);
            let part = (y * rows) as usize * columns as usize + (x * columns) as usize;
            !std::mem::replace(&mut found[part], true)
        })
    }

    #[test]
    fn every_rectangle_of_a_power_of_two_holds_one_point() {
        for pixel in 0..200 {
            let points = Points::new(7, pixel, 3);
            for log2 in 0..=8 {
                assert!((0..=log2).all(|columns| one_in_each(&points, log2, columns)), "{pixel}, {log2}");
            }
        }
    }

    #[test]
    fn the_sequence_without_scrambling_is_that_of_sobol() {
        let sixteenths = |value: u32| value >> 28;
        let points: Vec<_> =
            (0..8_u32).map(|i| [sixteenths(i.reverse_bits()), sixteenths(second_dimension(i))]).collect();
        // Joe & Kuo 2008, the first eight points of dimensions 1 and 2 in the order of the index.
        assert_eq!(points, [[0, 0], [8, 8], [4, 12], [12, 4], [2, 10], [10, 2], [6, 6], [14, 14]]);
    }

    #[test]
    fn scrambling_is_nested() {
        for seed in [0, 1, 0xdead_beef] {
            for value in [0, 0x1234_5678, u32::MAX] {
                for bit in 0..32 {
                    // What lies below the changed bit may differ, what lies above may not, the bit itself must.
                    let changed = scrambled(value, seed) ^ scrambled(value ^ 1 << bit, seed);
                    assert_eq!(31 - changed.leading_zeros(), bit);
                }
            }
        }
    }

    #[test]
    fn seeds_pixels_and_sets_have_points_of_their_own_and_the_same_ones_again() {
        let of = |seed, pixel, set| [0, 1].map(|sample| Points::new(seed, pixel, set).point(sample));
        let all = [of(0, 0, 0), of(1, 0, 0), of(0, 1, 0), of(0, 0, 1), of(0, 1 << 32, 0)];
        for (index, points) in all.iter().enumerate() {
            assert!(!all[..index].contains(points), "{index}");
        }
        assert_eq!(all[0], of(0, 0, 0));
    }

    #[test]
    fn coordinates_over_pixels_are_uniform() {
        // 64 bins of 2^14 pixels' first points: chi-square with 63 degrees of freedom exceeds 120 once in 10^5.
        const PIXELS: u64 = 1 << 14;
        for axis in 0..2 {
            let mut bins = [0_u32; 64];
            for pixel in 0..PIXELS {
                bins[(Points::new(0, pixel, 0).point(0)[axis] * 64.0) as usize] += 1;
            }
            let expected = PIXELS as f64 / 64.0;
            let chi_square: f64 =
                bins.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
            assert!((20.0..120.0).contains(&chi_square), "{chi_square}");
        }
    }

    #[test]
    fn an_integral_is_nearer_than_with_random_points() {
        // x * y over the square is 1/4. With 16 random points its variance is 7/144/16; the spread ones have at most a tenth.
        let pixels = 4000;
        let error = |pixel| {
            let points = Points::new(5, pixel, 1);
            let sum: f64 = (0..16).map(|sample| points.point(sample)).map(|[x, y]| f64::from(x * y)).sum();
            sum / 16.0 - 0.25
        };
        let errors: Vec<f64> = (0..pixels).map(error).collect();
        let mean = errors.iter().sum::<f64>() / pixels as f64;
        let variance = errors.iter().map(|error| error * error).sum::<f64>() / pixels as f64;
        let random = 7.0 / 144.0 / 16.0;
        assert!(variance < random / 10.0, "{variance}, {random} with random points");
        assert!(mean.abs() < 4.0 * (variance / pixels as f64).sqrt(), "{mean}");
    }
}
