//! Does a grid find what a loop over all triangles finds where its cells make it hard, and does it walk as it should?

mod kd_support;

use kd_support::*;
use proptest::prelude::*;
use scenes::{Triangle, Vec3};
use tracer::grid::{Grid, dda};
use tracer::{Op, PreparedTriangle, Query, Ray, Silent};

/// Compares the grid with the loop, and its steps with the rules; returns how many rays hit.
fn check(triangles: &[Triangle], rays: &[Ray]) -> usize {
    let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::from).collect();
    let grid = Grid::build(triangles).unwrap();
    let mut hits = 0;
    for ray in rays {
        let expected = brute_force(&prepared, ray);
        let mut log = Log::default();
        assert_eq!(dda::trace(&grid, ray, Query::Closest, &mut log), expected, "{ray:?}");
        check_walk(&grid, &log);
        assert_eq!(dda::trace(&grid, ray, Query::Any, &mut Silent).is_hit(), expected.is_hit(), "{ray:?}");
        hits += usize::from(expected.is_hit());
    }
    hits
}

/// Cells are neighbours, none is met twice, and all references of each are tested in order.
fn check_walk(grid: &Grid, log: &Log) {
    let [nx, ny, nz] = grid.resolution();
    let place = |cell: u32| [cell % nx, cell / nx % ny, cell / nx / ny];
    let cells: Vec<_> = log.of(Op::Node).collect();
    let mut directions = [0_i64; 3];
    for pair in cells.windows(2) {
        let steps = [0, 1, 2].map(|axis| i64::from(place(pair[1])[axis]) - i64::from(place(pair[0])[axis]));
        assert_eq!(steps.iter().map(|step| step.abs()).sum::<i64>(), 1, "one step on one axis: {pair:?}");
        for axis in 0..3 {
            assert!(steps[axis] * directions[axis] >= 0, "never back");
            directions[axis] += steps[axis];
        }
    }
    assert!(cells.len() <= (nx + ny + nz) as usize);
    let expected: Vec<_> = cells
        .iter()
        .flat_map(|&cell| {
            std::iter::once((Op::Node, cell)).chain(grid.cell(cell).map(|r| (Op::Primitive, r)))
        })
        .collect();
    assert_eq!(log.steps, expected);
    assert_eq!((log.leaf_visits as usize, log.plane_tests, log.stalls), (cells.len(), 0, 0));
}

/// Rays in the planes between cells, along axes and across.
fn rays_in_planes(grid: &Grid, each: usize, random: &mut Random) -> Vec<Ray> {
    let bounds = grid.bounds();
    let mut rays = Vec::new();
    for axis in 0..3 {
        for &plane in &grid.planes(axis)[1..grid.resolution()[axis] as usize] {
            for _ in 0..each {
                for shift in [plane, plane.next_down(), plane.next_up()] {
                    let mut ray = random_ray(random, bounds.min, bounds.max);
                    ray.origin[axis] = shift;
                    ray.direction[axis] = [0.0, -0.0, 1e-9, -1e-9][random.below(4)];
                    rays.push(ray);
                    // From one plane of a second axis to the next: through the edges of cells.
                    let other = (axis + 1) % 3;
                    ray.direction = Vec3::ZERO;
                    ray.direction[(axis + 2) % 3] = [1.0, -1.0][random.below(2)];
                    let planes = grid.planes(other);
                    ray.origin[other] = planes[random.below(planes.len())].clamp(-1e30, 1e30);
                    rays.push(ray);
                }
            }
        }
    }
    rays
}

#[test]
fn rays_in_the_planes_and_edges_of_cells_find_the_hit_of_the_loop() {
    for triangles in [soup(300, 1), quads(4), quads(8)] {
        let grid = Grid::build(&triangles).unwrap();
        let rays = rays_in_planes(&grid, 30, &mut Random(4));
        let hits = check(&triangles, &rays);
        assert!(hits > rays.len() / 10, "{hits} of {}", rays.len());
    }
}

