//! Do two levels find the hits of f64, of a loop over all instances, and of one tree over the flattened scene?

mod two_level_support;

use glam::{Affine3A, Vec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use scenes::{Instance, Triangle};
use tracer::bvh::{self, Bvh, BvhOptions};
use tracer::two_level::{MaskedInstance, TwoLevel};
use tracer::wide::short_stack::DRIVER_ENTRIES;
use tracer::wide::{NodeFormat, WideBvh};
use tracer::{Hit, PlaneSlack, Query, Ray, RayTriangle, Silent, View, WatertightTriangle};
use two_level_support::{COSTS, Scene, Space, Verdict, aims, scene, transform, verdict};

/// Every triangle of every visible instance, in the arithmetic of the traversal: the slow and obvious twin.
fn each_instance<P: RayTriangle>(scene: &Scene, structure: &TwoLevel<P>, ray: &Ray, cull_mask: u8) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let mut primitive = 0;
    for (number, instance) in (0..).zip(&scene.instances) {
        let object_ray = structure.object_ray(number, ray);
        for triangle in &scene.meshes[instance.placement.mesh as usize] {
            if instance.mask & cull_mask != 0
                && let Some((t, u, v)) = P::from(triangle).test(P::prepare(&object_ray), best.t)
                && (t < best.t || primitive < best.primitive)
            {
                best = Hit { t, u, v, primitive };
            }
            primitive += 1;
        }
    }
    best
}

/// Whether f32 places the hit as exactly as planes of boxes are thick, which is what makes trees find it: the triangle is not seen
/// edge on. `ray` and `slack` are those of the tree that holds it, with triangles in mesh or world space alike.
fn is_placed(scene: &Scene, world_ray: &Ray, hit: &Hit, tree_of: impl Fn(u32) -> (Ray, PlaneSlack)) -> bool {
    let instance_of = || {
        let mut first = 0;
        scene.instances.iter().position(|instance| {
            first += scene.meshes[instance.placement.mesh as usize].len();
            first > hit.primitive as usize
        })
    };
    !hit.is_hit() || {
        let (instance, triangle) = scene.primitives()[hit.primitive as usize];
        let (ray, slack) = tree_of(instance_of().expect("of some instance") as u32);
        verdict(instance, &triangle, world_ray, Space::Object).is_some_and(|verdict| {
            verdict.error[0] * f64::from(ray.direction.length()) <= f64::from(slack.at(ray.origin))
        })
    }
}

/// What f64 says of every primitive that a ray may see, for a structure that works in `space`.
fn verdicts(scene: &Scene, ray: &Ray, cull_mask: u8, space: Space) -> Vec<Option<Verdict>> {
    let judge = |(instance, triangle): (&MaskedInstance, Triangle)| {
        (instance.mask & cull_mask != 0).then(|| verdict(instance, &triangle, ray, space)).flatten()
    };
    scene.primitives().into_iter().map(judge).collect()
}

