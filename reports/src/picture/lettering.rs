//! Text in DejaVu Sans, which the program carries: how wide it is, how it fills lines, and its pixels.
//!
//! Few sans-serif fonts are wider, so text that fits by this measure fits with what a browser takes for `sans-serif` too.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use std::sync::LazyLock;

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(dejavu::sans::regular()).expect("the embedded font is whole"));

/// The scale at which an em, the unit of text heights, is `height` pixels.
fn scale(height: f64) -> PxScale {
    let em = FONT.units_per_em().expect("the embedded font says how large an em is");
    PxScale::from(height as f32 * FONT.height_unscaled() / em)
}

/// Pixels from one line of text to the next.
pub(crate) fn line(height: i32) -> i32 {
    height + height / 3
}

/// Width of `text` in pixels, rounded up.
pub(crate) fn width(text: &str, height: i32) -> i32 {
    let font = FONT.as_scaled(scale(f64::from(height)));
    let width: f32 = text.chars().map(|character| font.h_advance(font.glyph_id(character))).sum();
    width.ceil() as i32
}

/// Breaks `text` at spaces into lines of at most `pixels`; a longer word is broken where it must be.
pub(crate) fn wrap(text: &str, pixels: i32, height: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if width(&longer, height) <= pixels {
                *line = longer;
                continue;
            }
        }
        let mut piece = String::new();
        for character in word.chars() {
            piece.push(character);
            if width(&piece, height) > pixels && piece.chars().count() > 1 {
                piece.pop();
                lines.push(std::mem::replace(&mut piece, character.to_string()));
            }
        }
        lines.push(piece);
    }
    lines
}

/// Calls `paint` with the place of each pixel of `text`, from the start of its base line, and how much of it is covered.
pub(crate) fn draw(text: &str, height: f64, mut paint: impl FnMut(i32, i32, f32)) {
    let font = FONT.as_scaled(scale(height));
    let mut x = 0.0;
    for character in text.chars() {
        let id = font.glyph_id(character);
        if let Some(outline) = font.outline_glyph(id.with_scale_and_position(font.scale(), point(x, 0.0))) {
            let corner = outline.px_bounds().min;
            outline.draw(|column, row, cover| {
                paint(corner.x as i32 + column as i32, corner.y as i32 + row as i32, cover);
            });
        }
        x += font.h_advance(id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_full_but_never_too_long() {
        let pixels = width("twelve chars", 14);
        assert_eq!(wrap("twelve chars and more", pixels, 14), ["twelve chars", "and more"]);
        assert_eq!(wrap("twelve chars and more", pixels - 1, 14), ["twelve", "chars and", "more"]);
        assert_eq!(wrap("abcdefghijklmnop q", width("abcdefghij", 14), 14), ["abcdefghij", "klmnop q"]);
        assert_eq!(wrap("", 100, 14), Vec::<String>::new());
        assert_eq!(wrap("ab", 0, 14), ["a", "b"]);
    }

    #[test]
    fn the_pixels_of_a_text_stay_within_its_width_and_height() {
        let text = "Mjqgf|0%\u{e9}";
        let (mut covered, mut last) = (0.0, 0);
        draw(text, 14.0, |x, y, cover| {
            assert!((-1..=width(text, 14)).contains(&x) && (-14..6).contains(&y), "({x}, {y})");
            covered += cover;
            last = last.max(x);
        });
        assert!(covered > 200.0, "{covered} pixels of ink");
        assert!(last > width(text, 14) - 5);
    }
}
