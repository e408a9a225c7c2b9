//! The left image, as the right eye sees it.

use super::row::{Sample, Source, sources};
use crate::reflections::{GBuffer, Projection};
use crate::view::View;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Where each pixel of the right image comes from. Pixels are numbered in rows from the top left.
///
/// Memory: 12 bytes of each pixel, and while it is made 12 more.
pub struct Reprojection {
    width: u32,
    sources: Vec<Source>,
    columns: Vec<f32>,
    shifts: RangeInclusive<i32>,
}

/// What becomes of a row.
struct Row {
    sources: Vec<Source>,
    columns: Vec<f32>,
    shifts: (i32, i32),
}

/// Of no pixel that lands in the image.
const NO_SHIFTS: (i32, i32) = (i32::MAX, i32::MIN);

impl Reprojection {
    /// Reprojects what `left` shows into the image of `right`, an eye beside it ([`Eyes`](super::Eyes)), in parallel.
    pub fn new(left: &GBuffer<'_>, right: &View) -> Self {
        let [width, height] = left.size();
        let projection = Projection::new(right);
        let of_row = |y: u32| {
            let sample = |x: u32| {
                let (pixel, inverse_depth) = match left.position(y * width + x) {
                    Some(position) => {
                        let pixel = projection.point(position);
                        (pixel, 1.0 / pixel.z)
                    }
                    None => (projection.direction(left.incoming(y * width + x)), 0.0),
                };
                Sample { x: projection.pixel(pixel).x, inverse_depth }
            };
            let samples: Vec<Sample> = (0..width).map(sample).collect();
            let columns: Vec<f32> = samples.iter().map(|sample| sample.x as f32).collect();
            Row { sources: sources(&samples), columns, shifts: shifts(&samples) }
        };
        let rows: Vec<Row> = (0..height).into_par_iter().map(of_row).collect();
        let mut sources = Vec::with_capacity(width as usize * height as usize);
        let mut columns = Vec::with_capacity(sources.capacity());
        let (mut low, mut high) = NO_SHIFTS;
        for row in rows {
            sources.extend(row.sources);
            columns.extend(row.columns);
            (low, high) = (low.min(row.shifts.0), high.max(row.shifts.1));
        }
        Self { width, sources, columns, shifts: low..=high }
    }

    /// By pixel.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// The pixel of the left image that a pixel of the right one shows; `None` where that has to be traced.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn left_pixel(&self, pixel: u32) -> Option<u32> {
        match self.sources[pixel as usize] {
            Source::Left(column) => Some(pixel - pixel % self.width + column),
            Source::Missing | Source::Covered => None,
        }
    }

    /// By pixel of the left image: in which column of the right one its point is, in pixels from the left edge, which may be beyond either edge.
    pub fn columns(&self) -> &[f32] {
        &self.columns
    }

    /// By how many columns pixels are shifted from the left image to the right one, those that land in it; empty where none does.
    pub fn shifts(&self) -> RangeInclusive<i32> {
        self.shifts.clone()
    }

    /// Pixels per row, and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.sources.len() as u32 / self.width]
    }

    /// Pixels that come from the left image, that nothing lands in, and that are covered.
    pub fn counts(&self) -> [u64; 3] {
        self.sources.iter().fold([0; 3], |mut counts, source| {
            counts[match source {
                Source::Left(_) => 0,
                Source::Missing => 1,
                Source::Covered => 2,
            }] += 1;
            counts
        })
    }
}

fn shifts(samples: &[Sample]) -> (i32, i32) {
    let inside = (0..).zip(samples).filter(|(_, sample)| sample.x >= 0.0 && sample.x < samples.len() as f64);
    inside.fold(NO_SHIFTS, |(low, high), (column, sample)| {
        let shift = sample.x as i32 - column;
        (low.min(shift), high.max(shift))
    })
}
