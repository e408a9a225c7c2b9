//! Numbers in as few letters as a page can unpack: differences from a prediction, deflated, in base 64.
//!
//! Figures of pixels have a common divisor (bytes come in records), are near to those of their neighbours, and mostly small. So they are divided
//! by it, predicted by the median edge detector of LOCO-I (Weinberger, Seroussi and Sapiro, IEEE Transactions on Image Processing 9(8), 2000), and the differences, signs folded
//! in (0, -1, 1, -2, ...), are laid out byte by byte: all low bytes first. Nothing is lost.

use miniz_oxide::deflate::compress_to_vec_zlib;
use serde::Serialize;

/// miniz's best: 10 takes much longer and gains under 1 %.
const DEFLATE_LEVEL: u8 = 9;
const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Values, row by row.
#[derive(Debug, Serialize)]
pub(super) struct Packed {
    /// All values are multiples of it.
    divisor: u32,
    /// Bytes of each difference.
    planes: u8,
    /// The planes, the lowest first, as a zlib stream in base 64.
    data: String,
}

impl Packed {
    /// Of rows of `width` values, at least 1.
    pub(super) fn new(width: usize, values: &[u32]) -> Self {
        let divisor = values.iter().copied().fold(0, greatest_common_divisor).max(1);
        let folded = differences(width, values, divisor);
        let most = folded.iter().copied().max().unwrap_or(0);
        let planes = (u32::BITS - most.leading_zeros()).div_ceil(8).max(1) as u8;
        let bytes: Vec<u8> = (0..planes)
            .flat_map(|plane| folded.iter().map(move |&folded| (folded >> (8 * plane)) as u8))
            .collect();
        Self { divisor, planes, data: base64(&compress_to_vec_zlib(&bytes, DEFLATE_LEVEL)) }
    }
}

impl Packed {
    /// Letters of the data.
    pub(super) fn letters(&self) -> usize {
        self.data.len()
    }
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// What each value differs by from what its neighbours predict.
fn differences(width: usize, values: &[u32], divisor: u32) -> Vec<u32> {
    let at = |place: usize| values[place] / divisor;
    let of_place = |place: usize| {
        let left = (!place.is_multiple_of(width)).then(|| at(place - 1));
        let up = (place >= width).then(|| at(place - width));
        let predicted = match (left, up) {
            (Some(left), Some(up)) => median_edge(left, up, at(place - width - 1)),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => 0,
        };
        let difference = at(place).wrapping_sub(predicted) as i32;
        ((difference << 1) ^ (difference >> 31)) as u32
    };
    (0..values.len()).map(of_place).collect()
}

fn median_edge(left: u32, up: u32, corner: u32) -> u32 {
    if corner >= left.max(up) {
        left.min(up)
    } else if corner <= left.min(up) {
        left.max(up)
    } else {
        // Between the two, so the result is too.
        left.wrapping_add(up).wrapping_sub(corner)
    }
}

fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let padded = [chunk[0], *chunk.get(1).unwrap_or(&0), *chunk.get(2).unwrap_or(&0)];
        let bits = u32::from_be_bytes([0, padded[0], padded[1], padded[2]]);
        for letter in 0..4 {
            let place = (bits >> (18 - 6 * letter)) & 63;
            text.push(if letter > chunk.len() as u32 { '=' } else { char::from(LETTERS[place as usize]) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::inflate::decompress_to_vec_zlib;

    /// What the page's script does.
    fn unpacked(width: usize, count: usize, packed: &Packed) -> Vec<u32> {
        let place = |letter: u8| LETTERS.iter().position(|&known| known == letter).unwrap_or(0) as u32;
        let mut bytes = Vec::new();
        for four in packed.data.as_bytes().chunks(4) {
            let bits = four.iter().fold(0, |bits, &letter| bits << 6 | place(letter));
            let padding = four.iter().filter(|&&letter| letter == b'=').count();
            bytes.extend(&bits.to_be_bytes()[1..4 - padding]);
        }
        let planes = decompress_to_vec_zlib(&bytes).expect("a zlib stream");
        assert_eq!(planes.len(), count * usize::from(packed.planes));
        let mut values: Vec<u32> = Vec::new();
        for place in 0..count {
            let folded = (0..usize::from(packed.planes))
                .map(|plane| u32::from(planes[plane * count + place]) << (8 * plane))
                .sum::<u32>();
            let difference = (folded >> 1) ^ 0_u32.wrapping_sub(folded & 1);
            let (left, up) = (!place.is_multiple_of(width), place >= width);
            let predicted = match (left, up) {
                (true, true) => {
                    median_edge(values[place - 1], values[place - width], values[place - width - 1])
                }
                (true, false) => values[place - 1],
                (false, true) => values[place - width],
                (false, false) => 0,
            };
            values.push(predicted.wrapping_add(difference));
        }
        values.into_iter().map(|value| value * packed.divisor).collect()
    }

    #[test]
    fn what_is_unpacked_is_what_was_packed() {
        let edges = [0, 1, 2, u32::MAX, u32::MAX - 1, 1 << 31, (1 << 31) - 1, 7];
        let noise: Vec<u32> = (0..1000_u32).map(|n| n.wrapping_mul(2_654_435_761) >> (n % 32)).collect();
        let records: Vec<u32> = (0..1000_u32).map(|n| 16 * (n * n % 37)).collect();
        for (width, values) in
            [(4, &edges[..]), (8, &edges), (1, &edges), (40, &noise), (25, &records), (1, &[0])]
        {
            let packed = Packed::new(width, values);
            assert_eq!(unpacked(width, values.len(), &packed), values, "{width}");
        }
        assert_eq!(Packed::new(25, &records).divisor, 16);
    }

    #[test]
    fn base_64_is_that_of_rfc_4648() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in cases {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn equal_figures_take_next_to_nothing() {
        assert!(Packed::new(1024, &vec![12; 1 << 20]).data.len() < 3000);
    }
}
