//! A picture as marks at fixed places, and its two forms.

use super::{BACKGROUND, Canvas, FAINT, INK, MARGIN, Rgb, lettering};
use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{DrawingArea, DrawingBackend, IntoDrawingArea, RGBColor, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, FontTransform, TextStyle};

/// The SVG backend divides the size of a font by this number to get the height of an em in pixels.
pub(super) const SIZE_OF_EM: f64 = 1.24;

/// Which part of a label stands at its place, along the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Across {
    Start,
    Middle,
    End,
}

/// Which part of a label stands at its place, across the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Down {
    Top,
    Middle,
}

/// One line of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Label {
    pub(crate) text: String,
    pub(crate) at: (i32, i32),
    pub(crate) across: Across,
    pub(crate) down: Down,
    /// Height of an em in pixels.
    pub(crate) height: i32,
    pub(crate) colour: Rgb,
    /// Whether the text runs upwards.
    pub(crate) upwards: bool,
}

impl Label {
    /// Text that begins at the top left corner `at`.
    pub(crate) fn new(text: impl Into<String>, at: (i32, i32), height: i32, colour: Rgb) -> Self {
        let (across, down) = (Across::Start, Down::Top);
        // XML has no place for control characters.
        let text = text.into().replace(|character: char| character.is_control(), " ");
        Self { text, at, across, down, height, colour, upwards: false }
    }

    /// The same text with these parts of it at its place.
    pub(crate) fn anchored(self, across: Across, down: Down) -> Self {
        Self { across, down, ..self }
    }

    /// The same text running upwards.
    pub(crate) fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
}

/// What a sheet holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A filled rectangle.
    Fill { at: (i32, i32), size: (i32, i32), colour: Rgb },
    /// A straight line.
    Line { ends: [(i32, i32); 2], width: i32, colour: Rgb },
    /// A filled polygon.
    Area { corners: Vec<(i32, i32)>, colour: Rgb },
    /// A line of text.
    Label(Label),
}

/// A picture before it is drawn; later marks cover earlier ones.
pub(crate) struct Sheet {
    pub(crate) width: i32,
    pub(crate) height: i32,
    /// Height of its text.
    pub(crate) text: i32,
    pub(crate) marks: Vec<Mark>,
}

impl Sheet {
    /// A white sheet whose height grows with its blocks.
    pub(crate) fn new(width: i32, text: i32) -> Self {
        Self { width, height: MARGIN, text, marks: Vec::new() }
    }

    /// Adds a filled rectangle.
    pub(crate) fn fill(&mut self, at: (i32, i32), size: (i32, i32), colour: Rgb) {
        self.marks.push(Mark::Fill { at, size, colour });
    }

    /// Adds a straight line.
    pub(crate) fn line(&mut self, ends: [(i32, i32); 2], width: i32, colour: Rgb) {
        self.marks.push(Mark::Line { ends, width, colour });
    }

    /// Adds a filled polygon.
    pub(crate) fn area(&mut self, corners: Vec<(i32, i32)>, colour: Rgb) {
        self.marks.push(Mark::Area { corners, colour });
    }

    /// Adds the border of a rectangle, one pixel wide, inside it.
    pub(crate) fn frame(&mut self, (x, y): (i32, i32), (width, height): (i32, i32), colour: Rgb) {
        self.fill((x, y), (width, 1), colour);
        self.fill((x, y + height - 1), (width, 1), colour);
        self.fill((x, y), (1, height), colour);
        self.fill((x + width - 1, y), (1, height), colour);
    }

    /// Adds a line of text.
    pub(crate) fn label(&mut self, label: Label) {
        self.marks.push(Mark::Label(label));
    }

    /// Adds text below everything, over the whole width.
    pub(crate) fn paragraph(&mut self, text: &str, height: i32, colour: Rgb) {
        for line in lettering::wrap(text, self.width - 2 * MARGIN, height) {
            self.label(Label::new(line, (MARGIN, self.height), height, colour));
            self.height += lettering::line(height);
        }
    }

    /// Adds the title and the subtitle.
    pub(crate) fn heading(&mut self, title: &str, subtitle: &str) {
        self.paragraph(title, self.text * 10 / 7, INK);
        self.paragraph(subtitle, self.text, FAINT);
    }

    /// The picture as SVG. Text stays text, in the viewer's `sans-serif`.
    pub(crate) fn svg(&self) -> String {
        let mut svg = String::new();
        let backend = SVGBackend::with_string(&mut svg, (self.width as u32, self.height as u32));
        self.draw(&backend.into_drawing_area()).expect("a string takes every mark");
        svg
    }

