//! Do all kd traversals and the grid give the hits of a loop over all triangles?

mod kd_support;

use kd_support::*;
use proptest::prelude::*;
use scenes::{Triangle, Vec3};
use tracer::grid::{Grid, dda};
use tracer::kd::{KdOptions, KdTree, stack};
use tracer::{Hit, NO_HIT, PreparedTriangle, Query, Ray, Silent};

fn same(a: Hit, b: Hit) -> bool {
    a.primitive == b.primitive && [a.t, a.u, a.v].map(f32::to_bits) == [b.t, b.u, b.v].map(f32::to_bits)
}

/// Compares every traversal of every kind of tree, and the grid, with the loop, on each ray.
fn check(triangles: &[Triangle], rays: &[Ray]) {
    let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::from).collect();
    let expected: Vec<_> = rays.iter().map(|ray| brute_force(&prepared, ray)).collect();
    let compare = |title: &str, ray: &Ray, expected: Hit, trace: &dyn Fn(Query) -> Hit| {
        let closest = trace(Query::Closest);
        assert!(same(closest, expected), "{title}: {closest:?}, not {expected:?}: {ray:?}");
        let any = trace(Query::Any);
        assert_eq!(any.is_hit(), expected.is_hit(), "{title}: {ray:?}");
        if any.is_hit() {
            let (t, u, v) = prepared[any.primitive as usize].intersect(ray, ray.t_max).unwrap();
            assert!(same(any, Hit { t, u, v, ..any }));
        }
    };
    for options in all_options() {
        let traversals = Traversals::new(triangles, &options);
        for (name, title) in NAMES.iter().enumerate() {
            let title = format!("{title} {options:?}");
            for (ray, &expected) in rays.iter().zip(&expected) {
                compare(&title, ray, expected, &|query| traversals.trace(name, ray, query, &mut Silent));
            }
        }
    }
    let grid = Grid::build(triangles).unwrap();
    for (ray, &expected) in rays.iter().zip(&expected) {
        compare("dda", ray, expected, &|query| dda::trace(&grid, ray, query, &mut Silent));
    }
}

fn rays(triangles: &[Triangle], each: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let (low, high) = bounds(triangles);
    (0..each)
        .flat_map(|_| {
            [
                random_ray(&mut random, low, high),
                axis_ray(&mut random, triangles),
                corner_ray(&mut random, triangles, low, high),
            ]
        })
        .collect()
}

#[test]
fn a_soup_gives_the_hits_of_the_loop() {
    for seed in 0..8 {
        let triangles = soup(300, seed);
        check(&triangles, &rays(&triangles, 400, seed));
    }
}

#[test]
fn coplanar_quads_give_the_hits_of_the_loop() {
    for n in [2, 5, 8] {
        let triangles = quads(n);
        check(&triangles, &rays(&triangles, 800, n as u64));
    }
}

#[test]
fn a_ray_in_the_corner_of_four_cells_finds_the_lowest_index() {
    let triangles = quads(8);
    let rays: Vec<_> = (0..=8)
        .flat_map(|x| (0..=8).map(move |y| Vec3::new(x as f32, y as f32, 20.0)))
        .flat_map(|o| [Vec3::new(0.0, -0.0, -1.0), Vec3::new(-0.0, 0.0, -2.0)].map(|d| Ray::new(o, d)))
        .collect();
    check(&triangles, &rays);
}

#[test]
fn translated_and_scaled_scenes_give_the_hits_of_the_loop() {
    for (scale, offset) in
        [(1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)), (1e-6, Vec3::ZERO), (1e15, Vec3::ZERO)]
    {
        let mut triangles = soup(200, 77);
        triangles.iter_mut().flat_map(|t| &mut t.v).for_each(|p| *p = *p * scale + offset);
        check(&triangles, &rays(&triangles, 300, 5));
    }
}

#[test]
fn no_triangles_no_hit() {
    let traversals = Traversals::new(&[], &KdOptions::MOBILE);
    for name in 0..NAMES.len() {
        let ray = Ray { t_max: 5.0, ..Ray::new(Vec3::ZERO, Vec3::X) };
        assert_eq!(traversals.trace(name, &ray, Query::Closest, &mut Silent), Hit::miss(5.0));
    }
    let ray = Ray { t_max: 5.0, ..Ray::new(Vec3::ZERO, Vec3::X) };
    assert_eq!(dda::trace(&Grid::build(&[]).unwrap(), &ray, Query::Closest, &mut Silent), Hit::miss(5.0));
}