#[test]
fn triangles_in_the_planes_between_cells_are_hit_from_both_sides() {
    // 5 triangles per unit of length: 25 cells on x. Plates lie in their planes, and a part of the rays begins there.
    let plate =
        |x: f32| Triangle { v: [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0), Vec3::new(x, 0.0, 1.0)] };
    let triangles: Vec<_> = (0..=20).map(|x| plate(x as f32)).collect();
    let grid = Grid::build(&triangles).unwrap();
    let planes = grid.planes(0);
    let in_planes: Vec<_> =
        planes[1..planes.len() - 1].iter().map(|&x| plate(x)).chain([plate(0.0), plate(20.0)]).collect();
    let mut rays = Vec::new();
    for triangle in &in_planes {
        for direction in [Vec3::X, Vec3::NEG_X, Vec3::new(1.0, 0.01, -0.0), Vec3::new(-3.0, 0.0, 0.02)] {
            for back in [0.0, 0.1, 30.0] {
                let target = Vec3::new(triangle.v[0].x, 0.25, 0.25);
                rays.push(Ray::new(target - back * direction, direction));
            }
        }
    }
    assert!(check(&in_planes, &rays) > rays.len() / 2);
}

#[test]
fn edges_a_few_floats_before_a_plane_are_hit_by_rays_that_have_passed_it() {
    let ends = [0.0, 20.0]
        .map(|x: f32| Triangle { v: [Vec3::X * x, Vec3::new(x, 1.0, 0.0), Vec3::new(x, 0.0, 1.0)] });
    let to_edge = |x: f32| Triangle {
        v: [Vec3::new(x, 0.0, 0.5), Vec3::new(x, 1.0, 0.5), Vec3::new(x - 0.5, 0.5, 0.5)],
    };
    // The planes depend on the box and the number of triangles only.
    let build = |edges: &[f32]| {
        let triangles: Vec<_> = ends.into_iter().chain(edges.iter().map(|&x| to_edge(x))).collect();
        (Grid::build(&triangles).unwrap(), triangles)
    };
    let planes = build(&[10.0; 60]).0.planes(0).to_vec();
    let inner = planes.iter().copied().filter(|x| (1.0..20.0).contains(x));
    let edges: Vec<f32> = inner.map(|x| x.next_down()).cycle().take(60).collect();
    let (grid, triangles) = build(&edges);
    assert_eq!(grid.planes(0), planes, "edges lie just before the planes of their own grid");
    let mut random = Random(12);
    let rays: Vec<_> = (0..40_000)
        .map(|_| {
            let target = Vec3::new(edges[random.below(60)], 0.5 + 0.4 * random.signed(), 0.5);
            let origin = target + [1.0, 10.0, 300.0][random.below(3)] * random.point();
            Ray::new(origin, target - origin)
        })
        .collect();
    assert!(check(&triangles, &rays) > 10_000);
}

#[test]
fn rays_from_far_away_and_from_inside_find_the_hit_of_the_loop() {
    let triangles = soup(400, 5);
    let mut random = Random(6);
    for distance in [0.0, 0.9, 10.0, 1e3] {
        let rays: Vec<_> = (0..3000)
            .map(|_| {
                let origin = distance * random.point().normalize();
                let target = triangles[random.below(400)].v.iter().sum::<Vec3>() / 3.0;
                Ray::new(origin, target - origin)
            })
            .collect();
        assert!(check(&triangles, &rays) > 2900, "{distance}");
    }
}

#[test]
fn segments_begin_and_end_where_they_say_in_any_cell() {
    let triangles = soup(300, 8);
    let mut random = Random(9);
    let (low, high) = bounds(&triangles);
    let rays: Vec<_> = (0..4000)
        .map(|_| {
            let ray = random_ray(&mut random, low, high);
            let t_min = random.signed() * 2.0;
            Ray { t_min, t_max: t_min + random.signed().abs(), ..ray }
        })
        .collect();
    let hits = check(&triangles, &rays);
    assert!(hits > 50 && hits < 3950, "{hits}");
    // Ends at the hit, to the bit.
    let prepared: Vec<_> = triangles.iter().map(PreparedTriangle::from).collect();
    let ends: Vec<_> = rays
        .iter()
        .map(|ray| (ray, brute_force(&prepared, ray)))
        .filter(|(_, hit)| hit.is_hit())
        .flat_map(|(ray, hit)| {
            let end = |t_max| Ray { t_max, ..*ray };
            let begin = |t_min| Ray { t_min, ..*ray };
            [end(hit.t), end(hit.t.next_down()), begin(hit.t), begin(hit.t.next_up())]
        })
        .collect();
    assert!(check(&triangles, &ends) > hits);
}