/// Checks a closest hit: where f64 has it, up to the error of f32, and no farther than any hit that is beyond doubt.
fn check_closest(hit: &Hit, ray: &Ray, verdicts: &[Option<Verdict>]) -> Result<(), TestCaseError> {
    if hit.is_hit()
        && let Some(verdict) = verdicts[hit.primitive as usize]
    {
        prop_assert!(verdict.is_possible(ray), "{hit:?} against {verdict:?}");
        for (found, (at, error)) in
            [hit.t, hit.u, hit.v].into_iter().zip(verdict.at.into_iter().zip(verdict.error))
        {
            prop_assert!((f64::from(found) - at).abs() <= error, "{hit:?} against {verdict:?}");
        }
    }
    for verdict in verdicts.iter().flatten().filter(|verdict| verdict.is_certain(ray)) {
        prop_assert!(
            hit.is_hit() && f64::from(hit.t) <= verdict.at[0] + verdict.error[0],
            "{hit:?} hides {verdict:?}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn trees_lose_no_hit_of_a_loop_over_all_instances(scene in scene(transform()), aims in aims(), cull_mask: u8) {
        let structure = TwoLevel::build(&scene.meshes, &scene.instances, COSTS).unwrap();
        let watertight = TwoLevel::<WatertightTriangle>::build_for(&scene.meshes, &scene.instances, COSTS).unwrap();
        let trees: Vec<Bvh> = scene.meshes.iter().map(|mesh| Bvh::build(mesh, &BvhOptions::MOBILE)).collect();
        let flattened = scene.flattened();
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            for cull_mask in [u8::MAX, cull_mask, 0] {
                let expected = each_instance(&scene, &structure, &ray, cull_mask);
                let hit = structure.trace(&ray, Query::Closest, cull_mask, &mut Silent);
                let is_placed = |hit| is_placed(&scene, &ray, hit, |instance| {
                    let mesh = scene.instances[instance as usize].placement.mesh;
                    (structure.object_ray(instance, &ray), *trees[mesh as usize].plane_slack())
                });
                if is_placed(&hit) && is_placed(&expected) {
                    prop_assert_eq!(hit, expected);
                }
                let any = structure.trace(&ray, Query::Any, cull_mask, &mut Silent);
                prop_assert!(expected.is_hit() || !any.is_hit());
                prop_assert!(any.is_hit() || !expected.is_hit() || !is_placed(&expected));
                let expected = each_instance(&scene, &watertight, &ray, cull_mask);
                prop_assert_eq!(watertight.trace(&ray, Query::Closest, cull_mask, &mut Silent), expected);
            }
        }
    }

    #[test]
    fn blases_of_any_width_and_format_have_the_hits_of_binary_ones(
        scene in scene(transform()), aims in aims(), cull_mask: u8
    ) {
        type Blases<const W: usize> = TwoLevel<WatertightTriangle, WideBvh<WatertightTriangle, W>>;
        let Scene { meshes, instances } = &scene;
        let binary = TwoLevel::<WatertightTriangle>::build_for(meshes, instances, COSTS).unwrap();
        let narrow = Blases::<4>::build_with(meshes, instances, COSTS, NodeFormat::Full4).unwrap();
        let wide = [NodeFormat::Full8, NodeFormat::Compressed8, NodeFormat::Adreno8]
            .map(|format| Blases::<8>::build_with(meshes, instances, COSTS, format).unwrap());
        let flattened = scene.flattened();
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            let expected = binary.trace(&ray, Query::Closest, cull_mask, &mut Silent);
            let is_hit = expected.is_hit();
            prop_assert_eq!(narrow.trace(&ray, Query::Closest, cull_mask, &mut Silent), expected);
            prop_assert_eq!(narrow.trace(&ray, Query::Any, cull_mask, &mut Silent).is_hit(), is_hit);
            for structure in &wide {
                prop_assert_eq!(structure.trace(&ray, Query::Closest, cull_mask, &mut Silent), expected);
                prop_assert_eq!(structure.trace(&ray, Query::Any, cull_mask, &mut Silent).is_hit(), is_hit);
            }
        }
    }

    #[test]
    fn a_short_stack_of_any_size_has_the_hits_of_the_binary_stack(
        scene in scene(transform()), aims in aims(), cull_mask: u8
    ) {
        type Blases<const W: usize> = TwoLevel<WatertightTriangle, WideBvh<WatertightTriangle, W>>;
        let Scene { meshes, instances } = &scene;
        let binary = TwoLevel::<WatertightTriangle>::build_for(meshes, instances, COSTS).unwrap();
        let narrow = Blases::<4>::build_with(meshes, instances, COSTS, NodeFormat::Full4).unwrap();
        let wide = Blases::<8>::build_with(meshes, instances, COSTS, NodeFormat::Adreno8).unwrap();
        let flattened = scene.flattened();
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            let expected = binary.trace(&ray, Query::Closest, cull_mask, &mut Silent);
            for entries in 0..=DRIVER_ENTRIES {
                let of = |query| [
                    narrow.trace_short_stack(entries, &ray, query, cull_mask, &mut Silent),
                    wide.trace_short_stack(entries, &ray, query, cull_mask, &mut Silent),
                ];
                prop_assert_eq!(of(Query::Closest), [expected; 2], "{} entries", entries);
                prop_assert_eq!(of(Query::Any).map(|hit| hit.is_hit()), [expected.is_hit(); 2]);
            }
        }
    }

    #[test]
    fn hits_are_those_of_f64_and_of_one_tree_over_the_flattened_scene(
        scene in scene(transform()), aims in aims(), cull_mask: u8
    ) {
        let structure = TwoLevel::build(&scene.meshes, &scene.instances, COSTS).unwrap();
        let flattened = scene.flattened();
        let sees = |(index, (instance, _)): (u32, (&MaskedInstance, Triangle))| {
            (instance.mask & cull_mask != 0).then_some(index)
        };
        let visible: Vec<u32> = (0..).zip(scene.primitives()).filter_map(sees).collect();
        let visible_triangles: Vec<Triangle> = visible.iter().map(|&index| flattened[index as usize]).collect();
        let one_tree = Bvh::build(&visible_triangles, &BvhOptions::MOBILE);
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            let hit = structure.trace(&ray, Query::Closest, cull_mask, &mut Silent);
            let in_object = verdicts(&scene, &ray, cull_mask, Space::Object);
            check_closest(&hit, &ray, &in_object)?;

            let mut flat = bvh::stack::trace(&one_tree, &ray, Query::Closest, &mut Silent);
            if flat.is_hit() {
                flat.primitive = visible[flat.primitive as usize];
            }
            let in_world = verdicts(&scene, &ray, cull_mask, Space::World);
            check_closest(&flat, &ray, &in_world)?;

            // Two primitives may be swapped where their distances are within the errors of both.
            if hit.is_hit() && flat.is_hit() && hit.primitive != flat.primitive {
                let error = |hit: &Hit| {
                    let index = hit.primitive as usize;
                    in_object[index].map_or(f64::INFINITY, |verdict| verdict.error[0])
                        + in_world[index].map_or(f64::INFINITY, |verdict| verdict.error[0])
                };
                let doubtful = |hit: &Hit| {
                    let index = hit.primitive as usize;
                    ![in_object[index], in_world[index]].iter().all(|v| v.is_some_and(|v| v.is_certain(&ray)))
                };
                let apart = (f64::from(hit.t) - f64::from(flat.t)).abs();
                prop_assert!(
                    doubtful(&hit) || doubtful(&flat) || apart <= error(&hit) + error(&flat),
                    "{hit:?} and {flat:?}"
                );
            }
        }
    }

    #[test]
    fn identities_change_no_bit_of_the_hits_of_the_flattened_scene(
        scene in scene(Just(Affine3A::IDENTITY)), aims in aims()
    ) {
        let instances: Vec<_> = scene.instances.iter().map(|instance| instance.placement.into()).collect();
        let structure = TwoLevel::build(&scene.meshes, &instances, COSTS).unwrap();
        let flattened = scene.flattened();
        let one_tree = Bvh::build(&flattened, &BvhOptions::MOBILE);
        let bits = |hit: Hit| ([hit.t, hit.u, hit.v].map(f32::to_bits), hit.primitive);
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            let hit = structure.trace(&ray, Query::Closest, u8::MAX, &mut Silent);
            let expected = bvh::stack::trace(&one_tree, &ray, Query::Closest, &mut Silent);
            let is_placed = |hit| is_placed(&scene, &ray, hit, |_| (ray, *one_tree.plane_slack()));
            if is_placed(&hit) && is_placed(&expected) {
                prop_assert_eq!(bits(hit), bits(expected));
            }
        }
    }

    #[test]
    fn any_bits_as_a_ray_end(scene in scene(transform()), bits in any::<[u32; 8]>()) {
        let f = bits.map(f32::from_bits);
        let ray = Ray {
            origin: Vec3::new(f[0], f[1], f[2]),
            t_min: f[3],
            direction: Vec3::new(f[4], f[5], f[6]),
            t_max: f[7],
        };
        let structure = TwoLevel::build(&scene.meshes, &scene.instances, COSTS).unwrap();
        for query in [Query::Closest, Query::Any] {
            structure.trace(&ray, query, u8::MAX, &mut Silent);
        }
    }
}

