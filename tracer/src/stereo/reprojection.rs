//! The left image, as the right eye sees it.

use super::row::{Sample, Source, sources};
use crate::reflections::{GBuffer, Projection};
use crate::view::View;
use rayon::prelude::*;

/// Where each pixel of the right image comes from. Pixels are numbered in rows from the top left.
///
/// Memory: 8 bytes of each pixel, and those of two rows for each thread.
pub struct Reprojection {
    width: u32,
    sources: Vec<Source>,
}

impl Reprojection {
    /// Reprojects what `left` shows into the image of `right`, an eye beside it ([`Eyes`](super::Eyes)), in parallel.
    pub fn new(left: &GBuffer<'_>, right: &View) -> Self {
        let [width, height] = left.size();
        let projection = Projection::new(right);
        let row = |y: u32| {
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
            sources(&(0..width).map(sample).collect::<Vec<_>>())
        };
        let sources = (0..height).into_par_iter().flat_map_iter(row).collect();
        Self { width, sources }
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
