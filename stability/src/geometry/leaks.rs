//! Rays from inside closed surfaces: one that hits nothing has leaked.

use crate::case::{Case, Limit};
use crate::random::Random;
use crate::structures::{Structure, Watch, all, options};
use crate::{Size, shapes};
use glam::Vec3;
use rayon::prelude::*;
use scenes::Triangle;
use tracer::{Query, Ray, TriangleTest};

/// Embree's limit for the share of rays that may leak.
const LIMIT: f64 = 2e-5;

/// Where Embree's test has its sphere.
const EMBREE: Vec3 = Vec3::new(148_376.0, 1234.0, -223_423.0);

/// A closed surface and how a ray starts inside of it.
struct Closed {
    id: &'static str,
    about: &'static str,
    triangles: Vec<Triangle>,
    ray: fn(&[Triangle], &mut Random) -> Ray,
    /// The tests that are to keep the limit. For the others the rate is a remark: Moller and Trumbore promise nothing at edges.
    tests: &'static [TriangleTest],
    /// Rays of a full run.
    rays: usize,
}

/// Rays that tell a rate far below the limit.
const MANY: usize = 1_000_000;

/// Rays that tell the limit, where each of them is hard.
const SOME: usize = 200_000;

const WATERTIGHT: &[TriangleTest] = &[TriangleTest::Watertight];

/// In any direction from around a point.
fn from_around(centre: Vec3, radius: f32, random: &mut Random) -> Ray {
    Ray::new(centre + radius * random.point(), random.direction())
}

fn vertex(triangles: &[Triangle], random: &mut Random) -> Vec3 {
    triangles[random.below(triangles.len())].v[random.below(3)]
}

fn surfaces() -> [Closed; 6] {
    [
        Closed {
            id: "embree-sphere",
            about: "a sphere of radius 2 at (148376, 1234, -223423), from around its centre",
            triangles: shapes::sphere(EMBREE, 2.0, 125),
            ray: |_, random| from_around(EMBREE, 0.5, random),
            tests: &TriangleTest::ALL,
            rays: MANY,
        },
        Closed {
            id: "sphere",
            about: "a sphere of radius 1 at the origin, from around its centre",
            triangles: shapes::sphere(Vec3::ZERO, 1.0, 125),
            ray: |_, random| from_around(Vec3::ZERO, 0.5, random),
            tests: &TriangleTest::ALL,
            rays: MANY,
        },
        Closed {
            id: "vertices",
            about: "a sphere of radius 1 at the origin, from inside at its vertices",
            triangles: shapes::sphere(Vec3::ZERO, 1.0, 50),
            ray: |triangles, random| {
                let origin = 0.5 * random.point();
                Ray::new(origin, vertex(triangles, random) - origin)
            },
            tests: WATERTIGHT,
            rays: SOME,
        },
        Closed {
            id: "edges",
            about: "a sphere of radius 1 at the origin, from its centre at points of its edges",
            triangles: shapes::sphere(Vec3::ZERO, 1.0, 50),
            ray: |triangles, random| {
                let [a, b, _] = triangles[random.below(triangles.len())].v;
                Ray::new(Vec3::ZERO, a + random.unit() as f32 * (b - a))
            },
            tests: WATERTIGHT,
            rays: SOME,
        },
        Closed {
            id: "from-vertices",
            about: "a sphere of radius 1 at the origin, from its vertices inwards",
            triangles: shapes::sphere(Vec3::ZERO, 1.0, 50),
            ray: |triangles, random| {
                let origin = vertex(triangles, random);
                Ray::new(origin, 0.5 * random.point() - origin)
            },
            tests: &TriangleTest::ALL,
            rays: SOME,
        },
        Closed {
            id: "needles",
            about: "a cone of needles of aspect 1e8, from inside near its base",
            triangles: shapes::cone(Vec3::new(7e3, 5e3, 3e3), 1e-3, 64),
            ray: |_, random| from_around(Vec3::ZERO, 1e-4, random),
            tests: WATERTIGHT,
            rays: SOME,
        },
    ]
}

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    let mut cases = Vec::new();
    for surface in surfaces() {
        let mut random = Random(2013);
        let rays: Vec<Ray> = (0..size.of(20_000, surface.rays))
            .map(|_| (surface.ray)(&surface.triangles, &mut random))
            .collect();
        let rates = TriangleTest::ALL.map(|test| leaked(&surface.triangles, test, &rays, watch));
        for (test, (leaks, of)) in TriangleTest::ALL.into_iter().zip(rates) {
            if !surface.tests.contains(&test) {
                continue;
            }
            let remark = format!(
                "{leaks} of {of} rays; by {} {} of {}",
                TriangleTest::MoellerTrumbore.name(),
                rates[0].0,
                rates[0].1
            );
            cases.push(
                Case::new(
                    format!("leaks/{}/{}", surface.id, test.name()),
                    format!("{}: share of rays that hit nothing, over all traversals", surface.about),
                    "share of rays",
                    Limit::AtMost(LIMIT),
                    leaks as f64 / of as f64,
                )
                .because(remark),
            );
            if surface.tests.len() == 1 && surface.id != "needles" {
                // Otherwise the rays are not hard, and the case before says nothing.
                cases.push(Case::new(
                    format!("leaks/{}/hard", surface.id),
                    format!(
                        "{}: more of these rays leak by Moller and Trumbore than the limit allows",
                        surface.about
                    ),
                    "share of rays",
                    Limit::AtLeast(LIMIT),
                    rates[0].0 as f64 / rates[0].1 as f64,
                ));
            }
        }
    }
    cases
}

/// Rays that hit nothing, and how many there were: all of them by the first traversal, an eighth by each of the others.
fn leaked(triangles: &[Triangle], test: TriangleTest, rays: &[Ray], watch: &Watch) -> (u64, u64) {
    let structures: Vec<Structure> = all(triangles, &options(test));
    let (mut leaks, mut of) = (0, 0);
    for (place, structure) in structures.iter().enumerate() {
        let rays = if place == 0 { rays } else { &rays[..rays.len() / 8] };
        let leaked = |ray: &&Ray| !structure.trace(watch, ray, Query::Closest).is_hit();
        leaks += rays.par_iter().filter(leaked).count() as u64;
        of += rays.len() as u64;
    }
    (leaks, of)
}
