//! Do marches through the depth buffer read and meet what they should, and is a ray free up to where they end?

mod reflection_support;
#[path = "reflection_support/screen.rs"]
mod screen;

use glam::Vec3;
use reflection_support::{World, settings};
use scenes::{Camera, Triangle};
use screen::Screen;
use tracer::reflections::{March, MarchBounds, MarchEnd, Outcome, ReflectionRay, Reflections};
use tracer::{Hit, Query, Ray, ReflectionRays, Silent};

/// No march is ended by its number of texels.
const UNBOUNDED: MarchBounds = MarchBounds { thickness: March::THICKNESS, texels: u32::MAX };
const LINEAR: March = March::Linear { stride: 1, bounds: UNBOUNDED };
const HIERARCHICAL: March = March::Hierarchical { bounds: UNBOUNDED };

fn is_hit(end: MarchEnd) -> bool {
    matches!(end, MarchEnd::Hit { .. })
}

fn same_place(a: MarchEnd, b: MarchEnd) -> bool {
    match (a, b) {
        (MarchEnd::Hit { x, y }, MarchEnd::Hit { x: u, y: v }) => [x, y] == [u, v],
        (MarchEnd::Miss { .. }, MarchEnd::Miss { .. }) => true,
        _ => false,
    }
}

fn closest(world: &World, ray: &Ray) -> Hit {
    world.structure.trace(ray, Query::Closest, &mut Silent)
}

#[test]
fn the_linear_march_reads_and_meets_what_brute_force_does() {
    for (name, edge) in [("cornell", 96), ("atrium", 96)] {
        let world = World::builtin(name, edge);
        let gbuffer = world.gbuffer();
        let (mirrors, screen) = (world.mirrors(), Screen::new(&world.camera, edge));
        let reflections = Reflections::new(&gbuffer, settings(&mirrors, Some(LINEAR)));
        let (mut marches, mut different) = (0, 0);
        for pixel in 0..gbuffer.pixels() {
            let Some(ray) = reflections.ray(pixel) else { continue };
            let parts = screen.steps(&ray, f64::from(gbuffer.depth().nearest()));
            let (expected, read) = screen.march(&gbuffer, &ray, &parts, f64::from(March::THICKNESS));
            let mut texels = Vec::new();
            let end = reflections
                .march(pixel, |level, x, y| {
                    assert_eq!(level, 0);
                    texels.push([x, y]);
                })
                .expect("a march");
            let expected_texels = parts[..read].iter().map(|(pixel, _)| *pixel);
            marches += 1;
            different += u32::from(!same_place(end, expected) || !expected_texels.eq(texels));
        }
        // Where a ray passes a texel's corner, rounding decides.
        assert!(marches > 5000 && different * 500 < marches, "{name}: {different} of {marches} differ");
    }
}

#[test]
fn the_hierarchical_march_meets_what_brute_force_over_all_pixels_does() {
    for (name, edge) in [("cornell", 96), ("atrium", 75)] {
        let world = World::builtin(name, edge);
        let gbuffer = world.gbuffer();
        let (mirrors, screen) = (world.mirrors(), Screen::new(&world.camera, edge));
        let reflections = Reflections::new(&gbuffer, settings(&mirrors, Some(HIERARCHICAL)));
        let (mut marches, mut different) = (0, 0);
        for pixel in 0..gbuffer.pixels() {
            let Some(ray) = reflections.ray(pixel) else { continue };
            let parts = screen.pixels(&ray, f64::from(gbuffer.depth().nearest()));
            let (expected, _) = screen.march(&gbuffer, &ray, &parts, f64::from(March::THICKNESS));
            let end = reflections.march(pixel, |_, _, _| {}).expect("a march");
            marches += 1;
            different += u32::from(!same_place(end, expected));
        }
        // Corners that a ray cuts by less than a thousandth of a pixel are not looked at.
        assert!(marches > 4000 && different * 200 < marches, "{name}: {different} of {marches} differ");
    }
}

#[test]
fn both_marches_agree_and_the_hierarchical_one_reads_less_than_half() {
    for name in ["cornell", "atrium"] {
        let world = World::builtin(name, 256);
        let gbuffer = world.gbuffer();
        let mirrors = world.mirrors();
        let of = |march| Reflections::new(&gbuffer, settings(&mirrors, Some(march)));
        let (linear, hierarchical) = (of(March::LINEAR), of(March::HIERARCHICAL));
        let (mut marches, mut different, mut texels) = (0_u32, 0, [0_u64; 2]);
        for pixel in 0..gbuffer.pixels() {
            let Some(end) = linear.march(pixel, |_, _, _| texels[0] += 1) else { continue };
            let other = hierarchical.march(pixel, |_, _, _| texels[1] += 1).expect("a march");
            marches += 1;
            different += u32::from(is_hit(end) != is_hit(other));
        }
        assert!(different * 50 < marches, "{name}: {different} of {marches} differ");
        assert!(texels[1] * 2 < texels[0] && texels[1] > u64::from(marches), "{name}: {texels:?}");
    }
}

