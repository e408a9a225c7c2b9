//! Following a ray through a depth buffer.

use super::pyramid::DepthPyramid;
use super::screen_ray::ScreenRay;
use super::{hierarchical, linear};

/// How a ray is followed.
///
/// Both ways end at the first texel where the ray is behind a surface: with a hit if it is behind by little enough, and with a miss if by
/// more, as nothing is known there. (McGuire & Mara go on behind it, which gains nothing where a ray query decides what is there.) A surface
/// that turns away and that the ray is behind by little is no hit (AMD's FidelityFX SSSR drops such hits, too): the ray leaves it, or is about
/// to come out from behind it. It is passed, and nothing beyond it counts as free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum March {
    /// Texel by texel along the line on the screen: McGuire & Mara, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4), 2014.
    Linear {
        /// Pixels from one texel that is read to the next, from 1. Texels between are read where the ray is behind a surface for the first
        /// time, by bisection, to find the first of them.
        stride: u32,
        /// Its limits.
        bounds: MarchBounds,
    },
    /// Cell by cell through a pyramid of least depths, to larger cells in empty space and to smaller ones where the ray may be behind a
    /// surface: Uludag, "Hi-Z Screen-Space Cone-Traced Reflections", GPU Pro 5, 2014. It starts with pixels, as FidelityFX SSSR does.
    Hierarchical {
        /// Its limits.
        bounds: MarchBounds,
    },
}

/// Limits of a march.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchBounds {
    /// How thick surfaces are, along the view, as a share of their depth. A ray that enters a texel behind its surface hits it up to that far
    /// behind; one that enters before it and leaves behind it hits it in any case.
    pub thickness: f32,
    /// Most texels that are read, from 1.
    pub texels: u32,
}

impl March {
    /// How thick surfaces are by default: our own choice, as sources give lengths in units of their scenes. With twice as much, 50 % instead of
    /// 46 % of the Crytek Sponza's mirror rays end on the screen (512x512), and 7.6 % instead of 4.5 % of those hits lie farther from what a
    /// ray hits than 3 % of its distance to the eye.
    pub const THICKNESS: f32 = 0.01;

    /// A linear march of single pixels, as many as the longest row of an image of 2048 pixels: our own choice, as sources leave it to the user.
    pub const LINEAR: Self =
        Self::Linear { stride: 1, bounds: MarchBounds { thickness: Self::THICKNESS, texels: 2048 } };

    /// A hierarchical march with as many texels as AMD's FidelityFX SSSR has by default.
    pub const HIERARCHICAL: Self =
        Self::Hierarchical { bounds: MarchBounds { thickness: Self::THICKNESS, texels: 128 } };
}

/// How a march ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarchEnd {
    /// At a surface that the screen shows.
    Hit {
        /// Its pixel.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// Without.
    Miss {
        /// Up to this parameter the ray is before the depths of all texels that it passed: a pixel before the end of that part, as a texel knows
        /// the depth of its middle alone. With a stride above 1 only texels that were read count, and surfaces as narrow as the stride can
        /// be passed over.
        t: f32,
    },
}

impl March {
    /// Follows `ray` before what `depth` shows. `faces` tells of a pixel whether its surface faces the ray; `observer` sees the level, `x` and
    /// `y` of each texel that is read.
    pub(super) fn follow(
        self,
        ray: Option<&ScreenRay>,
        depth: &DepthPyramid,
        faces: impl Fn([u32; 2]) -> bool,
        observer: impl FnMut(u32, u32, u32),
    ) -> MarchEnd {
        let Some(ray) = ray else { return MarchEnd::Miss { t: 0.0 } };
        let follower = |MarchBounds { thickness, texels }: MarchBounds| Follower {
            ray,
            depth,
            faces,
            observer,
            thickness: f64::from(thickness),
            texels,
            free: 0.0,
            all_free: true,
        };
        match self {
            Self::Linear { stride, bounds } => linear::follow(&mut follower(bounds), stride),
            Self::Hierarchical { bounds } => hierarchical::follow(&mut follower(bounds)),
        }
    }
}

/// A march under way.
pub(super) struct Follower<'a, F, O> {
    pub(super) ray: &'a ScreenRay,
    pub(super) depth: &'a DepthPyramid,
    faces: F,
    observer: O,
    thickness: f64,
    /// How many may still be read.
    texels: u32,
    /// Until where the ray is free.
    free: f64,
    /// Whether it was, all the way to here.
    all_free: bool,
}

/// What a texel says of the part of a ray that passes it.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Verdict {
    /// It is before its surface, or behind one that turns away.
    Passed,
    /// It meets its surface.
    Hit,
    /// It is far behind it.
    Behind,
}

impl<F: Fn([u32; 2]) -> bool, O: FnMut(u32, u32, u32)> Follower<'_, F, O> {
    /// The depth of a texel; `None` when no more may be read.
    pub(super) fn read(&mut self, level: u32, [x, y]: [u32; 2]) -> Option<f64> {
        self.texels = self.texels.checked_sub(1)?;
        (self.observer)(level, x, y);
        Some(f64::from(self.depth.depth(level, x, y)))
    }

    /// Whether the ray is before `depth` everywhere between two places.
    pub(super) fn is_before(&self, depth: f64, [from, to]: [f64; 2]) -> bool {
        depth == f64::INFINITY || self.ray.depths(from, to)[1] < depth
    }

    /// Judges a pixel of this depth that the ray passes between two places.
    pub(super) fn judge(&mut self, pixel: [u32; 2], depth: f64, [from, to]: [f64; 2]) -> Verdict {
        if self.is_before(depth, [from, to]) {
            self.frees(to);
            return Verdict::Passed;
        }
        let is_near = self.ray.depths(from, to)[0] <= depth * (1.0 + self.thickness);
        match ((self.faces)(pixel), is_near) {
            (true, true) => Verdict::Hit,
            (false, true) => {
                self.all_free = false;
                Verdict::Passed
            }
            (_, false) => Verdict::Behind,
        }
    }

    /// The ray is before all surfaces up to here.
    pub(super) fn frees(&mut self, until: f64) {
        if self.all_free {
            self.free = self.free.max(until);
        }
    }

    /// A miss.
    pub(super) fn misses(&self) -> MarchEnd {
        let a_pixel_before = self.free - 1.0 / self.ray.length();
        MarchEnd::Miss { t: self.ray.parameter(a_pixel_before.max(0.0)) as f32 }
    }
}
