//! Does each pixel's reflection come from where it should, and do queries in any order find what is left?

mod reflection_support;

use glam::Vec3;
use reflection_support::{World, settings};
use tracer::reflections::{
    March, MarchEnd, Outcome, ReflectionList, ReflectionRay, ReflectionTracer, Reflections,
};
use tracer::{
    AlphaMode, AlphaTests, BuildOptions, FrameTracer, Query, RayKind, RaySet, RaySetId, Rays, ReflectionRays,
    SceneIdentity, SecondaryRays, Silent, Step, TestedTriangles, Tile, TileSource, TraceWriter,
};

fn identity() -> SceneIdentity {
    SceneIdentity { name: "test".to_owned(), hash: 1 }
}

fn tiles(source: &impl TileSource) -> Vec<Tile> {
    let tile = |index| {
        let mut tile = Tile::default();
        source.tile(index, &mut tile).expect("a tile");
        tile
    };
    (0..source.header().frame.tiles()).map(tile).collect()
}

/// Surfaces of all kinds, in turn.
fn mixed(triangles: usize) -> Vec<ReflectionRays> {
    let of = |triangle: usize| match triangle % 3 {
        0 => ReflectionRays::Mirror,
        1 => ReflectionRays::Glossy(0.3),
        _ => ReflectionRays::None,
    };
    (0..triangles).map(of).collect()
}

/// The Cornell Box with masks on a quarter of its triangles.
fn masked(edge: u32) -> World {
    let world = World::builtin("cornell", edge);
    let tests =
        AlphaTests { mode: AlphaMode::AnyHit, tested: TestedTriangles::OnePairInFour, micromap: None };
    World { structure: world.structure.with_alpha(tests).expect("it has such triangles"), ..world }
}

#[test]
fn a_gbuffer_shows_what_masks_leave() {
    let (world, opaque) = (masked(70), World::builtin("cornell", 70));
    let (gbuffer, without) = (world.gbuffer(), opaque.gbuffer());
    let mut seen_through = 0;
    for pixel in 0..70 * 70 {
        let ray = world.view().primary_ray(pixel % 70, pixel / 70);
        let hit = world.structure.trace(&ray, Query::Closest, &mut Silent);
        assert_eq!(gbuffer.triangle(pixel), hit.is_hit().then_some(hit.primitive), "pixel {pixel}");
        seen_through += u32::from(gbuffer.triangle(pixel) != without.triangle(pixel));
    }
    assert!((100..2000).contains(&seen_through), "{seen_through}");
}

#[test]
fn rays_in_any_order_hit_what_the_frame_of_all_rays_hits() {
    check_orders(&World::builtin("cornell", 70));
    check_orders(&masked(70));
}

fn check_orders(world: &World) {
    let (gbuffer, surfaces) = (world.gbuffer(), mixed(world.triangles.len()));
    let lights = vec![Vec3::new(278.0, 500.0, 279.5), Vec3::new(100.0, 300.0, 100.0)];
    let options = BuildOptions::default();
    let secondary = SecondaryRays {
        seed: 5,
        samples: 2,
        reflections: Some(surfaces.clone()),
        lights: lights.clone(),
        ..SecondaryRays::default()
    };
    let rays = Rays::View { view: world.view(), width: 70, height: 70 };
    let frame = FrameTracer::new(&world.structure, &options, &world.triangles, identity(), rays, Vec::new())
        .with_secondary(secondary);
    // By pixel: the steps and hits of the first sample, and of its shadow rays.
    let mut expected = vec![Vec::new(); 70 * 70];
    for (index, tile) in (0..).zip(tiles(&frame)) {
        let rect = frame.header().frame.tile(index);
        for ray in 0..rect.width * rect.height {
            let (x, y) = (rect.x + ray % rect.width, rect.y + ray / rect.width);
            expected[(y * 70 + x) as usize] = steps_and_hits(&tile.ray_sets[1..4], ray as usize);
        }
    }
    let reflections = Reflections::new(&gbuffer, settings(&surfaces, None));
    let list = reflections.rays();
    let count = list.len() as u32;
    assert!(count > 2000 && list.is_sorted_by(|a, b| a.pixel < b.pixel));
    let orders: [Vec<u32>; 3] = [
        (0..count).collect(),
        (0..count).rev().collect(),
        (0..count).map(|place| (u64::from(place) * 7919 % u64::from(count)) as u32).collect(),
    ];
    for order in orders {
        let tracer = reflection_tracer(world, list, order, &lights).expect("each ray once");
        assert_eq!(tracer.header().frame.rays(), u64::from(count));
        let mut place = 0;
        for tile in tiles(&tracer) {
            for ray in 0..tile.ray_sets[0].ends.len() {
                let found = steps_and_hits(&tile.ray_sets, ray);
                assert!(
                    found == expected[tracer.pixel(place).expect("every place has a ray") as usize],
                    "place {place}"
                );
                place += 1;
            }
        }
        assert_eq!(place, count);
        assert_eq!(tracer.stalls(), 0);
    }
}