/// The tests above allow for doubt; here is how seldom there is any, where hits are many and transforms turn, stretch and mirror.
#[test]
fn nearly_all_hits_are_beyond_doubt_and_name_the_primitive_of_the_flattened_scene() {
    let mut runner = TestRunner::deterministic();
    let (mut hits, mut certain, mut alike) = (0, 0, 0);
    for _ in 0..300 {
        let (scene, aims) = (scene(transform()), aims()).new_tree(&mut runner).unwrap().current();
        let instances: Vec<_> = scene.instances.iter().map(|instance| instance.placement.into()).collect();
        let structure = TwoLevel::build(&scene.meshes, &instances, COSTS).unwrap();
        let flattened = scene.flattened();
        let one_tree = Bvh::build(&flattened, &BvhOptions::MOBILE);
        for ray in aims.iter().map(|aim| aim.ray(&flattened)) {
            let hit = structure.trace(&ray, Query::Closest, u8::MAX, &mut Silent);
            if hit.is_hit() {
                let flat = bvh::stack::trace(&one_tree, &ray, Query::Closest, &mut Silent);
                let is_certain = |hit: &Hit| {
                    scene.primitives().get(hit.primitive as usize).is_none_or(|(instance, triangle)| {
                        verdict(instance, triangle, &ray, Space::World).is_some_and(|v| v.is_certain(&ray))
                    })
                };
                let both_certain = is_certain(&hit) && is_certain(&flat);
                hits += 1;
                certain += u32::from(both_certain);
                alike += u32::from(both_certain && flat.primitive == hit.primitive);
            }
        }
    }
    // A third of the rays go for edges and corners.
    assert!(hits > 2000 && certain > hits / 2, "{certain} of {hits}");
    // The rest are triangles of one plane, at one distance.
    assert!(alike > certain * 98 / 100, "{alike} of {certain}");
}

