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

    /// Draws a straight line: a pixel is covered by as much as its middle is near.
    fn line(&mut self, [from, to]: [(i32, i32); 2], width: f64, colour: Rgb) {
        let reach = width.ceil() as i32;
        let [along_x, along_y] = [to.0 - from.0, to.1 - from.1].map(f64::from);
        let length = along_x.hypot(along_y).max(f64::MIN_POSITIVE);
        for y in from.1.min(to.1) - reach..from.1.max(to.1) + reach {
            for x in from.0.min(to.0) - reach..from.0.max(to.0) + reach {
                let [dx, dy] = [x - from.0, y - from.1].map(|offset| f64::from(offset) + 0.5);
                let past = (dx * along_x + dy * along_y) / length;
                let beyond = (-past).max(past - length);
                let beside = (dx * along_y - dy * along_x).abs() / length;
                let part = |excess: f64| (0.5 - excess).clamp(0.0, 1.0);
                self.cover(x, y, colour, part(beside - width / 2.0) * part(beyond));
            }
        }
    }

    /// Fills a polygon: a pixel is covered by as many of its 16 samples as lie inside.
    fn area(&mut self, corners: &[(i32, i32)], colour: Rgb) {
        let range = |axis: fn(&(i32, i32)) -> i32| {
            let (low, high) = (corners.iter().map(axis).min(), corners.iter().map(axis).max());
            low.unwrap_or(0)..high.unwrap_or(0)
        };
        let inside = |x: f64, y: f64| {
            let sides = corners.iter().zip(corners.iter().cycle().skip(1));
            let crossed = sides.filter(|&(&from, &to)| {
                let [x0, y0, x1, y1] = [from.0, from.1, to.0, to.1].map(f64::from);
                (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
            });
            crossed.count() % 2 == 1
        };
        let samples = [0.125, 0.375, 0.625, 0.875];
        for y in range(|corner| corner.1) {
            for x in range(|corner| corner.0) {
                let at = |down: f64| samples.map(|along| (f64::from(x) + along, f64::from(y) + down));
                let count = samples.iter().flat_map(|&down| at(down)).filter(|&(x, y)| inside(x, y)).count();
                self.cover(x, y, colour, count as f64 / 16.0);
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
    // Pictures of a frame at the usual level would take as long as a tenth of its replay.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Rectangles, lines, polygons and text are drawn here; plotters makes the rest of pixels.
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

    /// Straight lines of the style's width, from corner to corner.
    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let corners: Vec<BackendCoord> = path.into_iter().collect();
        for pair in corners.windows(2) {
            self.line([pair[0], pair[1]], f64::from(style.stroke_width()), style.color().rgb.into());
        }
        Ok(())
    }

    /// Fills a polygon.
    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Drawn {
        let corners: Vec<BackendCoord> = corners.into_iter().collect();
        self.area(&corners, style.color().rgb.into());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::BACKGROUND;

    const BLACK: Rgb = [0, 0, 0];

    /// Ink of a picture of 20 x 20 pixels, in whole pixels.
    fn ink(paint: impl Fn(&mut Canvas)) -> f64 {
        let mut canvas = Canvas::new(20, 20, BACKGROUND);
        paint(&mut canvas);
        canvas.pixels.iter().map(|pixel| 1.0 - f64::from(pixel[0]) / 255.0).sum()
    }

    #[test]
    fn lines_and_polygons_have_the_ink_of_their_surface() {
        let close =
            |found: f64, expected: f64| assert!((found - expected).abs() < 0.7, "{found}, not {expected}");
        close(ink(|canvas| canvas.line([(4, 10), (14, 10)], 2.0, BLACK)), 20.0);
        close(ink(|canvas| canvas.line([(4, 4), (10, 12)], 2.0, BLACK)), 20.0);
        close(ink(|canvas| canvas.area(&[(5, 5), (15, 5), (15, 15), (5, 15)], BLACK)), 100.0);
        close(ink(|canvas| canvas.area(&[(10, 4), (16, 10), (10, 16), (4, 10)], BLACK)), 72.0);
        assert_eq!(ink(|canvas| canvas.area(&[], BLACK)), 0.0);
    }
}
