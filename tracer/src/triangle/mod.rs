//! Tests of a ray against a triangle: a closed set, chosen when a structure is built, generic below.

mod moeller_trumbore;
mod watertight;

pub use moeller_trumbore::PreparedTriangle;
pub use watertight::WatertightTriangle;

use crate::ray::Ray;
use glam::Vec4;
use scenes::Triangle;

/// How a ray is tested against a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TriangleTest {
    /// Moller & Trumbore 1997: [`PreparedTriangle`]. What the costs of shaders are counted for.
    #[default]
    MoellerTrumbore,
    /// Woop, Benthin & Wald 2013: [`WatertightTriangle`].
    Watertight,
}

impl TriangleTest {
    /// Both.
    pub const ALL: [TriangleTest; 2] = [TriangleTest::MoellerTrumbore, TriangleTest::Watertight];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            TriangleTest::MoellerTrumbore => "moeller-trumbore",
            TriangleTest::Watertight => "watertight",
        }
    }

    /// The test of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|test| test.name() == name)
    }
}

/// A triangle prepared for one of the tests.
pub trait RayTriangle: for<'a> From<&'a Triangle> + Copy + Send + Sync {
    /// What the test needs of a ray, computed once for a traversal.
    type Ray<'a>: Copy;
    /// Triangles tested at once.
    type Group: TriangleGroup<Self>;

    /// Prepares a ray.
    fn prepare(ray: &Ray) -> Self::Ray<'_>;

    /// Tests the triangle over `[t_min, t_max]`; returns `(t, u, v)` of a hit.
    fn test(&self, ray: Self::Ray<'_>, t_max: f32) -> Option<(f32, f32, f32)>;
}

/// Triangles tested at once.
pub(crate) const GROUP: usize = 4;

/// Up to [`GROUP`] consecutive triangles of a reference list.
pub trait TriangleGroup<P: RayTriangle>: Copy + Send + Sync {
    /// Packs at most [`GROUP`] triangles, the first of them at position `first` of the reference list.
    fn new(first: u32, triangles: &[P]) -> Self;

    /// Position of the first triangle in the reference list.
    fn first(&self) -> u32;

    /// [`RayTriangle::test`] of all triangles, bit for bit.
    fn intersect(&self, ray: P::Ray<'_>, t_max: f32) -> GroupHits;
}

/// What [`TriangleGroup::intersect`] finds: per lane the values of [`RayTriangle::test`], and which lanes are hit.
pub struct GroupHits {
    t: Vec4,
    u: Vec4,
    v: Vec4,
    /// Bit `i` for lane `i`.
    pub(crate) lanes: u32,
}

impl GroupHits {
    /// `(t, u, v)` of a lane.
    #[inline(always)]
    pub(crate) fn of_lane(&self, lane: usize) -> (f32, f32, f32) {
        (self.t[lane], self.u[lane], self.v[lane])
    }
}
