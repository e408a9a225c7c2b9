//! Alpha-tested triangles: which hits count, and who decides it.
//!
//! Readers drop the images of a scene, so the mask is a rule on barycentrics instead of a texture, [`fence`]. A traversal that finds a hit closer than
//! its best asks its [`RayQuery`] whether the hit counts. An any-hit shader that was asked is a step, [`Op::AnyHit`].

mod micromap;
mod tested;

pub use micromap::{Micromap, MicromapFormat, MicromapStates};
pub use tested::TestedTriangles;

use crate::observe::{DECIDED_BY_MICROMAP, Observer, Op};
use crate::ray::{Hit, Query};
use serde::{Deserialize, Serialize};
use tested::TriangleSet;

/// Posts of a [`fence`].
const POSTS: f64 = 3.0;
/// The part of a [`fence`] that is opaque.
const COVERAGE: f64 = 0.5;
/// Where on a post the edges of a triangle lie: in the middle, so that both are opaque.
const FIRST_PHASE: f64 = 0.25;

/// The mask of every alpha-tested triangle: whether it is opaque at the barycentric weight `u` of its second vertex. Three opaque
/// posts as wide as the gaps between them, of which one is cut in half by the edges at `u` = 0 and `u` = 1.
pub fn fence(u: f32) -> bool {
    phase(f64::from(u)).fract() < COVERAGE
}

/// Place on the fence, in posts. Hits on an edge may lie a rounding outside.
fn phase(u: f64) -> f64 {
    u.clamp(0.0, 1.0) * POSTS + FIRST_PHASE
}

/// The state of the mask all over `[from, to]`, if it is one.
fn fence_over(from: f64, to: f64) -> Option<bool> {
    let (from, to) = (phase(from), phase(to));
    let one_piece = from.floor() == to.floor() && (from.fract() < COVERAGE) == (to.fract() < COVERAGE);
    one_piece.then(|| from.fract() < COVERAGE)
}

/// How a frame treats triangles that are alpha-tested: geometry flags and ray flags of Vulkan and what stands for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AlphaMode {
    /// An any-hit shader tests them; all others are marked opaque (`VK_GEOMETRY_OPAQUE_BIT_KHR`).
    #[default]
    AnyHit,
    /// No geometry is marked opaque, so every hit that is found goes to the shader.
    Unmarked,
    /// Rays take every triangle as opaque (`gl_RayFlagsOpaqueEXT`).
    Opaque,
    /// Rays pass through those that are not opaque (`gl_RayFlagsCullNoOpaqueEXT`).
    Cull,
    /// Micromaps decide where they can (`VK_EXT_opacity_micromap`), the any-hit shader elsewhere.
    Micromap,
}

impl AlphaMode {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::AnyHit, Self::Unmarked, Self::Opaque, Self::Cull, Self::Micromap];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::AnyHit => "any-hit",
            Self::Unmarked => "unmarked",
            Self::Opaque => "opaque",
            Self::Cull => "cull",
            Self::Micromap => "micromap",
        }
    }

    /// The mode of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }
}

/// What a trace's header says of alpha tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlphaTests {
    /// How alpha-tested triangles are treated.
    pub mode: AlphaMode,
    /// Which these are, in file order.
    pub tested: TestedTriangles,
    /// What the micromaps hold, where [`AlphaMode::Micromap`] has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub micromap: Option<MicromapFormat>,
}

impl AlphaTests {
    /// Whether hits may be left to an any-hit shader or a micromap; else rays decide by their flags alone.
    pub fn run_shaders(&self) -> bool {
        match self.mode {
            AlphaMode::AnyHit | AlphaMode::Unmarked | AlphaMode::Micromap => true,
            AlphaMode::Opaque | AlphaMode::Cull => false,
        }
    }

    /// Refuses what contradicts itself, of a scene of so many triangles.
    ///
    /// # Errors
    /// A sentence.
    pub(crate) fn check(&self, triangles: u32) -> Result<(), String> {
        self.tested.check(triangles)?;
        match (self.mode, &self.micromap) {
            (AlphaMode::Micromap, Some(format)) => format.check(),
            (AlphaMode::Micromap, None) => Err("alpha tests by micromaps of no format".to_owned()),
            (_, None) => Ok(()),
            (mode, Some(_)) => Err(format!("alpha tests '{}' with a format of micromaps", mode.name())),
        }
    }
}

/// The alpha tests of a structure's triangles, ready for traversals.
#[derive(Clone, Debug)]
pub(crate) struct AlphaTest {
    tests: AlphaTests,
    tested: TriangleSet,
    micromap: Option<Micromap>,
}

impl AlphaTest {
    /// Of a scene of so many triangles.
    ///
    /// # Errors
    /// See [`AlphaTests::check`].
    pub(crate) fn new(tests: AlphaTests, triangles: u32) -> Result<Self, String> {
        tests.check(triangles)?;
        let tested = tests.tested.set(triangles);
        let micromap = tests.micromap.map(Micromap::of_fence);
        Ok(Self { tests, tested, micromap })
    }

    pub(crate) fn tests(&self) -> &AlphaTests {
        &self.tests
    }

    /// Whether any hit may be asked about.
    pub(crate) fn asks(&self) -> bool {
        self.tests.mode != AlphaMode::Opaque
    }

    /// Whether a hit of the triangle at `position` of the references counts.
    fn accepts<O: Observer>(&self, hit: &Hit, position: u32, observer: &mut O) -> bool {
        let tested = self.tested.contains(hit.primitive);
        let shader = |observer: &mut O| {
            observer.step(Op::AnyHit, position);
            !tested || fence(hit.u)
        };
        match (self.tests.mode, &self.micromap) {
            (AlphaMode::Unmarked, _) => shader(observer),
            _ if !tested => true,
            (AlphaMode::Opaque, _) => true,
            (AlphaMode::Cull, _) => false,
            (AlphaMode::Micromap, Some(micromap)) => match micromap.opacity(hit.u, hit.v) {
                Some(opaque) => {
                    observer.step(Op::AnyHit, position | DECIDED_BY_MICROMAP);
                    opaque
                }
                None => shader(observer),
            },
            (AlphaMode::AnyHit | AlphaMode::Micromap, _) => shader(observer),
        }
    }
}

/// What a traversal is asked: which hit, and which hits count. [`Query`] itself takes every triangle as opaque.
pub trait RayQuery: Copy {
    /// Which hit.
    fn query(self) -> Query;
    /// Whether a hit, closer than any so far, of the triangle at `position` of the references counts.
    fn accepts<O: Observer>(self, hit: &Hit, position: u32, observer: &mut O) -> bool;
}

impl RayQuery for Query {
    #[inline(always)]
    fn query(self) -> Query {
        self
    }

    #[inline(always)]
    fn accepts<O: Observer>(self, _: &Hit, _: u32, _: &mut O) -> bool {
        true
    }
}

/// A query of a structure with alpha-tested triangles.
#[derive(Clone, Copy)]
pub(crate) struct AlphaQuery<'a> {
    pub(crate) query: Query,
    pub(crate) alpha: &'a AlphaTest,
}

impl RayQuery for AlphaQuery<'_> {
    #[inline(always)]
    fn query(self) -> Query {
        self.query
    }

    // Not inlined: hits are rare among tests.
    #[inline(never)]
    fn accepts<O: Observer>(self, hit: &Hit, position: u32, observer: &mut O) -> bool {
        self.alpha.accepts(hit, position, observer)
    }
}

#[cfg(test)]
mod tests;
