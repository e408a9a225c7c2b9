//! Colours of series: those of Okabe and Ito 2008, "Color Universal Design", in an order in which neighbours also differ
//! in lightness. Further series take the same colours with stripes.

use crate::picture::Rgb;

pub(crate) const BLUE: Rgb = [0x00, 0x72, 0xb2];
pub(crate) const VERMILION: Rgb = [0xd5, 0x5e, 0x00];
pub(crate) const SKY_BLUE: Rgb = [0x56, 0xb4, 0xe9];
pub(crate) const YELLOW: Rgb = [0xf0, 0xe4, 0x42];

/// Blue, orange, vermilion, sky blue, bluish green, yellow, black, reddish purple.
const COLOURS: [Rgb; 8] = [
    BLUE,
    [0xe6, 0x9f, 0x00],
    VERMILION,
    SKY_BLUE,
    [0x00, 0x9e, 0x73],
    YELLOW,
    [0x00, 0x00, 0x00],
    [0xcc, 0x79, 0xa7],
];

/// Series that can be told apart.
pub(crate) const MOST: usize = 2 * COLOURS.len();

/// The colour of a series, and whether it is striped.
pub(crate) fn colour(series: usize) -> (Rgb, bool) {
    (COLOURS[series % COLOURS.len()], series >= COLOURS.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::ramp::lightness;

    #[test]
    fn neighbours_differ_in_grey_too() {
        for pair in COLOURS.windows(2) {
            let difference = (lightness(pair[0]) - lightness(pair[1])).abs();
            assert!(difference > 10.0, "{pair:?} differ by {difference} of 100");
        }
    }
}
