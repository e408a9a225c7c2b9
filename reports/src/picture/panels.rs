//! Maps of pixels in rows and columns, with lines of text below each.

use super::sheet::{Across, Down, Label, Sheet};
use super::{MARGIN, Rgb, TEXT, lettering};
use std::ops::Range;

/// Longer side of a single map in pixels: smaller ones are enlarged by the whole factor that reaches it.
pub(crate) const LEAST_SIDE: u32 = 512;
/// Longer side of each of several maps: larger ones are reduced by a whole factor, smaller ones enlarged.
const PANEL_SIDE: u32 = 512;

/// Pixels of a map for a square of its values: at least one of the two is 1.
#[derive(Clone, Copy)]
pub(crate) struct Zoom {
    /// Side in pixels of a value.
    pub(crate) enlarge: u32,
    /// Side in values of a pixel.
    pub(crate) reduce: u32,
}

impl Zoom {
    /// Of a map that is alone; it is never reduced.
    pub(crate) fn of_single(size: [u32; 2]) -> Self {
        Self { enlarge: LEAST_SIDE.div_ceil(size[0].max(size[1])), reduce: 1 }
    }

    /// Of maps side by side.
    pub(crate) fn of_several(size: [u32; 2]) -> Self {
        let side = size[0].max(size[1]);
        Self { enlarge: (PANEL_SIDE / side).max(1), reduce: side.div_ceil(PANEL_SIDE) }
    }

    /// Pixels across and down of so many values.
    pub(crate) fn pixels(self, size: [u32; 2]) -> [i32; 2] {
        size.map(|side| (side.div_ceil(self.reduce) * self.enlarge) as i32)
    }

    /// Shows `paint` every square of values: where in the map its pixels begin, their side, and the places of the values, row by row.
    pub(crate) fn squares(
        self,
        [width, height]: [u32; 2],
        mut paint: impl FnMut((i32, i32), i32, &mut dyn Iterator<Item = usize>),
    ) {
        let Self { enlarge, reduce } = self;
        let values = |step: u32, side: u32| -> Range<u32> { step * reduce..side.min((step + 1) * reduce) };
        for row in 0..height.div_ceil(reduce) {
            for column in 0..width.div_ceil(reduce) {
                let columns = values(column, width);
                let at = |row: u32| {
                    let start = row as usize * width as usize;
                    start + columns.start as usize..start + columns.end as usize
                };
                let corner = ((column * enlarge) as i32, (row * enlarge) as i32);
                paint(corner, enlarge as i32, &mut values(row, height).flat_map(at));
            }
        }
    }
}

/// Height of text in a picture of so many columns: a wide page is looked at from further away.
pub(crate) fn text_height(columns: usize) -> i32 {
    TEXT * columns.clamp(2, 4) as i32 / 2
}

/// Where maps of one size stand.
pub(crate) struct PanelGrid {
    /// Of each map, in pixels.
    pub(crate) size: [i32; 2],
    pub(crate) columns: usize,
    /// Height of the text.
    pub(crate) text: i32,
    /// Of each map, the lines below it.
    pub(crate) below: Vec<Vec<(String, Rgb)>>,
}

impl PanelGrid {
    /// Breaks a text into lines that are as wide as a map.
    pub(crate) fn lines(text: &str, width: i32, height: i32, colour: Rgb) -> Vec<(String, Rgb)> {
        lettering::wrap(text, width, height).into_iter().map(|line| (line, colour)).collect()
    }

    pub(crate) fn width(&self) -> i32 {
        self.columns as i32 * (self.size[0] + MARGIN) - MARGIN
    }

    pub(crate) fn height(&self) -> i32 {
        let rows = self.row_heights();
        rows.iter().sum::<i32>() + (rows.len() as i32 - 1) * MARGIN
    }

    fn row_heights(&self) -> Vec<i32> {
        let of_row = |row: &[Vec<_>]| {
            let lines = row.iter().map(Vec::len).max().unwrap_or(0);
            self.size[1] + lines as i32 * lettering::line(self.text)
        };
        self.below.chunks(self.columns).map(of_row).collect()
    }

    /// Adds the text, from (`left`, `top`) on, and answers the top left corners of the maps.
    pub(crate) fn place(&self, sheet: &mut Sheet, left: i32, top: i32) -> Vec<(i32, i32)> {
        let [width, height] = self.size;
        let line_height = lettering::line(self.text);
        let mut y = top;
        let mut corners = Vec::new();
        for (row, row_height) in self.below.chunks(self.columns).zip(self.row_heights()) {
            for (column, lines) in (0..).zip(row) {
                let x = left + column * (width + MARGIN);
                corners.push((x, y));
                for (line, (words, colour)) in (0..).zip(lines) {
                    let middle = y + height + line_height * line + line_height / 2 + 2;
                    let label = Label::new(words.as_str(), (x, middle), self.text, *colour);
                    sheet.label(label.anchored(Across::Start, Down::Middle));
                }
            }
            y += row_height + MARGIN;
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_square() {
        for (size, zoom) in [([7, 5], (1, 1)), ([7, 5], (3, 1)), ([7, 5], (1, 2)), ([1, 9], (1, 4))] {
            let zoom = Zoom { enlarge: zoom.0, reduce: zoom.1 };
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            let mut corners = Vec::new();
            zoom.squares(size, |corner, side, values| {
                values.for_each(|place| seen[place] += 1);
                let [width, height] = zoom.pixels(size);
                assert!(corner.0 + side <= width && corner.1 + side <= height);
                corners.push(corner);
            });
            assert!(seen.iter().all(|&times| times == 1), "{size:?}");
            corners.dedup();
            assert_eq!(corners.len() as u32, size[0].div_ceil(zoom.reduce) * size[1].div_ceil(zoom.reduce));
        }
    }
}