#[test]
fn one_triangle_and_a_ray_in_its_plane() {
    let triangle = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
    let across = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
    let in_plane = Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X);
    check(&[triangle], &[across, in_plane]);
    let tree = KdTree::build(&[triangle], &KdOptions::MOBILE).unwrap();
    assert_eq!(stack::trace(&tree, &across, Query::Closest, &mut Silent).primitive, 0);
    assert_eq!(stack::trace(&tree, &in_plane, Query::Closest, &mut Silent).primitive, NO_HIT);
}

#[test]
fn a_segment_ends_where_it_says() {
    let triangles = quads(4);
    let mut random = Random(11);
    let rays: Vec<_> = rays(&triangles, 300, 12)
        .into_iter()
        .map(|ray| {
            let t_min = random.signed().abs() * 3.0;
            Ray { t_min, t_max: t_min + random.signed().abs() * 6.0, ..ray }
        })
        .collect();
    check(&triangles, &rays);
    let wall = [Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] }];
    let to = |t_min, t_max| Ray { t_min, t_max, ..Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z) };
    let tree = KdTree::build(&wall, &KdOptions::MOBILE).unwrap();
    let is_hit = |ray: Ray| stack::trace(&tree, &ray, Query::Any, &mut Silent).is_hit();
    assert!(is_hit(to(0.0, 1.0)) && is_hit(to(1.0, 2.0)));
    assert!(!is_hit(to(0.0, 1.0_f32.next_down())) && !is_hit(to(1.0_f32.next_up(), 2.0)));
}

#[test]
fn rays_with_nan_or_infinity_anywhere_end_and_agree_with_the_loop() {
    let triangles = soup(200, 3);
    let good = [0.1, 0.2, 0.3, 0.0, 0.4, -0.5, 0.6, 10.0];
    let mut rays = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, f32::MAX, f32::MIN_POSITIVE] {
        for field in 0..8 {
            let mut f = good;
            f[field] = bad;
            rays.push(Ray {
                origin: Vec3::new(f[0], f[1], f[2]),
                t_min: f[3],
                direction: Vec3::new(f[4], f[5], f[6]),
                t_max: f[7],
            });
        }
    }
    rays.push(Ray::new(Vec3::ZERO, Vec3::ZERO));
    check(&triangles, &rays);
}

#[test]
fn a_collinear_triangle_is_missed() {
    // From the tests of pbrt.
    let triangle = Triangle {
        v: [
            Vec3::new(-1113.4546, -79.049614, -56.24319),
            Vec3::new(-1113.4546, -87.09227, -56.24319),
            Vec3::new(-1113.4546, -79.209015, -56.24319),
        ],
    };
    let ray = Ray {
        t_max: 0.9999,
        ..Ray::new(Vec3::new(-1081.4792, 99.999954, 87.77011), Vec3::new(-32.1073, -183.35587, -144.60764))
    };
    check(&[triangle], &[ray]);
}

#[test]
fn real_scenes_give_the_hits_of_the_loop() {
    for (name, each) in [("CornellBox-Water", 3000), ("sponza_dabrovic_66k", 300)] {
        let Some(triangles) = real_scene(name) else { continue };
        check(&triangles, &rays(&triangles, each, 21));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn small_grid_soups_give_the_hits_of_the_loop(seed in any::<u64>(), count in 1_usize..60, grid in 1_u64..6) {
        // Few coordinates, so that vertices, edges, planes and rays coincide.
        let mut random = Random(seed);
        let mut coordinate = || (random.bits() % (grid + 1)) as f32 - 2.0;
        let mut point = || Vec3::new(coordinate(), coordinate(), coordinate());
        // A triangle without area has no place where it is hit: what rounding makes of one is not worth agreeing on.
        let triangle = || Triangle { v: [point(), point(), point()] };
        let triangles: Vec<_> =
            std::iter::repeat_with(triangle).filter(|t| !t.is_degenerate()).take(count).collect();
        let rays: Vec<_> = (0..60)
            .map(|_| {
                let origin = point();
                Ray::new(origin, point() - origin)
            })
            .chain(rays(&triangles, 20, seed))
            .collect();
        check(&triangles, &rays);
    }
}
