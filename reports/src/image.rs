//! A rendered image as PNG: 8 bits per channel, sRGB, nothing around it.

use crate::picture::encode_png;

pub use crate::picture::Rgb;

/// Why an image cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unwritable(String);

/// The bytes of a PNG file of `pixels`, row by row from the upper left.
///
/// # Errors
/// When there are no pixels, or not a whole number of rows.
pub fn write_png(width: u32, pixels: &[Rgb]) -> Result<Vec<u8>, Unwritable> {
    let row = width as usize;
    if pixels.is_empty() || row == 0 || !pixels.len().is_multiple_of(row) {
        return Err(Unwritable(format!("{} pixels are no rows of {width}", pixels.len())));
    }
    let height = u32::try_from(pixels.len() / row)
        .map_err(|_| Unwritable(format!("{} rows are more than a PNG file holds", pixels.len() / row)))?;
    encode_png(width, height, pixels)
        .map_err(|error| Unwritable(format!("the image cannot be encoded: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_comes_back() {
        let pixels: Vec<Rgb> = (0..6).map(|index| [index, 255 - index, 7]).collect();
        let bytes = write_png(3, &pixels).expect("two rows");
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
        assert_eq!((reader.info().width, reader.info().height), (3, 2));
        let mut read = vec![0; 18];
        reader.next_frame(&mut read).expect("an image");
        assert_eq!(read, pixels.as_flattened());
    }

    #[test]
    fn what_is_no_rectangle_is_refused() {
        let refused = |width, count| write_png(width, &vec![[0; 3]; count]).expect_err("no rows").to_string();
        assert_eq!(refused(3, 4), "4 pixels are no rows of 3");
        assert_eq!(refused(3, 0), "0 pixels are no rows of 3");
        assert_eq!(refused(0, 4), "4 pixels are no rows of 0");
    }
}
