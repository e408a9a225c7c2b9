//! The legend of series.

use crate::picture::{Across, Down, INK, Label, MARGIN, Sheet, TEXT, lettering};

/// Least height of a swatch's row.
const SWATCH: i32 = 14;
const GAP: i32 = 6;

/// Adds the names below everything, in rows, each with a swatch before it: `swatch` paints that of an entry from the
/// middle of its left side.
pub(super) fn paint<'a>(
    sheet: &mut Sheet,
    names: impl Iterator<Item = &'a str>,
    swatch_width: i32,
    swatch: impl Fn(&mut Sheet, (i32, i32), usize),
) {
    let indent = swatch_width + GAP;
    let mut x = MARGIN;
    let mut row_height = 0;
    for (index, name) in names.enumerate() {
        let lines = lettering::wrap(name, sheet.width - 2 * MARGIN - indent, TEXT);
        let Some(width) = lines.iter().map(|line| lettering::width(line, TEXT)).max() else {
            continue;
        };
        if x > MARGIN && x + indent + width > sheet.width - MARGIN {
            sheet.height += row_height;
            (x, row_height) = (MARGIN, 0);
        }
        let middle = sheet.height + 1 + SWATCH / 2;
        swatch(sheet, (x, middle), index);
        for (line, text) in (0..).zip(&lines) {
            let at = (x + indent, middle + lettering::line(TEXT) * line);
            let label = Label::new(text.as_str(), at, TEXT, INK);
            sheet.label(label.anchored(Across::Start, Down::Middle));
        }
        x += indent + width + 2 * MARGIN;
        row_height = row_height.max(lettering::line(TEXT) * lines.len() as i32 + GAP);
    }
    sheet.height += row_height;
}