#[test]
fn of_coincident_triangles_the_first_is_hit() {
    let triangles: Vec<_> = soup(50, 3).into_iter().flat_map(|t| [t, t, t]).collect();
    let mut random = Random(2);
    let (low, high) = bounds(&triangles);
    let rays: Vec<_> = (0..3000).map(|_| random_ray(&mut random, low, high)).collect();
    assert!(check(&triangles, &rays) > 50);
}

#[test]
fn a_hit_beyond_the_cell_is_kept_but_a_nearer_one_in_a_later_cell_wins() {
    // A bar that leans across the ray's cells is hit far behind a plate which only a later cell lists.
    let bar =
        Triangle { v: [Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 1.0), Vec3::new(10.0, 1.0, 0.0)] };
    let plate =
        |x: f32| Triangle { v: [Vec3::new(x, 0.4, -0.5), Vec3::new(x, 0.4, 0.5), Vec3::new(x, 0.6, 0.0)] };
    let mut triangles = vec![bar];
    triangles.extend((0..40).map(|i| plate(3.0 + 0.01 * i as f32)));
    let ray = Ray::new(Vec3::new(-1.0, 0.5, 0.0), Vec3::X);
    let grid = Grid::build(&triangles).unwrap();
    let mut log = Log::default();
    let hit = dda::trace(&grid, &ray, Query::Closest, &mut log);
    assert_eq!((hit.primitive, hit.t), (1, 4.0));
    let tested: Vec<_> = log.of(Op::Primitive).map(|r| grid.references()[r as usize]).collect();
    let of_bar = tested.iter().filter(|&&triangle| triangle == 0).count();
    assert!(of_bar > 1 && tested[0] == 0, "the bar is tested first, and again in each cell: {tested:?}");
    assert_eq!(dda::trace(&grid, &ray, Query::Any, &mut Silent).primitive, 0, "any hit will do");
}

#[test]
fn a_ray_past_the_box_takes_no_step_and_one_through_it_enters_at_the_face() {
    let triangles = quads(8);
    let grid = Grid::build(&triangles).unwrap();
    let [nx, ny, nz] = grid.resolution();
    let walk = |origin: Vec3, direction: Vec3| {
        let mut log = Log::default();
        dda::trace(&grid, &Ray::new(origin, direction), Query::Closest, &mut log);
        log.of(Op::Node).collect::<Vec<_>>()
    };
    assert!(walk(Vec3::new(-1.0, 9.0, 1.0), Vec3::X).is_empty());
    assert!(walk(Vec3::new(9.0, 1.0, 1.0), Vec3::X).is_empty());
    assert_eq!(walk(Vec3::splat(-0.1), Vec3::ONE)[0], 0);
    assert_eq!(walk(Vec3::splat(8.1), Vec3::NEG_ONE)[0], nx * ny * nz - 1);
    let corner = walk(Vec3::new(8.1, -0.1, 8.1), Vec3::new(-1.0, 1.0, -1.0))[0];
    assert_eq!(corner, nx - 1 + nx * ny * (nz - 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_bits_as_a_ray_end_within_the_grid(count in 0_usize..60, seed in any::<u64>(), bits in any::<[u32; 8]>()) {
        let f = bits.map(f32::from_bits);
        let ray = Ray {
            origin: Vec3::new(f[0], f[1], f[2]),
            t_min: f[3],
            direction: Vec3::new(f[4], f[5], f[6]),
            t_max: f[7],
        };
        let grid = Grid::build(&soup(count, seed)).unwrap();
        let mut log = Log::default();
        dda::trace(&grid, &ray, Query::Closest, &mut log);
        check_walk(&grid, &log);
    }

    #[test]
    fn lattice_soups_give_the_hits_of_the_loop(seed in any::<u64>(), count in 1_usize..200, steps in 2_u64..12) {
        // Few coordinates, many of them in the planes between cells.
        let mut random = Random(seed);
        let mut coordinate = || (random.bits() % (steps + 1)) as f32 * 0.5 - 2.0;
        let mut point = || Vec3::new(coordinate(), coordinate(), coordinate());
        let triangle = || Triangle { v: [point(), point(), point()] };
        let triangles: Vec<_> =
            std::iter::repeat_with(triangle).filter(|t| !t.is_degenerate()).take(count).collect();
        let rays: Vec<_> = (0..200)
            .map(|_| {
                let origin = point();
                Ray::new(origin, point() - origin)
            })
            .collect();
        check(&triangles, &rays);
    }
}