#[test]
fn up_to_where_a_query_starts_no_texel_is_nearer_than_the_ray() {
    let world = World::builtin("atrium", 80);
    let gbuffer = world.gbuffer();
    let (mirrors, screen) = (world.mirrors(), Screen::new(&world.camera, 80));
    for march in [LINEAR, HIERARCHICAL] {
        let reflections = Reflections::new(&gbuffer, settings(&mirrors, Some(march)));
        let mut moved = 0;
        for &ReflectionRay { ray, .. } in reflections.rays() {
            let near = f64::from(gbuffer.depth().nearest());
            let parts = if march == LINEAR { screen.steps(&ray, near) } else { screen.pixels(&ray, near) };
            let free = f64::from(ray.t_min);
            for ([x, y], [from, to]) in parts.into_iter().take_while(|(_, part)| part[0] < free * 0.999) {
                let [_, largest] = screen.depths(&ray, [from, to.min(free)]);
                let depth = f64::from(gbuffer.depth().depth(0, x, y));
                assert!(largest <= depth * 1.001, "{march:?}: {largest} behind {depth} at {x}, {y}");
            }
            moved += usize::from(ray.t_min > 0.0);
        }
        assert!(moved * 10 > reflections.rays().len() * 8, "{moved} of {}", reflections.rays().len());
    }
}

#[test]
fn a_query_that_starts_where_the_march_ended_finds_what_it_would_find_from_the_surface() {
    // In the Cornell Box all surfaces are many pixels wide, so the screen is not too coarse for any but along edges.
    let world = World::builtin("cornell", 256);
    let gbuffer = world.gbuffer();
    let (mirrors, screen) = (world.mirrors(), Screen::new(&world.camera, 256));
    for march in [March::LINEAR, March::HIERARCHICAL] {
        let reflections = Reflections::new(&gbuffer, settings(&mirrors, Some(march)));
        let mut changed = 0;
        for &ReflectionRay { ray, .. } in reflections.rays() {
            let from_surface = closest(&world, &Ray { t_min: 0.0, ..ray });
            if from_surface.primitive == closest(&world, &ray).primitive {
                continue;
            }
            changed += 1;
            let point = ray.origin + ray.direction * from_surface.t;
            let shown = screen.pixel(point.as_dvec3()).and_then(|[x, y]| gbuffer.triangle(y * 256 + x));
            assert_ne!(shown, Some(from_surface.primitive), "{march:?} passed over what its pixel shows");
        }
        let queries = reflections.rays().len();
        assert!(queries > 10_000 && changed * 1000 < queries, "{march:?}: {changed} of {queries}");
    }
}

#[test]
fn a_mirror_floor_shows_a_wall_where_geometry_says() {
    // The eye 2 above a floor, a wall 10 ahead: from pixel to floor, and from there, rising as steeply as it fell, to the wall.
    let quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| [Triangle { v: [a, b, c] }, Triangle { v: [a, c, d] }];
    let point = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let floor = quad(point(-50., 0., 1.), point(50., 0., 1.), point(50., 0., -10.), point(-50., 0., -10.));
    let wall =
        quad(point(-50., 0., -10.), point(50., 0., -10.), point(50., 50., -10.), point(-50., 50., -10.));
    let eye = Vec3::Y * 2.0;
    let camera = Camera { eye, target: eye + Vec3::NEG_Z, up: Vec3::Y, vertical_fov_degrees: 80.0 };
    let world = World::new([floor, wall].concat(), camera, 200);
    let gbuffer = world.gbuffer();
    let screen = Screen::new(&camera, 200);
    let surfaces = [[ReflectionRays::Mirror; 2], [ReflectionRays::None; 2]].concat();
    for march in [March::LINEAR, March::HIERARCHICAL] {
        let reflections = Reflections::new(&gbuffer, settings(&surfaces, Some(march)));
        let (mut hits, mut exact) = (0, 0);
        for pixel in 0..gbuffer.pixels() {
            let outcome = reflections.outcomes()[pixel as usize];
            if gbuffer.triangle(pixel).is_none_or(|triangle| triangle > 1) {
                assert_eq!(outcome, Outcome::Fallback, "the wall is rough");
                continue;
            }
            let direction = world.view().primary_ray(pixel % 200, pixel / 200).direction;
            let mirrored_eye = Vec3::NEG_Y * 2.0;
            let seen = mirrored_eye + (direction * Vec3::new(1.0, -1.0, 1.0)) * (10.0 / -direction.z);
            match (outcome, screen.pixel(seen.as_dvec3())) {
                (Outcome::ScreenHit { x, y }, Some(expected)) => {
                    hits += 1;
                    exact += u32::from([x, y] == expected);
                    let off = x.abs_diff(expected[0]).max(y.abs_diff(expected[1]));
                    assert!(off <= 1, "{march:?}: {x}, {y} instead of {expected:?}");
                }
                (Outcome::Query, None) => {}
                (outcome, expected) => panic!("{march:?}, pixel {pixel}: {outcome:?}, expected {expected:?}"),
            }
        }
        assert!(hits > 10_000 && exact * 100 > hits * 99, "{march:?}: {exact} of {hits} are exact");
    }
}

#[test]
fn the_g_buffer_shows_what_primary_rays_hit_at_their_depth() {
    let world = World::builtin("cornell", 50);
    let gbuffer = world.gbuffer();
    let screen = Screen::new(&world.camera, 50);
    let mut sky = 0;
    for pixel in 0..gbuffer.pixels() {
        let ray = world.view().primary_ray(pixel % 50, pixel / 50);
        let hit = closest(&world, &ray);
        assert_eq!(gbuffer.triangle(pixel), hit.is_hit().then_some(hit.primitive));
        let depth = f64::from(gbuffer.depth().depth(0, pixel % 50, pixel / 50));
        if !hit.is_hit() {
            sky += 1;
            assert_eq!(depth, f64::INFINITY);
            continue;
        }
        let expected = screen.depth((ray.origin + ray.direction * hit.t).as_dvec3());
        assert!((depth - expected).abs() < 1e-5 * expected, "{depth}, expected {expected}");
    }
    assert!((1..2000).contains(&sky), "{sky}");
}
