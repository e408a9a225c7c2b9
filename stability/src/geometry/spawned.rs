//! Shadow rays of hits: they must not hit the triangle that they start from, and must not pass what stands close by.

use crate::case::{Case, Limit};
use crate::random::Random;
use crate::structures::{Structure, Watch, options};
use crate::{Size, shapes};
use glam::Vec3;
use rayon::prelude::*;
use tracer::{Query, Ray, RayOffset, Traversal, TriangleTest};

/// Powers of ten of the coordinates.
const DECADES: std::ops::RangeInclusive<i32> = -10..=10;

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    TriangleTest::ALL.into_iter().flat_map(|test| of_test(size, test, watch)).collect()
}

/// What became of the shadow rays at one scale.
#[derive(Clone, Copy)]
struct At {
    decade: i32,
    spawned: u64,
    /// Those that hit where they start.
    again: u64,
    /// Those that pass the sphere around the light's.
    passed: u64,
}

fn of_test(size: Size, test: TriangleTest, watch: &Watch) -> [Case; 2] {
    let rays = size.of(300, 5000);
    let at = |decade: i32| {
        let scale = 10.0_f64.powi(decade);
        let centre = (scale * glam::DVec3::new(3.0, -2.0, 5.0)).as_vec3();
        // A sphere, seen from outside, and a wider one around it: light is on the far side of either.
        let inner = shapes::sphere(centre, scale, 40);
        let outer = shapes::sphere(centre, 1.5 * scale, 12);
        let triangles: Vec<_> = inner.iter().chain(&outer).copied().collect();
        let structure =
            Structure::build(&triangles, Traversal::BvhStack, &options(test)).expect("it is finite");
        let offset = RayOffset::new(&triangles);
        let alone = Structure::build(&inner, Traversal::BvhStack, &options(test)).expect("it is finite");
        let mut random = Random(decade.unsigned_abs().into());
        let (mut spawned, mut again, mut passed) = (0, 0, 0);
        for _ in 0..rays {
            let origin = centre + 1.2 * scale as f32 * random.direction().normalize();
            let ray = Ray::new(origin, centre + 0.9 * scale as f32 * random.point() - origin);
            let hit = alone.trace(watch, &ray, Query::Closest);
            if !hit.is_hit() {
                continue;
            }
            let triangle = &inner[hit.primitive as usize];
            let [a, b, c] = triangle.v;
            // Straight away from the surface, which bends away from it.
            let out = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero();
            let out = if out.dot(ray.direction.as_dvec3()) > 0.0 { -out } else { out };
            let point =
                a.as_dvec3() + (b - a).as_dvec3() * f64::from(hit.u) + (c - a).as_dvec3() * f64::from(hit.v);
            let light: Vec3 = (point + out * 3.0 * scale).as_vec3();
            let shadow = offset.shadow_ray(triangle, hit.u, hit.v, ray.direction, light);
            spawned += 1;
            again += u64::from(alone.trace(watch, &shadow, Query::Any).is_hit());
            passed += u64::from(!structure.trace(watch, &shadow, Query::Any).is_hit());
        }
        At { decade, spawned, again, passed }
    };
    let found: Vec<At> = DECADES.into_par_iter().map(at).collect();
    let spawned: u64 = found.iter().map(|at| at.spawned).sum();
    let bad = |count: fn(&At) -> u64| {
        let decades: Vec<String> = found
            .iter()
            .filter(|at| count(at) > 0)
            .map(|at| format!("{} at 1e{}", count(at), at.decade))
            .collect();
        (found.iter().map(count).sum::<u64>(), decades.join(", "))
    };
    let ((again, again_at), (passed, passed_at)) = (bad(|at| at.again), bad(|at| at.passed));
    let remark = |decades: &str| match decades {
        "" => format!("{spawned} rays"),
        _ => format!("{spawned} rays; {decades}"),
    };
    [
        Case::none_of(
            format!("spawned/again/{}", test.name()),
            "shadow rays straight off a sphere with coordinates from 1e-10 to 1e10 do not hit it again",
            "rays",
            again,
        )
        .because(remark(&again_at)),
        Case::new(
            format!("spawned/passed/{}", test.name()),
            "shadow rays off a sphere with coordinates from 1e-10 to 1e10 meet the sphere of half again its radius around it",
            "rays that pass it",
            Limit::AtMost(0.0),
            passed as f64,
        )
        .because(remark(&passed_at)),
    ]
}