    /// The picture in pixels.
    pub(crate) fn canvas(&self) -> Canvas {
        let mut canvas = Canvas::new(self.width, self.height, BACKGROUND);
        self.draw(&(&mut canvas).into_drawing_area()).expect("memory takes every mark");
        canvas
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let ink = |[red, green, blue]: Rgb| RGBColor(red, green, blue);
        area.fill(&ink(BACKGROUND))?;
        for mark in &self.marks {
            match mark {
                Mark::Fill { at: (x, y), size: (width, height), colour } => {
                    let corners = [(*x, *y), (x + width, y + height)];
                    area.draw(&Rectangle::new(corners, ink(*colour).filled()))?;
                }
                Mark::Line { ends, width, colour } => {
                    let style = ink(*colour).stroke_width(*width as u32);
                    area.draw(&PathElement::new(ends.to_vec(), style))?;
                }
                Mark::Area { corners, colour } => {
                    area.draw(&Polygon::new(corners.clone(), ink(*colour).filled()))?;
                }
                Mark::Label(label) => {
                    let transform =
                        if label.upwards { FontTransform::Rotate270 } else { FontTransform::None };
                    let size = f64::from(label.height) * SIZE_OF_EM;
                    let font = FontDesc::new(FontFamily::SansSerif, size, FontStyle::Normal);
                    let across = match label.across {
                        Across::Start => HPos::Left,
                        Across::Middle => HPos::Center,
                        Across::End => HPos::Right,
                    };
                    let down = match label.down {
                        Down::Top => VPos::Top,
                        Down::Middle => VPos::Center,
                    };
                    let colour = ink(label.colour);
                    let style =
                        TextStyle::from(font.transform(transform)).color(&colour).pos(Pos::new(across, down));
                    area.draw(&Text::new(label.text.as_str(), label.at, style))?;
                }
            }
        }
        area.present()
    }
}

/// Questions that tests ask of a sheet.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Left, top, right, bottom.
    pub(crate) type Edges = [i32; 4];

    pub(crate) fn edges(label: &Label) -> Edges {
        let (width, height) = (lettering::width(&label.text, label.height), label.height);
        let along = match label.across {
            Across::Start => 0,
            Across::Middle => -width / 2,
            Across::End => -width,
        };
        let down = match label.down {
            Down::Top => 0,
            Down::Middle => -height / 2,
        };
        let (x, y) = label.at;
        if label.upwards {
            [x + down, y - along - width, x + down + height, y - along]
        } else {
            [x + along, y + down, x + along + width, y + down + height]
        }
    }

    pub(crate) fn labels(sheet: &Sheet) -> Vec<&Label> {
        let labels = sheet.marks.iter().filter_map(|mark| match mark {
            Mark::Label(label) => Some(label),
            _ => None,
        });
        labels.collect()
    }

    pub(crate) fn meet(a: Edges, b: Edges) -> bool {
        a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
    }

    /// No label leaves the sheet, none is smaller than 12 pixels, and no two meet.
    pub(crate) fn assert_legible(sheet: &Sheet) {
        let labels = labels(sheet);
        for (index, label) in labels.iter().enumerate() {
            let [left, top, right, bottom] = edges(label);
            assert!(label.height >= 12, "{label:?} is too small");
            assert!(
                left >= 0 && top >= 0 && right <= sheet.width && bottom <= sheet.height,
                "{label:?} is clipped by {} x {}",
                sheet.width,
                sheet.height
            );
            for other in &labels[..index] {
                assert!(!meet(edges(label), edges(other)), "{label:?} meets {other:?}");
            }
        }
    }

    #[test]
    fn labels_that_meet_or_leave_the_sheet_are_found() {
        let sheet = |labels: &[Label]| {
            let marks = labels.iter().cloned().map(Mark::Label).collect();
            Sheet { width: 100, height: 40, text: 14, marks }
        };
        let word = |x, y| Label::new("word", (x, y), 12, INK);
        let legible = |labels: &[Label]| {
            let sheet = sheet(labels);
            std::panic::catch_unwind(|| assert_legible(&sheet)).is_ok()
        };
        let width = lettering::width("word", 12);
        assert!(legible(&[word(0, 0), word(0, 12), word(width, 0), word(100 - width, 28)]));
        assert!(!legible(&[word(0, 0), word(0, 11)]));
        assert!(!legible(&[word(0, 0), word(width - 1, 0)]));
        assert!(!legible(&[word(101 - width, 0)]));
        assert!(!legible(&[word(0, 29)]));
        assert!(!legible(&[word(0, 10).upwards()]));
    }

    #[test]
    fn marks_stand_at_their_places_in_both_forms() {
        let mut sheet = Sheet::new(60, 14);
        sheet.height = 50;
        sheet.fill((10, 20), (5, 3), [200, 0, 0]);
        sheet.label(Label::new("<&>", (30, 30), 12, INK));
        let svg = sheet.svg();
        assert!(
            svg.contains(r##"<rect x="10" y="20" width="5" height="3" opacity="1" fill="#C80000""##),
            "{svg}"
        );
        assert!(svg.contains("&lt;&amp;&gt;") && svg.contains(r#"font-family="sans-serif""#), "{svg}");
        let mut expected = Canvas::new(60, 50, BACKGROUND);
        expected.fill(10, 20, 5, 3, [200, 0, 0]);
        let bytes = |canvas: &Canvas| canvas.encode().expect("a small picture");
        sheet.marks.pop();
        assert_eq!(bytes(&sheet.canvas()), bytes(&expected));
    }
}
