//! An RGB picture in memory: rectangles, text, PNG.

use super::font;

/// Red, green, blue, 8 bits each, sRGB.
pub(super) type Rgb = [u8; 3];

/// A picture. What is painted outside of it is cut off.
pub(super) struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<Rgb>,
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32, background: Rgb) -> Self {
        Self { width, height, pixels: vec![background; width as usize * height as usize] }
    }

    /// Fills a rectangle.
    pub(super) fn fill(&mut self, x: u32, y: u32, width: u32, height: u32, colour: Rgb) {
        let columns = x.min(self.width) as usize..x.saturating_add(width).min(self.width) as usize;
        for row in y.min(self.height)..y.saturating_add(height).min(self.height) {
            let start = row as usize * self.width as usize;
            self.pixels[start + columns.start..start + columns.end].fill(colour);
        }
    }

    /// Draws the border of a rectangle, one pixel wide, inside it.
    pub(super) fn frame(&mut self, x: u32, y: u32, width: u32, height: u32, colour: Rgb) {
        self.fill(x, y, width, 1, colour);
        self.fill(x, y + height - 1, width, 1, colour);
        self.fill(x, y, 1, height, colour);
        self.fill(x + width - 1, y, 1, height, colour);
    }

    /// Writes one line of text in dots of `dot` pixels, its upper left corner at (`x`, `y`).
    pub(super) fn text(&mut self, x: u32, y: u32, text: &str, dot: u32, colour: Rgb) {
        let mut left = x;
        for character in text.chars() {
            for (row, bits) in (0..).zip(font::glyph(character)) {
                for column in
                    (0..font::COLUMNS).filter(|column| bits >> (font::COLUMNS - 1 - column) & 1 == 1)
                {
                    self.fill(left + column * dot, y + row * dot, dot, dot, colour);
                }
            }
            left += (font::COLUMNS + 1) * dot;
        }
    }

    /// The picture as a PNG file.
    pub(super) fn encode(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}
