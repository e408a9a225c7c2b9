//! Hits of whole scenes against exact ones: ordinary scenes, far offsets, needles.

use crate::case::{Case, Limit};
use crate::exact::ROUNDINGS;
use crate::judge::Verdicts;
use crate::random::Random;
use crate::reference::Reference;
use crate::structures::{Structure, Watch, options};
use crate::{Size, shapes};
use glam::Vec3;
use rayon::prelude::*;
use scenes::Triangle;
use tracer::{Query, Ray, Traversal, TriangleTest, View};

/// Ids of a million that sound f32 kernels differ in on ordinary scenes: up to 35 between Embree, tinybvh and others.
const SANE: f64 = 35.0;

/// Rays that hit a scene in f32, by each test, against exact arithmetic.
pub(crate) fn judged(triangles: &[Triangle], rays: &[Ray], watch: &Watch) -> [Verdicts; 2] {
    let reference = Reference::new(triangles);
    let structures = TriangleTest::ALL.map(|test| {
        Structure::build(triangles, Traversal::BvhStack, &options(test)).expect("a BVH takes any scene")
    });
    let of_ray = |ray: &Ray| {
        let exact = reference.nearest(ray);
        [0, 1].map(|test: usize| {
            let hit = structures[test].trace(watch, ray, Query::Closest);
            Verdicts::of(&reference, ray, &hit, exact)
        })
    };
    let both = |[a, b]: [Verdicts; 2], [c, d]: [Verdicts; 2]| [a.and(c), b.and(d)];
    rays.par_iter().map(of_ray).reduce(Default::default, both)
}

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    let mut cases = Vec::new();
    for name in ["cornell", "teapot", "atrium"] {
        let scene = scenes::load(name).expect("it is built in");
        let side = size.of(128, if name == "cornell" { 512 } else { 1024 });
        let view = View::new(&scene.camera, side, side);
        let pixels = (0..side * side).map(|pixel| view.primary_ray(pixel % side, pixel / side));
        let verdicts = judged(&scene.triangles(), &pixels.collect::<Vec<_>>(), watch);
        let about = format!("primary rays of '{name}'");
        for (test, verdicts) in TriangleTest::ALL.into_iter().zip(verdicts) {
            // With fewer rays than a million, one that differs is many per million.
            let resolution = 1e6 / verdicts.rays as f64;
            let limit = Limit::AtMost(SANE.max(3.0 * resolution));
            cases.push(
                Case::new(
                    format!("hits/{name}/{}", test.name()),
                    format!("{about} name the triangle that exact arithmetic names, or one as near"),
                    "differing per million",
                    limit,
                    verdicts.per_million(),
                )
                .under("largest condition of a hit", verdicts.condition)
                .because(format!("{} of {} rays differ", verdicts.differing, verdicts.rays)),
            );
            cases.extend(sound(&format!("{name}/{}", test.name()), &about, &verdicts));
        }
    }
    for (id, about, triangles, rays) in hard(size) {
        for (test, verdicts) in TriangleTest::ALL.into_iter().zip(judged(&triangles, &rays, watch)) {
            cases.extend(sound(&format!("{id}/{}", test.name()), about, &verdicts));
        }
    }
    cases
}

/// No decision is wrong but in doubt, and no distance is further off than theory has it.
fn sound(id: &str, about: &str, verdicts: &Verdicts) -> [Case; 2] {
    let remark = format!(
        "{} of {} rays differ ({:.1} per million), {} of them lost",
        verdicts.differing,
        verdicts.rays,
        verdicts.per_million(),
        verdicts.lost
    );
    [
        Case::none_of(
            format!("decisions/{id}"),
            format!(
                "{about}: no other triangle than the exact one but where {ROUNDINGS} roundings can explain it"
            ),
            "wrong decisions",
            verdicts.wrong,
        )
        .under("largest condition of a hit", verdicts.condition)
        .because(remark),
        Case::new(
            format!("distance/{id}"),
            format!("{about}: the error of t is that of {ROUNDINGS} roundings times the condition at most"),
            "roundings",
            Limit::AtMost(ROUNDINGS),
            verdicts.t_error,
        )
        .under("largest condition of a hit", verdicts.condition)
        .because(format!("largest relative error of t {:.2e}", verdicts.relative_t_error)),
    ]
}

type Hard = (&'static str, &'static str, Vec<Triangle>, Vec<Ray>);

fn hard(size: Size) -> Vec<Hard> {
    let rays = size.of(4000, 100_000);
    let centre = Vec3::new(1e7, -1e7, 1e7);
    let sphere = shapes::sphere(centre, 2000.0, 40);
    let apex = Vec3::new(7e3, 5e3, 3e3);
    let needles = shapes::cone(apex, 1e-3, 64);
    let mut random = Random(0x5eed);
    let towards = |triangles: &[Triangle], origin: Vec3, random: &mut Random| {
        let [a, b, c] = triangles[random.below(triangles.len())].v;
        let (mut u, mut v) = (random.unit() as f32, random.unit() as f32);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        Ray::new(origin, a + (b - a) * u + (c - a) * v - origin)
    };
    let near = (0..rays).map(|_| {
        let origin = centre + 6000.0 * random.point();
        towards(&sphere, origin, &mut random)
    });
    let near = near.collect();
    let far = (0..rays).map(|_| {
        let origin = 1000.0 * random.point();
        towards(&sphere, origin, &mut random)
    });
    let far = far.collect();
    let across = (0..rays).map(|_| {
        let origin = 10.0 * random.point();
        towards(&needles, origin, &mut random)
    });
    let across = across.collect();
    vec![
        ("offset-near", "a sphere at 1e7 seen from three radii away", sphere.clone(), near),
        ("offset-far", "a sphere at 1e7 seen from the origin", sphere, far),
        ("needles", "triangles of aspect 1e8 in a general direction", needles, across),
    ]
}
