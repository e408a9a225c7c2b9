//! The legend of colours.

use super::sheet::{Across, Down, Label, Sheet};
use super::{INK, MARGIN, lettering};

/// Least height of a swatch's row.
const SWATCH: i32 = 14;
const GAP: i32 = 6;

/// Adds the names below everything, in rows, each with a swatch before it: `swatch` paints that of an entry from the
/// middle of its left side.
pub(crate) fn paint<'a>(
    sheet: &mut Sheet,
    names: impl Iterator<Item = &'a str>,
    swatch_width: i32,
    swatch: impl Fn(&mut Sheet, (i32, i32), usize),
) {
    let text = sheet.text;
    let row = SWATCH.max(text);
    let indent = swatch_width + GAP;
    let mut x = MARGIN;
    let mut row_height = 0;
    for (index, name) in names.enumerate() {
        let lines = lettering::wrap(name, sheet.width - 2 * MARGIN - indent, text);
        let Some(width) = lines.iter().map(|line| lettering::width(line, text)).max() else {
            continue;
        };
        if x > MARGIN && x + indent + width > sheet.width - MARGIN {
            sheet.height += row_height;
            (x, row_height) = (MARGIN, 0);
        }
        let middle = sheet.height + 1 + row / 2;
        swatch(sheet, (x, middle), index);
        for (line, words) in (0..).zip(&lines) {
            let at = (x + indent, middle + lettering::line(text) * line);
            let label = Label::new(words.as_str(), at, text, INK);
            sheet.label(label.anchored(Across::Start, Down::Middle));
        }
        x += indent + width + 2 * MARGIN;
        row_height = row_height.max(lettering::line(text) * lines.len() as i32 + GAP);
    }
    sheet.height += row_height;
}