fn steps_and_hits(sets: &[RaySet], ray: usize) -> Vec<(Vec<Step>, u32)> {
    sets.iter().map(|set| (set.steps[set.range(ray)].to_vec(), set.hits[ray])).collect()
}

fn reflection_tracer<'a>(
    world: &'a World,
    rays: &'a [ReflectionRay],
    order: Vec<u32>,
    lights: &[Vec3],
) -> Result<ReflectionTracer<'a>, tracer::Error> {
    let World { structure, triangles, .. } = world;
    let options = BuildOptions::default();
    ReflectionTracer::new(structure, &options, triangles, identity(), rays, order, lights.to_vec())
}

#[test]
fn an_order_has_each_ray_once() {
    let world = World::builtin("cornell", 4);
    let (gbuffer, mirrors) = (world.gbuffer(), world.mirrors());
    let reflections = Reflections::new(&gbuffer, settings(&mirrors, None));
    let rays = &reflections.rays()[..3];
    for (order, expected) in [
        (vec![0, 1, 3], "ray 3 at place 2"),
        (vec![0, 1, 0], "ray 0 at place 2"),
        (vec![2, 1], "lacks ray 0 of 3"),
        (vec![0, 1, 2, 2], "ray 2 at place 3"),
    ] {
        let error = reflection_tracer(&world, rays, order, &[]).err().expect("refused").to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert!(reflection_tracer(&world, rays, vec![2, 0, 1], &[]).is_ok());
    let none = reflection_tracer(&world, &[], Vec::new(), &[]).expect("no rays in order");
    assert!(tiles(&none).is_empty());
}

#[test]
fn a_list_of_reflection_rays_has_no_primary_rays_and_a_trace_file_says_so() {
    let world = World::builtin("cornell", 8);
    let (gbuffer, mirrors) = (world.gbuffer(), world.mirrors());
    let reflections = Reflections::new(&gbuffer, settings(&mirrors, None));
    let order = (0..reflections.rays().len() as u32).collect();
    let tracer = reflection_tracer(&world, reflections.rays(), order, &[Vec3::Y; 2]).expect("each ray once");
    let sets = &tracer.header().ray_sets;
    let set = |kind, light| RaySetId { kind, sample: 0, light };
    let shadows = [0, 1].map(|light| set(RayKind::ReflectionShadow, light));
    assert_eq!(sets[..], [set(RayKind::Reflection, 0), shadows[0], shadows[1]]);
    assert_eq!([0, 1, 2].map(|place: usize| sets[place].source(sets)), [None, Some(0), Some(0)]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("reflections.rbt");
    let refused = TraceWriter::create(&path, tracer.header(), tracer.topology()).err().expect("refused");
    assert!(
        refused.to_string().contains("reflection rays of sample 0 without the rays before them"),
        "{refused}"
    );
}

#[test]
fn outcomes_are_those_of_surfaces_and_marches_and_the_same_on_any_number_of_threads() {
    let world = World::builtin("atrium", 100);
    let surfaces = mixed(world.triangles.len());
    let on_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let gbuffer = world.gbuffer();
            let reflections = Reflections::new(&gbuffer, settings(&surfaces, Some(March::HIERARCHICAL)));
            (gbuffer.depth().clone(), reflections.outcomes().to_vec(), reflections.rays().to_vec())
        })
    };
    let (depth, outcomes, rays) = on_threads(1);
    assert!((depth, outcomes.clone(), rays.clone()) == on_threads(3));

    let gbuffer = world.gbuffer();
    let reflections = Reflections::new(&gbuffer, settings(&surfaces, Some(March::HIERARCHICAL)));
    let mut queries = rays.iter();
    let mut seen = [0; 4];
    for (pixel, outcome) in (0..).zip(outcomes) {
        let march = reflections.march(pixel, |_, _, _| {});
        let surface = gbuffer.triangle(pixel).map(|triangle| surfaces[triangle as usize]);
        let kind = match (surface, march) {
            (None, None) => (0, Outcome::Sky),
            (Some(ReflectionRays::None), None) => (1, Outcome::Fallback),
            (Some(_), Some(MarchEnd::Hit { x, y })) => (2, Outcome::ScreenHit { x, y }),
            (Some(_), Some(MarchEnd::Miss { t })) => {
                let query = queries.next().expect("a query");
                assert_eq!((query.pixel, query.ray.t_min), (pixel, t));
                (3, Outcome::Query)
            }
            other => panic!("{other:?}"),
        };
        assert_eq!(outcome, kind.1);
        seen[kind.0] += 1;
    }
    assert!(queries.next().is_none());
    assert!(seen.iter().all(|&pixels| pixels > 100), "{seen:?}");
}
