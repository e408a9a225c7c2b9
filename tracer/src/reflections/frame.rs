//! What becomes of each pixel's reflection ray.

use super::gbuffer::GBuffer;
use super::march::{March, MarchEnd};
use super::pyramid::DepthPyramid;
use super::screen_ray::ScreenRay;
use crate::ray::Ray;
use crate::secondary::{ReflectionRays, reflection_points};
use crate::trace::TILE_EDGE;
use rayon::prelude::*;

/// Which reflections a frame has, and where they come from.
#[derive(Clone, Copy, Debug)]
pub struct ReflectionSettings<'a> {
    /// The reflection rays of each triangle; of glossy ones, the first sample is taken.
    pub surfaces: &'a [ReflectionRays],
    /// Start of the random sequence, as in [`SecondaryRays`](crate::SecondaryRays).
    pub seed: u32,
    /// How the screen is searched; `None` leaves all rays to ray queries.
    pub march: Option<March>,
    /// Where ray queries start.
    pub origin: QueryOrigin,
}

/// Where the query of a ray starts that the screen has no answer for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryOrigin {
    /// At the surface.
    Surface,
    /// Where the march has shown the ray to be free ("last visited SSR position", Calvo Lista 2026): [`MarchEnd::Miss`]. Between the eye and
    /// what a pixel shows is nothing, so a ray before the surfaces of all pixels has met none, seen or hidden; only what the screen is too
    /// coarse for, between the middles of pixels, can be passed over.
    LastFree,
}

/// What becomes of a pixel's reflection ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The pixel shows no surface.
    Sky,
    /// Its surface is too rough for a ray.
    Fallback,
    /// The screen shows what the ray meets.
    ScreenHit {
        /// The pixel that shows it.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// A ray query has to find it.
    Query,
}

/// A ray to query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectionRay {
    /// Whose, in rows from the top left.
    pub pixel: u32,
    /// From the pixel's surface; its `t_min` is where the query starts.
    pub ray: Ray,
}

/// The reflections of a frame, one ray per pixel: the first sample of those that [`SecondaryRays`](crate::SecondaryRays) casts.
///
/// Memory: 12 bytes per pixel and 36 per query, twice that while it is built. Marches are not kept; [`Self::march`] goes the same way again.
pub struct Reflections<'a> {
    size: [u32; 2],
    /// What is marched through; none where all is left to ray queries that were recorded.
    screen: Option<Screen<'a>>,
    outcomes: Vec<Outcome>,
    rays: Vec<ReflectionRay>,
    /// By pixel, texels that its march reads.
    texels: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Screen<'a> {
    gbuffer: &'a GBuffer<'a>,
    settings: ReflectionSettings<'a>,
}

impl<'a> Reflections<'a> {
    /// Marches all rays, in parallel.
    pub fn new(gbuffer: &'a GBuffer<'a>, settings: ReflectionSettings<'a>) -> Self {
        let screen = Screen { gbuffer, settings };
        let size = gbuffer.size();
        let mut reflections =
            Self { size, screen: Some(screen), outcomes: Vec::new(), rays: Vec::new(), texels: Vec::new() };
        let pixels = gbuffer.pixels();
        let band = size[0].max(1).saturating_mul(TILE_EDGE);
        let bands: Vec<_> = (0..pixels.div_ceil(band))
            .into_par_iter()
            .map(|index| screen.band(index * band..pixels.min((index + 1).saturating_mul(band))))
            .collect();
        for Band { outcomes, rays, texels } in bands {
            reflections.outcomes.extend(outcomes);
            reflections.rays.extend(rays);
            reflections.texels.extend(texels);
        }
        reflections
    }

    /// Rays that were recorded, in the order of their pixels, none of which was looked up on the screen.
    pub(super) fn recorded(size: [u32; 2], outcomes: Vec<Outcome>, rays: Vec<ReflectionRay>) -> Self {
        let texels = vec![0; outcomes.len()];
        Self { size, screen: None, outcomes, rays, texels }
    }

    /// Pixels per row, and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What is marched through; `None` for [`RecordedReflections`](super::RecordedReflections).
    pub fn depth(&self) -> Option<&DepthPyramid> {
        self.screen.map(|screen| screen.gbuffer.depth())
    }

    /// What becomes of each pixel's ray, in rows: the coverage of the technique.
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// How many texels of the depths each pixel's march reads, in rows.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// The rays to query, in the order of their pixels.
    pub fn rays(&self) -> &[ReflectionRay] {
        &self.rays
    }

    /// A pixel's reflection ray, from its surface; none in the sky, from rough surfaces, and where rays were recorded.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn ray(&self, pixel: u32) -> Option<Ray> {
        self.screen?.ray(pixel)
    }

    /// The march of a pixel's ray; none where there is no ray, or no march in this frame. `observer` sees the level, `x` and `y` of every texel
    /// of the depths that it reads, in order. Where the ray is behind a texel's surface by little, its normal is read as well.
    ///
    /// # Panics
    /// When there is no such pixel.
    pub fn march(&self, pixel: u32, observer: impl FnMut(u32, u32, u32)) -> Option<MarchEnd> {
        self.screen?.march(pixel, observer)
    }
}

impl Screen<'_> {
    fn band(&self, pixels: std::ops::Range<u32>) -> Band {
        let mut band = Band::default();
        for pixel in pixels {
            let mut texels = 0;
            let (outcome, ray) = self.outcome_and_query(pixel, &mut texels);
            band.outcomes.push(outcome);
            band.rays.extend(ray.map(|ray| ReflectionRay { pixel, ray }));
            band.texels.push(texels);
        }
        band
    }

    fn outcome_and_query(&self, pixel: u32, texels: &mut u32) -> (Outcome, Option<Ray>) {
        if self.gbuffer.triangle(pixel).is_none() {
            return (Outcome::Sky, None);
        }
        let Some(ray) = self.ray(pixel) else { return (Outcome::Fallback, None) };
        match self.march(pixel, |_, _, _| *texels += 1) {
            Some(MarchEnd::Hit { x, y }) => (Outcome::ScreenHit { x, y }, None),
            Some(MarchEnd::Miss { t }) if self.settings.origin == QueryOrigin::LastFree => {
                (Outcome::Query, Some(Ray { t_min: t, ..ray }))
            }
            Some(MarchEnd::Miss { .. }) | None => (Outcome::Query, Some(ray)),
        }
    }

    fn ray(&self, pixel: u32) -> Option<Ray> {
        let surface = self.settings.surfaces[self.gbuffer.triangle(pixel)? as usize];
        let from = self.gbuffer.departure(pixel)?;
        let points = reflection_points(self.settings.seed, u64::from(pixel));
        let direction = surface.direction(0, self.gbuffer.incoming(pixel), from.normal, &points)?;
        Some(from.ray(direction))
    }

    fn march(&self, pixel: u32, observer: impl FnMut(u32, u32, u32)) -> Option<MarchEnd> {
        let march = self.settings.march?;
        let ray = self.ray(pixel)?;
        let depth = self.gbuffer.depth();
        // Nothing is nearer than what the screen shows: a near plane that needs no choice.
        let on_screen = ScreenRay::new(self.gbuffer.projection(), &ray, self.gbuffer.size(), depth.nearest());
        let faces = |pixel| self.gbuffer.faces(pixel, &ray);
        Some(march.follow(on_screen.as_ref(), depth, faces, observer))
    }
}

/// Some rows of an image.
#[derive(Default)]
struct Band {
    outcomes: Vec<Outcome>,
    rays: Vec<ReflectionRay>,
    texels: Vec<u32>,
}
