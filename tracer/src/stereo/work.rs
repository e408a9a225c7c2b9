//! What tracing the right image takes, whole and with what the left one knows.

use super::reprojection::Reprojection;
use crate::error::Error;
use crate::observe::Op;
use crate::trace::{Frame, Tile, TileSource};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Steps of an image's rays that test a node or a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalWork {
    /// Of rays that are the same from wherever their hit is looked at, and of the primary rays.
    pub reusable: u64,
    /// Of these, the ones of pixels that the other image does not answer.
    pub unanswered: u64,
    /// Of rays whose direction depends on that of the view.
    pub view_dependent: u64,
}

impl TraversalWork {
    /// Traces the image of `eye` in parallel; `reprojection` says which of its pixels the other image answers: none, where there is none.
    ///
    /// # Errors
    /// When a tile takes too many steps.
    pub fn of(eye: &impl TileSource, reprojection: Option<&Reprojection>) -> Result<Self, Error> {
        let frame = eye.header().frame;
        let of_tile = |index| {
            let mut tile = Tile::default();
            eye.tile(index, &mut tile)?;
            Ok(Self::of_tile(eye, &tile, |ray| {
                reprojection.is_some_and(|known| known.left_pixel(pixel(frame, index, ray)).is_some())
            }))
        };
        (0..frame.tiles()).into_par_iter().map(of_tile).try_reduce(Self::default, |mut sum, work| {
            sum += work;
            Ok(sum)
        })
    }

    fn of_tile(eye: &impl TileSource, tile: &Tile, answered: impl Fn(u32) -> bool) -> Self {
        let mut work = Self::default();
        for (set, id) in tile.ray_sets.iter().zip(&eye.header().ray_sets) {
            for ray in 0..set.ends.len() {
                let tests = set.steps[set.range(ray)]
                    .iter()
                    .filter(|step| matches!(step.op(), Op::Node | Op::Primitive))
                    .count() as u64;
                if id.kind.depends_on_view() {
                    work.view_dependent += tests;
                    continue;
                }
                work.reusable += tests;
                if !answered(ray as u32) {
                    work.unanswered += tests;
                }
            }
        }
        work
    }

    /// Without reuse.
    pub fn whole(&self) -> u64 {
        self.reusable + self.view_dependent
    }

    /// Where answered pixels trace the view-dependent rays alone. Those start at hits of this image, as if it had been traced, whose surfaces
    /// are those of the other's but for what a pixel is coarse.
    pub fn with_reuse(&self) -> u64 {
        self.unanswered + self.view_dependent
    }
}

impl AddAssign for TraversalWork {
    fn add_assign(&mut self, Self { reusable, unanswered, view_dependent }: Self) {
        self.reusable += reusable;
        self.unanswered += unanswered;
        self.view_dependent += view_dependent;
    }
}

/// The pixel of a tile's ray, in rows of the image.
fn pixel(frame: Frame, tile: u32, ray: u32) -> u32 {
    let rect = frame.tile(tile);
    match frame {
        Frame::Image { width, .. } => (rect.y + ray / rect.width) * width + rect.x + ray % rect.width,
        Frame::List { .. } => rect.x + ray,
    }
}
