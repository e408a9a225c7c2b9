//! What a rasteriser does with a scene, as whole numbers per tile of 32x32 pixels.
//!
//! The hybrid technique of Sousa et al. 2019 rasterises the geometry into normals and depths and casts only shadow rays. Its
//! first pass costs what is counted here: which triangles each tile lists, how many fragments they cover, and how many of those
//! an early depth test lets through to be shaded and written.
//!
//! * **Camera.** That of the primary rays: a pixel's sample is the point of the pixel plane that its ray goes through. There is no
//!   near plane but the eye itself, where the rays begin.
//! * **Order.** Triangles are drawn in file order, front and back faces alike: the paper neither sorts nor culls.
//! * **Coverage.** Edge functions in f64, without clipping ([`setup`]), with the top-left rule. A GPU first snaps vertices to a grid,
//!   commonly of 1/256 pixel, so it moves edges by less than that and drops some slivers; here nothing moves.
//! * **Depth.** 1/w, linear over the image, rounded to f32; a fragment passes where it is strictly nearer than what was drawn
//!   before (LESS). So of two triangles in one place the first remains, as with rays.

mod bin;
mod coverage;
mod setup;

use crate::trace::Frame;
use crate::view::View;
use bin::Bins;
use coverage::TilePixels;
use scenes::Triangle;
use setup::{Projection, ScreenTriangle};

/// What drawing one triangle does in one tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileDraw {
    /// The triangle, in file order.
    pub triangle: u32,
    /// Fragments: pixels whose sample lies inside. May be 0: a triangle is listed where it overlaps the tile's area.
    pub covered: u32,
    /// Fragments that passed the depth test when they were drawn; these are shaded and written.
    pub passed: u32,
    /// Aligned squares of 2x2 pixels with at least one fragment that passed: what is shaded with helper lanes.
    pub quads: u32,
}

/// A tile after drawing. Its memory is reused from tile to tile.
#[derive(Clone, Debug, Default)]
pub struct RasterTile {
    /// The triangles whose projection overlaps the tile, in file order.
    pub draws: Vec<TileDraw>,
    pixels: TilePixels,
    candidates: Vec<u32>,
}

impl RasterTile {
    /// Per pixel of the tile, in rows, the triangle that remains visible, or [`NO_HIT`](crate::NO_HIT).
    pub fn visible(&self) -> &[u32] {
        self.pixels.visible()
    }
}

/// The triangles of a scene, binned for a view; draws tiles in any order, from any thread.
///
/// A pixel's sample is where its primary ray goes; triangles are drawn in file order, from either side, with the top-left rule
/// and a depth test that lets only nearer fragments pass. Nothing is cut off but what lies behind the eye.
///
/// Memory: 4 to 64 bytes per triangle in view, whatever its size, and 8 bytes per tile and a third; five times that while it is built.
pub struct Raster<'a> {
    triangles: &'a [Triangle],
    projection: Projection,
    frame: Frame,
    bins: Bins,
}

impl<'a> Raster<'a> {
    /// Bins `triangles` for an image of `width` x `height` pixels, on all threads; the result does not depend on their number.
    pub fn new(triangles: &'a [Triangle], view: &View, width: u32, height: u32) -> Self {
        let projection = Projection::new(view, width, height);
        let bins = Bins::new(triangles, &projection, width, height);
        Self { triangles, projection, frame: Frame::Image { width, height }, bins }
    }

    /// Draws tile `index`, numbered as by [`Frame::tile`].
    pub fn tile(&self, index: u32, tile: &mut RasterTile) {
        let rect = self.frame.tile(index);
        let RasterTile { draws, pixels, candidates } = tile;
        draws.clear();
        pixels.clear(rect);
        self.bins.candidates(rect, candidates);
        for &triangle in &*candidates {
            let corners = self.projection.corners(&self.triangles[triangle as usize]);
            let screen = ScreenTriangle::new(corners, &self.projection);
            if let Some(screen) = screen.filter(|screen| screen.overlaps(rect)) {
                draws.push(pixels.draw(triangle, &screen));
            }
        }
    }
}