/// Flat squares, so that the outline of each lies on the faces of its box, wherever rounding puts either.
#[test]
fn hits_on_the_outline_of_an_instance_are_not_lost_by_its_box() {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let square = |corners: [[f32; 2]; 3]| Triangle { v: corners.map(|[x, y]| Vec3::new(x, y, 0.0)) };
    let mesh =
        vec![square([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), square([[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]])];
    let instances: Vec<MaskedInstance> = (0..200)
        .map(|number| {
            let mut signed = || 2.0 * random() - 1.0;
            let size = Vec3::new(signed(), signed(), 1.0) * 3.0;
            let place = 1000.0 * Vec3::new(signed(), signed(), signed());
            let turned =
                if number % 2 == 0 { Affine3A::IDENTITY } else { Affine3A::from_rotation_x(signed()) };
            let transform = Affine3A::from_translation(place) * turned * Affine3A::from_scale(size);
            MaskedInstance::from(Instance { mesh: 0, transform })
        })
        .collect();
    let scene = Scene { meshes: vec![mesh], instances };
    let structure = TwoLevel::build(&scene.meshes, &scene.instances, COSTS).unwrap();
    let mut hits = 0;
    for instance in scene.instances.iter().cycle().take(20_000) {
        let target = instance.placement.transform_point(Vec3::new(
            if random() < 0.5 { 0.0 } else { 1.0 },
            random(),
            0.0,
        ));
        // From near zero, where coordinates of the origin are finer than those of the square.
        let origin = Vec3::new(random(), random(), random());
        let ray = Ray::new(origin, target - origin);
        let expected = each_instance(&scene, &structure, &ray, u8::MAX);
        assert_eq!(structure.trace(&ray, Query::Closest, u8::MAX, &mut Silent), expected, "{ray:?}");
        hits += u32::from(expected.is_hit());
    }
    // About half of them are rounded to the inside.
    assert!((5_000..15_000).contains(&hits), "{hits}");
}

#[test]
fn built_in_scenes_of_several_meshes_have_the_hits_of_one_tree_from_their_cameras() {
    const EDGE: u32 = 96;
    for name in ["figure", "stadium"] {
        let scene = scenes::builtin(name).expect("built in");
        let meshes: Vec<Vec<Triangle>> = scene
            .meshes
            .iter()
            .map(|mesh| (0..mesh.triangles.len()).map(|index| mesh.triangle(index)).collect())
            .collect();
        let instances: Vec<MaskedInstance> = scene.instances.iter().copied().map(Into::into).collect();
        assert!(instances.len() > 1);
        let structure = TwoLevel::build(&meshes, &instances, COSTS).unwrap();
        let one_tree = Bvh::build(&scene.triangles(), &BvhOptions::MOBILE);
        let view = View::new(&scene.camera, EDGE, EDGE);
        let mut hits = 0;
        for (x, y) in (0..EDGE * EDGE).map(|pixel| (pixel % EDGE, pixel / EDGE)) {
            let ray = view.primary_ray(x, y);
            let expected = bvh::stack::trace(&one_tree, &ray, Query::Closest, &mut Silent);
            assert_eq!(
                structure.trace(&ray, Query::Closest, u8::MAX, &mut Silent),
                expected,
                "{name} {x} {y}"
            );
            hits += u32::from(expected.is_hit());
        }
        assert!(hits > EDGE * EDGE / 10, "{name}: {hits}");
    }
}
