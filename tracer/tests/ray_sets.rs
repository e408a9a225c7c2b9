//! Are the rays that follow a primary hit those that they should be, and do they hit what they should?

use glam::Vec3;
use scenes::{Camera, Triangle};
use std::collections::BTreeMap;
use tracer::{
    AccelerationStructure, BuildOptions, EncodedTile, FrameTracer, NO_HIT, NOT_CAST, Query, RayKind,
    RaySetId, Rays, ReflectionRays, SceneIdentity, SecondaryRays, SoftShadows, Tile, TileSource, TraceFile,
    TraceWriter, Traversal, View,
};

/// A scene seen by a camera.
struct World {
    triangles: Vec<Triangle>,
    camera: Camera,
    size: u32,
}

impl World {
    fn cornell(size: u32) -> Self {
        let scene = scenes::builtin("cornell").expect("a built-in scene");
        Self { triangles: scene.triangles(), camera: scene.camera, size }
    }

    fn seen(triangles: Vec<Triangle>, eye: Vec3, target: Vec3) -> Self {
        let up = (target - eye).any_orthogonal_vector();
        Self { triangles, camera: Camera { eye, target, up, vertical_fov_degrees: 40.0 }, size: 32 }
    }

    /// Calls `use_it` with a tracer of these rays.
    fn traced<R>(
        &self,
        traversal: Traversal,
        secondary: SecondaryRays,
        use_it: impl FnOnce(&FrameTracer<'_>) -> R,
    ) -> R {
        let options = BuildOptions::default();
        let structure =
            AccelerationStructure::build(&self.triangles, traversal, &options).expect("it builds");
        let identity = SceneIdentity { name: "test".to_owned(), hash: 1 };
        let view = View::new(&self.camera, self.size, self.size);
        let rays = Rays::View { view, width: self.size, height: self.size };
        use_it(
            &FrameTracer::new(&structure, &options, &self.triangles, identity, rays, Vec::new())
                .with_secondary(secondary),
        )
    }

    /// All hits of a frame, set by set.
    fn hits(&self, traversal: Traversal, secondary: SecondaryRays) -> BTreeMap<String, Vec<u32>> {
        self.traced(traversal, secondary, |tracer| {
            let mut hits = BTreeMap::<String, Vec<u32>>::new();
            for tile in tiles(tracer) {
                for (id, set) in tracer.header().ray_sets.iter().zip(&tile.ray_sets) {
                    hits.entry(name(*id)).or_default().extend(&set.hits);
                }
            }
            hits
        })
    }
}

fn name(RaySetId { kind, sample, light }: RaySetId) -> String {
    format!("{} {sample} {light}", kind.name())
}

fn tiles(source: &impl TileSource) -> Vec<Tile> {
    let tile = |index| {
        let mut tile = Tile::default();
        source.tile(index, &mut tile).expect("a tile");
        tile
    };
    (0..source.header().frame.tiles()).map(tile).collect()
}

fn quad(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [Triangle; 2] {
    [Triangle { v: [a, b, c] }, Triangle { v: [a, c, d] }]
}

/// A square of `half` the edge around the origin, perpendicular to y.
fn plane(half: f32) -> Vec<Triangle> {
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    quad(corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)).into()
}

/// A closed sphere around the origin.
fn sphere(radius: f32) -> Vec<Triangle> {
    let steps = 24;
    let corner = |ring: usize, sector: usize| {
        let (theta, phi) = (
            std::f32::consts::PI * ring as f32 / steps as f32,
            std::f32::consts::TAU * (sector % steps) as f32 / steps as f32,
        );
        let around = if ring == 0 || ring == steps { 0.0 } else { theta.sin() };
        Vec3::new(around * phi.cos(), theta.cos(), around * phi.sin()) * radius
    };
    let parts = (0..steps).flat_map(|ring| (0..steps).map(move |sector| (ring, sector)));
    let parts = parts.flat_map(|(ring, sector)| {
        quad(
            corner(ring, sector),
            corner(ring + 1, sector),
            corner(ring + 1, sector + 1),
            corner(ring, sector + 1),
        )
    });
    parts.filter(|triangle| !triangle.is_degenerate()).collect()
}

/// Every kind of ray, at a box with mirrors, glossy and rough surfaces.
fn all_kinds(triangles: usize, samples: u32) -> SecondaryRays {
    let lights = vec![Vec3::new(278.0, 500.0, 279.5), Vec3::new(100.0, 300.0, 100.0)];
    let of = |triangle: usize| match triangle % 3 {
        0 => ReflectionRays::Mirror,
        1 => ReflectionRays::Glossy(0.3),
        _ => ReflectionRays::None,
    };
    SecondaryRays {
        seed: 3,
        samples,
        soft_shadows: Some(SoftShadows { lights: lights.clone(), radius: 40.0 }),
        reflections: Some((0..triangles).map(of).collect()),
        ambient_occlusion: Some(100.0),
        diffuse: true,
        lights,
    }
}

fn cast(hits: &[u32]) -> usize {
    hits.iter().filter(|&&hit| hit != NOT_CAST).count()
}

#[test]
fn all_trees_and_traversals_agree_on_every_ray() {
    let world = World::cornell(24);
    let rays = all_kinds(world.triangles.len(), 2);
    let expected = world.hits(Traversal::BvhStack, rays.clone());
    assert_eq!(expected.len(), 1 + 2 * (2 + 3 + 1 + 3));
    for traversal in Traversal::ALL {
        let hits = world.hits(traversal, rays.clone());
        for (set, expected) in &expected {
            let any_hit = ["shadow", "occlusion"].iter().any(|part| set.contains(part));
            // Which triangle is found first is the tree's affair; whether there is one is not.
            let answers = |hits: &[u32]| -> Vec<u32> {
                hits.iter().map(|&hit| if any_hit && hit < NOT_CAST { 0 } else { hit }).collect()
            };
            assert_eq!(answers(&hits[set]), answers(expected), "{set} of {}", traversal.name());
        }
    }
}

#[test]
fn every_sample_is_another_ray_and_the_seed_draws_other_ones() {
    let world = World::cornell(32);
    let rays = all_kinds(world.triangles.len(), 2);
    let hits = world.hits(Traversal::BvhStack, rays.clone());
    assert_eq!(hits, world.hits(Traversal::BvhStack, rays.clone()), "the same again");
    let other = world.hits(Traversal::BvhStack, SecondaryRays { seed: 4, ..rays });
    assert_eq!(hits["primary 0 0"], other["primary 0 0"]);
    for kind in ["diffuse", "ambient-occlusion", "reflection"] {
        assert_ne!(hits[&format!("{kind} 0 0")], hits[&format!("{kind} 1 0")], "{kind}");
        assert_ne!(hits[&format!("{kind} 0 0")], other[&format!("{kind} 0 0")], "{kind}");
    }
}

#[test]
fn each_hit_of_a_reflection_or_diffuse_ray_sends_one_shadow_ray_to_each_light_and_a_miss_none() {
    let world = World::cornell(32);
    let hits = world.hits(Traversal::KdStack, all_kinds(world.triangles.len(), 2));
    let mut missed = 0;
    for (kind, sample) in [("reflection", 0), ("reflection", 1), ("diffuse", 0), ("diffuse", 1)] {
        let first = &hits[&format!("{kind} {sample} 0")];
        let found = first.iter().filter(|&&hit| hit < NOT_CAST).count();
        missed += first.iter().filter(|&&hit| hit == NO_HIT).count();
        assert!(found > 0);
        for light in 0..2 {
            world.traced(Traversal::KdStack, all_kinds(world.triangles.len(), 2), |tracer| {
                let shadows: RayKind =
                    if kind == "diffuse" { RayKind::DiffuseShadow } else { RayKind::ReflectionShadow };
                let id = RaySetId { kind: shadows, sample, light };
                let place = tracer.header().ray_sets.iter().position(|set| *set == id).expect("a set");
                let traced = tiles(tracer).into_iter().map(|tile| {
                    let set = &tile.ray_sets[place];
                    (0..set.ends.len()).filter(|&ray| !set.range(ray).is_empty()).count()
                });
                assert_eq!(traced.sum::<usize>(), found, "{kind} {sample} {light}");
            });
        }
    }
    assert!(missed > 0, "the box is open to one side");
}

#[test]
fn only_surfaces_of_the_right_kind_reflect_and_mirrors_once() {
    let world = World::cornell(32);
    let rays = all_kinds(world.triangles.len(), 2);
    let surfaces = rays.reflections.clone().expect("there are");
    let hits = world.hits(Traversal::BvhStack, rays);
    let mut seen = [0; 3];
    for (ray, &hit) in hits["primary 0 0"].iter().enumerate() {
        let sent = [0, 1].map(|sample| hits[&format!("reflection {sample} 0")][ray] != NOT_CAST);
        let surface = (hit != NO_HIT).then(|| surfaces[hit as usize]);
        let expected = match surface {
            Some(ReflectionRays::Mirror) => [true, false],
            Some(ReflectionRays::Glossy(_)) => [true, true],
            Some(ReflectionRays::None) => [false, false],
            // A miss: not a ray that was due and left out, but none at all.
            None => [true, true],
        };
        assert_eq!(sent, expected, "{surface:?}");
        seen[surface.map_or(0, |surface| match surface {
            ReflectionRays::Mirror => 0,
            ReflectionRays::Glossy(_) => 1,
            ReflectionRays::None => 2,
        })] += 1;
    }
    assert!(seen.iter().all(|&count| count > 50), "{seen:?}");
}

#[test]
fn a_frame_of_mirrors_has_one_sample_whatever_is_asked_for() {
    let rays = SecondaryRays {
        samples: 8,
        reflections: Some(vec![ReflectionRays::Mirror, ReflectionRays::None]),
        ..SecondaryRays::default()
    };
    assert_eq!(rays.ray_sets(), [RaySetId { kind: RayKind::Reflection, sample: 0, light: 0 }]);
}

#[test]
fn a_mirror_that_faces_the_eye_shows_what_is_behind_the_eye() {
    // A mirror at y = 0 seen from above; a wall above the eye fills the sky.
    let mut triangles = plane(10.0);
    let wall = |x: f32, z: f32| Vec3::new(x * 1e3, 9.0, z * 1e3);
    triangles.extend(quad(wall(-1.0, -1.0), wall(1.0, -1.0), wall(1.0, 1.0), wall(-1.0, 1.0)));
    let world = World::seen(triangles, Vec3::Y * 3.0, Vec3::ZERO);
    let mirrors =
        vec![ReflectionRays::Mirror, ReflectionRays::Mirror, ReflectionRays::None, ReflectionRays::None];
    let rays = SecondaryRays { samples: 1, reflections: Some(mirrors), ..SecondaryRays::default() };
    let hits = world.hits(Traversal::BvhStack, rays);
    assert!(hits["primary 0 0"].iter().all(|&hit| hit < 2), "the mirror fills the image");
    assert!(hits["reflection 0 0"].iter().all(|&hit| hit == 2 || hit == 3), "and shows the wall alone");
}

fn occlusion(world: &World, radius: f32, traversal: Traversal) -> (usize, usize) {
    let rays = SecondaryRays { samples: 16, ambient_occlusion: Some(radius), ..SecondaryRays::default() };
    let hits = world.hits(traversal, rays);
    let due = hits["primary 0 0"].iter().filter(|&&hit| hit != NO_HIT).count() * 16;
    let occluded = hits.iter().filter(|(set, _)| set.starts_with("ambient"));
    (occluded.map(|(_, hits)| hits.iter().filter(|&&hit| hit < NOT_CAST).count()).sum(), due)
}

#[test]
fn inside_a_closed_sphere_everything_is_occluded_unless_rays_are_too_short() {
    for scale in [1e-3, 1.0, 1e4] {
        let world = World::seen(sphere(scale), Vec3::ZERO, Vec3::new(0.3, 1.0, -0.2) * scale);
        for traversal in [Traversal::BvhStack, Traversal::KdStack] {
            let (occluded, rays) = occlusion(&world, 3.0 * scale, traversal);
            assert_eq!((occluded, rays), (16 * 1024, 16 * 1024), "scale {scale}");
            // A ray at cosine c from inside leaves a sphere of radius 1 after 2 c: half of all are longer than sqrt 2.
            let (occluded, _) = occlusion(&world, 2.0_f32.sqrt() * scale, traversal);
            let share = occluded as f64 / rays as f64;
            assert!((share - 0.5).abs() < 0.03, "scale {scale}: {share}");
        }
    }
}

#[test]
fn a_lone_plane_occludes_nothing() {
    for (eye, half) in
        [(Vec3::new(0.5, 2.0, 0.3), 50.0), (Vec3::new(3.0, 0.02, 1.0), 1e3), (-Vec3::Y * 0.01, 0.01)]
    {
        let world = World::seen(plane(half), eye, Vec3::ZERO);
        for traversal in [Traversal::BvhStack, Traversal::KdBacktrack] {
            let (occluded, rays) = occlusion(&world, 1e6, traversal);
            assert!(rays > 0);
            assert_eq!(occluded, 0, "seen from {eye}");
        }
    }
}

#[test]
fn a_soft_shadow_falls_off_where_the_light_is_partly_hidden() {
    // A light of radius 1 at height 8 over the edge of a half-plane at height 4: its penumbra on the ground is 2 wide to each side.
    let mut triangles = plane(20.0);
    let roof = |x: f32, z: f32| Vec3::new(x * 1e3, 4.0, z * 1e3);
    triangles.extend(quad(roof(0.0, -1.0), roof(1.0, -1.0), roof(1.0, 1.0), roof(0.0, 1.0)));
    let eye = Vec3::new(0.0, 3.5, 0.0);
    let world = World::seen(triangles, eye, Vec3::ZERO);
    let lights = vec![Vec3::Y * 8.0];
    let rays = SecondaryRays {
        samples: 32,
        soft_shadows: Some(SoftShadows { lights, radius: 1.0 }),
        ..SecondaryRays::default()
    };
    let hits = world.hits(Traversal::BvhStack, rays);
    let view = View::new(&world.camera, 32, 32);
    let mut by_side = [0; 3];
    for ray in 0..32 * 32_usize {
        let primary = view.primary_ray(ray as u32 % 32, ray as u32 / 32);
        let x = primary.origin.x - primary.direction.x * primary.origin.y / primary.direction.y;
        let soft = hits.iter().filter(|(set, _)| set.starts_with("soft"));
        let hidden = soft.filter(|(_, hits)| hits[ray] < NOT_CAST).count();
        match x {
            x if x < -1.05 => assert_eq!(hidden, 0, "lit at {x}"),
            x if x > 1.05 => assert_eq!(hidden, 32, "dark at {x}"),
            x if x.abs() < 0.2 => assert!((5..28).contains(&hidden), "half hidden at {x}: {hidden}"),
            _ => {}
        }
        by_side[(x > -1.05) as usize + (x > 1.05) as usize] += 1;
    }
    assert!(by_side.iter().all(|&count| count > 20), "{by_side:?}");
}

#[test]
fn rays_to_points_beyond_the_numbers_are_not_cast() {
    let world = World::seen(plane(5.0), Vec3::Y * 3.0, Vec3::ZERO);
    let far = SoftShadows { lights: vec![Vec3::splat(f32::MAX)], radius: f32::MAX };
    let rays = SecondaryRays { samples: 1, soft_shadows: Some(far), ..SecondaryRays::default() };
    let hits = world.hits(Traversal::BvhStack, rays);
    let (due, cast) = (cast(&hits["primary 0 0"]), cast(&hits["soft-shadow 0 0"]));
    assert!(cast < due, "{cast} of {due}");
}

#[test]
fn a_trace_file_gives_back_every_kind_of_ray() {
    let world = World::cornell(40);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("all.rbt");
    for traversal in [Traversal::BvhStack, Traversal::KdPushDown { short_stack: 0 }, Traversal::GridDda] {
        world.traced(traversal, all_kinds(world.triangles.len(), 2), |tracer| {
            let kinds: Vec<_> = tracer.header().ray_sets.iter().map(|set| set.kind).collect();
            assert!(RayKind::ALL.iter().all(|kind| *kind == RayKind::Shadow || kinds.contains(kind)));
            let mut writer =
                TraceWriter::create(&path, tracer.header(), tracer.topology()).expect("it opens");
            let expected = tiles(tracer);
            for tile in &expected {
                writer
                    .write_tile(&EncodedTile::new(tile, tracer.header()).expect("it fits"))
                    .expect("written");
            }
            writer.finish(tracer.stalls()).expect("it is written");
            let file = TraceFile::open(&path).expect("it is read");
            assert_eq!(file.header(), tracer.header());
            assert!(expected == tiles(&file), "{}", traversal.name());
            let not_cast = expected.iter().flat_map(|tile| &tile.ray_sets).flat_map(|set| &set.hits);
            assert!(not_cast.filter(|&&hit| hit == NOT_CAST).count() > 100);
        });
    }
}

#[test]
fn sets_without_the_rays_that_they_start_from_are_not_written() {
    let world = World::cornell(8);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("orphans.rbt");
    world.traced(Traversal::BvhStack, all_kinds(world.triangles.len(), 1), |tracer| {
        let mut header = tracer.header().clone();
        TraceWriter::create(&path, &header, tracer.topology()).expect("whole");
        header.ray_sets.retain(|set| set.kind != RayKind::Diffuse);
        let refused = TraceWriter::create(&path, &header, tracer.topology()).err().expect("refused");
        assert!(refused.to_string().contains("diffuse-shadow rays of sample 0 without"), "{refused}");
    });
}

#[test]
fn a_shadow_ray_that_searches_the_closest_hit_tells_the_same_light_in_no_fewer_steps() {
    let world = World::cornell(16);
    let lights = vec![Vec3::new(278.0, 500.0, 279.5)];
    let rays = SecondaryRays {
        samples: 1,
        soft_shadows: Some(SoftShadows { lights: lights.clone(), radius: 60.0 }),
        reflections: Some(vec![ReflectionRays::Mirror; world.triangles.len()]),
        ambient_occlusion: Some(150.0),
        diffuse: true,
        lights,
        ..SecondaryRays::default()
    };
    for traversal in Traversal::ALL {
        let options = BuildOptions::default();
        let structure =
            AccelerationStructure::build(&world.triangles, traversal, &options).expect("it builds");
        let traced = |query: Query| {
            let identity = SceneIdentity { name: "test".to_owned(), hash: 1 };
            let view =
                Rays::View { view: View::new(&world.camera, world.size, world.size), width: 16, height: 16 };
            let tracer =
                FrameTracer::new(&structure, &options, &world.triangles, identity, view, rays.lights.clone())
                    .with_secondary(rays.clone())
                    .with_shadow_query(query);
            assert_eq!(tracer.header().shadow_query, query);
            (tracer.header().ray_sets.clone(), tiles(&tracer))
        };
        let ((kinds, any), (_, closest)) = (traced(Query::Any), traced(Query::Closest));
        let mut saved = 0;
        for (any, closest) in any.iter().zip(&closest) {
            for ((any, closest), id) in any.ray_sets.iter().zip(&closest.ray_sets).zip(&kinds) {
                let to_light = matches!(
                    id.kind,
                    RayKind::Shadow
                        | RayKind::SoftShadow
                        | RayKind::ReflectionShadow
                        | RayKind::DiffuseShadow
                );
                if !to_light {
                    assert_eq!(any, closest, "{id:?}");
                    continue;
                }
                for ray in 0..any.ends.len() {
                    let lit = |hit: u32| (hit >= NOT_CAST).then_some(hit);
                    assert_eq!(lit(any.hits[ray]), lit(closest.hits[ray]), "{traversal:?} {id:?}");
                    let steps = [any, closest].map(|set| set.range(ray).len());
                    assert!(steps[0] <= steps[1], "{traversal:?} {id:?}: {steps:?}");
                    saved += steps[1] - steps[0];
                }
            }
        }
        assert!(saved > 0, "{traversal:?}");
    }
}
