//! An RGB picture in memory, as PNG, and as a surface that plotters draws on.

use super::{Rgb, lettering};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};
use std::convert::Infallible;

/// A picture. What is painted outside of it is cut off.
pub(crate) struct Canvas {
    width: i32,
    height: i32,
    pixels: Vec<Rgb>,
}

impl Canvas {
    pub(crate) fn new(width: i32, height: i32, background: Rgb) -> Self {
        Self { width, height, pixels: vec![background; width as usize * height as usize] }
    }

    /// Fills a rectangle.
    pub(crate) fn fill(&mut self, x: i32, y: i32, width: i32, height: i32, colour: Rgb) {
        let within = |at: i32, end: i32| at.clamp(0, end) as usize;
        let columns = within(x, self.width)..within(x.saturating_add(width), self.width);
        for row in within(y, self.height)..within(y.saturating_add(height), self.height) {
            let start = row * self.width as usize;
            self.pixels[start + columns.start..start + columns.end].fill(colour);
        }
    }

    /// Covers a part of a pixel, 0 to 1.
    fn cover(&mut self, x: i32, y: i32, colour: Rgb, part: f64) {
        if (0..self.width).contains(&x) && (0..self.height).contains(&y) {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            for (old, new) in pixel.iter_mut().zip(colour) {
                let (under, over) = (f64::from(*old), f64::from(new));
                *old = (under + (over - under) * part.clamp(0.0, 1.0)).round() as u8;
            }
        }
    }

    /// The picture as a PNG file.
    pub(crate) fn encode(&self) -> Result<Vec<u8>, png::EncodingError> {
        encode_png(self.width as u32, self.height as u32, &self.pixels)
    }
}

/// Pixels, row by row from the upper left, as a PNG file.
pub(crate) fn encode_png(width: u32, height: u32, pixels: &[Rgb]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Rectangles and text are drawn here; plotters makes the rest of pixels.
impl DrawingBackend for &mut Canvas {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width as u32, self.height as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        self.cover(x, y, colour.rgb.into(), colour.alpha);
        Ok(())
    }

    /// Covers the pixels from `from` up to but not including `to`, as SVG does.
    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        _: bool,
    ) -> Drawn {
        self.fill(from.0, from.1, to.0 - from.0, to.1 - from.1, style.color().rgb.into());
        Ok(())
    }

    /// Places text as the SVG backend does.
    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        let height = style.size() / super::sheet::SIZE_OF_EM;
        let width = lettering::width(text, height.round() as i32);
        let along = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let base = match style.anchor().v_pos {
            VPos::Top => 0.76 * height,
            VPos::Center => 0.27 * height,
            VPos::Bottom => -0.27 * height,
        };
        let base = base.round() as i32;
        let turned = matches!(style.transform(), FontTransform::Rotate270);
        let colour = style.color();
        lettering::draw(text, height, |column, row, cover| {
            let (along, down) = (along + column, base + row);
            let (x, y) = if turned { (x + down, y - along - 1) } else { (x + along, y + down) };
            self.cover(x, y, colour.rgb.into(), f64::from(cover) * colour.alpha);
        });
        Ok(())
    }
}
