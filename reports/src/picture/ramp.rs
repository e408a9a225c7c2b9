//! Viridis: even steps of lightness from dark violet to yellow, ordered also in grey and for the colour-blind
//! (van der Walt & Smith 2015, released into the public domain).

use super::Rgb;

/// Viridis at nine evenly spaced points.
pub(crate) const POINTS: [Rgb; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x90, 0x8c],
    [0x27, 0xad, 0x81],
    [0x5d, 0xc8, 0x63],
    [0xaa, 0xdc, 0x32],
    [0xfd, 0xe7, 0x25],
];

/// The colour at `part` of the scale, 0 to 1.
pub(crate) fn colour(part: f64) -> Rgb {
    let place = part.clamp(0.0, 1.0) * (POINTS.len() - 1) as f64;
    let below = (place as usize).min(POINTS.len() - 2);
    let along = place - below as f64;
    std::array::from_fn(|channel| {
        let (a, b) = (f64::from(POINTS[below][channel]), f64::from(POINTS[below + 1][channel]));
        (a + (b - a) * along).round() as u8
    })
}

/// CIE lightness L* of an sRGB colour, 0 to 100.
pub(crate) fn lightness(colour: Rgb) -> f64 {
    let linear = colour.map(|channel| {
        let s = f64::from(channel) / 255.0;
        if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    });
    let y: f64 = linear.iter().zip([0.2126, 0.7152, 0.0722]).map(|(c, weight)| c * weight).sum();
    // Below this the formula is a straight line through black.
    if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_up_the_scale_is_lighter_by_about_as_much() {
        let steps: Vec<f64> = (0..=64).map(|step| lightness(colour(f64::from(step) / 64.0))).collect();
        let whole = steps[64] - steps[0];
        for pair in steps.windows(2) {
            let step = (pair[1] - pair[0]) / whole * 64.0;
            assert!((0.5..1.6).contains(&step), "a step of {step} times the mean step");
        }
    }

    #[test]
    fn parts_outside_the_scale_take_its_ends() {
        assert_eq!(colour(-1.0), POINTS[0]);
        assert_eq!(colour(2.0), POINTS[8]);
        assert_eq!(colour(f64::NAN), colour(f64::NAN));
    }
}
