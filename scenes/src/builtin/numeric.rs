//! Arithmetic whose every bit is the same on every platform: only + - * / and sqrt, never a libm function.

use glam::{DVec3, Vec3};

/// SplitMix64 (Steele, Lea and Flood 2014): a seeded sequence of 64-bit integers.
pub(super) struct SplitMix64(pub(super) u64);

impl SplitMix64 {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform in [0, 1), in steps of 2^-53.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the cube from -1 to 1.
    pub(super) fn in_cube(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }
}

/// The finaliser of SplitMix64, a bijection that scrambles all bits.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Sine and cosine of an angle in whole turns; the error is below 1e-14.
///
/// Reduced to an eighth of a turn, then the Taylor polynomials.
pub fn sin_cos(turns: f64) -> (f64, f64) {
    let eighths = (turns * 4.0 + 0.5).floor();
    let x = (turns - eighths * 0.25) * std::f64::consts::TAU;
    let q = x * x;
    let mut sine = 0.0;
    let mut cosine = 0.0;
    for k in [16.0, 14.0, 12.0, 10.0, 8.0, 6.0, 4.0, 2.0f64] {
        sine = (1.0 + sine) * (-q / (k * (k + 1.0)));
        cosine = (1.0 + cosine) * (-q / (k * (k - 1.0)));
    }
    let (s, c) = ((1.0 + sine) * x, 1.0 + cosine);
    match (eighths - (eighths * 0.25).floor() * 4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Smooth value noise in [-1, 1] with lattice spacing 1, seeded.
pub(super) fn noise(p: DVec3, seed: u64) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * (DVec3::splat(3.0) - f * 2.0);
    let corner = |dx: i64, dy: i64, dz: i64| {
        let (x, y, z) = (cell.x as i64 + dx, cell.y as i64 + dy, cell.z as i64 + dz);
        let key = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            ^ (z as u64).wrapping_mul(0x1656_67b1_9e37_79f9)
            ^ seed;
        (mix(key) >> 11) as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
    };
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |dy, dz| lerp(corner(0, dy, dz), corner(1, dy, dz), w.x);
    let along_y = |dz| lerp(along_x(0, dz), along_x(1, dz), w.y);
    lerp(along_y(0), along_y(1), w.z)
}

/// Rounds to f32 once, component by component.
pub(super) fn to_f32(p: DVec3) -> Vec3 {
    Vec3::new(p.x as f32, p.y as f32, p.z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_agree_with_libm_to_twelve_digits() {
        for i in -4000..4000 {
            let turns = f64::from(i) / 997.0;
            let (s, c) = sin_cos(turns);
            let (es, ec) = (turns * std::f64::consts::TAU).sin_cos();
            assert!(
                (s - es).abs() < 1e-12 && (c - ec).abs() < 1e-12,
                "{turns} turns: {s} {c}, libm {es} {ec}"
            );
        }
    }

    #[test]
    fn splitmix64_gives_its_published_first_values() {
        let mut random = SplitMix64(1_234_567);
        let first = [random.next(), random.next(), random.next()];
        assert_eq!(first, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn noise_is_bounded_and_continuous_across_cells() {
        for i in 0..1000 {
            let p = DVec3::new(f64::from(i) * 0.37 - 100.0, f64::from(i) * 0.11, 5.0);
            let (here, near) = (noise(p, 7), noise(p + DVec3::splat(1e-7), 7));
            assert!(here.abs() <= 1.0 && (here - near).abs() < 1e-5);
        }
    }
}
