//! Does a two-level structure number, count, hide and refuse as its documentation says?

use glam::{Affine3A, Vec3};
use scenes::{Instance, Triangle};
use tracer::two_level::{BottomLevel, MaskedInstance, TwoLevel};
use tracer::wide::{NodeFormat, WideBvh};
use tracer::{Hit, NodeFetch, Observer, Op, PreparedTriangle, Query, Ray, Silent, TopologyNode, WorkCounter};

const COSTS: [f64; 2] = [1.0, 1.0];

#[derive(Default)]
struct Steps(Vec<(Op, u32)>);

impl Observer for Steps {
    fn step(&mut self, op: Op, id: u32) {
        self.0.push((op, id));
    }
}

fn steps<T: BottomLevel<PreparedTriangle>>(
    structure: &TwoLevel<PreparedTriangle, T>,
    ray: &Ray,
    query: Query,
    cull_mask: u8,
) -> (Hit, Vec<(Op, u32)>) {
    let mut steps = Steps::default();
    let hit = structure.trace(ray, query, cull_mask, &mut steps);
    (hit, steps.0)
}

/// A triangle that rays along z at small x and y, x + y < 1, hit.
fn wall(z: f32) -> Triangle {
    Triangle { v: [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)] }
}

fn at(mesh: u32, translation: Vec3, mask: u8) -> MaskedInstance {
    MaskedInstance { placement: Instance { mesh, transform: Affine3A::from_translation(translation) }, mask }
}

fn along_z() -> Ray {
    Ray::new(Vec3::new(0.2, 0.2, -10.0), Vec3::Z)
}

#[test]
fn a_ray_goes_through_the_tlas_into_each_blas_and_back() {
    use Op::{Instance, Node, Pop, Primitive, Push};
    // Mesh 0 of one leaf, mesh 1 of two: they are nodes 4 and 6 to 8 behind the three of the TLAS.
    let far_apart = vec![wall(0.0), wall(100.0)];
    let instances = [at(1, Vec3::new(0.0, 0.0, 10.0), 255), at(0, Vec3::ZERO, 255)];
    let structure = TwoLevel::build(&[vec![wall(0.0)], far_apart], &instances, COSTS).unwrap();
    let (hit, seen) = steps(&structure, &along_z(), Query::Closest, 255);
    assert_eq!((hit.t, hit.primitive), (10.0, 2));
    // The nearer instance is hit, so the farther one is not entered when it is popped.
    let first = [(Node, 0), (Node, 1), (Push, 0), (Instance, 1), (Node, 4), (Primitive, 0), (Pop, 0)];
    assert_eq!(seen, first);

    // From behind the nearer one.
    let ray = Ray { origin: Vec3::new(0.2, 0.2, 5.0), ..along_z() };
    let (hit, seen) = steps(&structure, &ray, Query::Closest, 255);
    assert_eq!((hit.t, hit.primitive), (5.0, 0));
    let second =
        [(Node, 0), (Node, 1), (Instance, 0), (Node, 6), (Node, 7), (Push, 0), (Primitive, 1), (Pop, 0)];
    assert_eq!(seen, second);
}

type Wide<const W: usize> = TwoLevel<PreparedTriangle, WideBvh<PreparedTriangle, W>>;

#[test]
fn in_wide_trees_the_root_knows_the_boxes_of_all_instances() {
    use Op::{Instance, Node, Pop, Primitive, Push};
    let far_apart = vec![wall(0.0), wall(100.0)];
    let meshes = [vec![wall(0.0)], far_apart];
    let instances = [at(1, Vec3::new(0.0, 0.0, 10.0), 255), at(0, Vec3::ZERO, 255)];
    let structure = Wide::<8>::build_with(&meshes, &instances, COSTS, NodeFormat::Adreno8).unwrap();
    // A node of the TLAS, of mesh 0 and of mesh 1: each begins at an even number.
    let (hit, seen) = steps(&structure, &along_z(), Query::Closest, 255);
    assert_eq!((hit.t, hit.primitive), (10.0, 2));
    assert_eq!(seen, [(Node, 0), (Push, 0), (Instance, 1), (Node, 2), (Primitive, 0), (Pop, 0)]);
    let ray = Ray { origin: Vec3::new(0.2, 0.2, 5.0), ..along_z() };
    let (hit, seen) = steps(&structure, &ray, Query::Closest, 255);
    assert_eq!((hit.t, hit.primitive), (5.0, 0));
    assert_eq!(seen, [(Node, 0), (Instance, 0), (Node, 4), (Push, 0), (Primitive, 1), (Pop, 0)]);
    assert_eq!(structure.stack_entries(), 7 + 7 + 1);
    assert_eq!((structure.node_count(), structure.depth()), (3, 1));
}

#[test]
fn a_leaf_of_a_wide_tlas_is_an_instance_even_where_all_boxes_are_the_same() {
    let instances: Vec<_> = (0..20).map(|_| at(0, Vec3::ZERO, 255)).collect();
    for format in NodeFormat::ALL {
        let topology = if format.width() == 4 {
            Wide::<4>::build_with(&[vec![wall(0.0)]], &instances, COSTS, format).unwrap().topology()
        } else {
            Wide::<8>::build_with(&[vec![wall(0.0)]], &instances, COSTS, format).unwrap().topology()
        };
        topology.validate().unwrap();
        let (_, tlas) = &topology.trees()[0];
        let leaves: u32 = tlas
            .nodes
            .iter()
            .map(|node| match *node {
                TopologyNode::Wide { leaves, .. } => leaves,
                _ => panic!("{node:?} in a wide TLAS"),
            })
            .sum();
        assert_eq!(leaves, 20, "{format:?}");
        let mut references = tlas.references.clone();
        references.sort_unstable();
        assert_eq!(references, (0..20).collect::<Vec<_>>());
    }
}

/// Walls along z in a mesh of more than a node, placed behind each other, past which a ray flies through every box.
#[test]
fn a_short_stack_climbs_to_the_root_of_a_blas_and_goes_on_behind_its_instance() {
    let mesh: Vec<Triangle> = (0..30).map(|i| wall(i as f32)).collect();
    let instances: Vec<_> = (0..30).map(|i| at(0, Vec3::new(0.0, 0.0, 100.0 * i as f32), 255)).collect();
    let structure = Wide::<4>::build_with(&[mesh], &instances, COSTS, NodeFormat::Full4).unwrap();
    let topology = structure.topology();
    let blas = &topology.levels.as_ref().expect("two levels").blases[0];
    // Within all boxes and beside all triangles.
    let ray = Ray { origin: Vec3::new(0.9, 0.9, -10.0), ..along_z() };
    let walk = |entries: u32| {
        let mut seen = Steps::default();
        let hit = structure.trace_short_stack(entries, &ray, Query::Closest, 255, &mut seen);
        assert!(!hit.is_hit());
        seen.0
    };
    let deep = walk(64);
    let of = |seen: &[(Op, u32)], op: Op| {
        seen.iter().filter(|step| step.0 == op).map(|step| step.1).collect::<Vec<_>>()
    };
    assert!(of(&deep, Op::Restart).is_empty());
    // Nearest instance first, each once, whatever the stack has lost.
    assert_eq!(of(&deep, Op::Instance), (0..30).collect::<Vec<_>>());
    for entries in 0..8 {
        let seen = walk(entries);
        assert_eq!(of(&seen, Op::Instance), of(&deep, Op::Instance), "{entries} entries");
        assert_eq!(of(&seen, Op::Primitive), of(&deep, Op::Primitive), "{entries} entries");
        assert!([Op::Push, Op::Pop].iter().all(|&op| of(&seen, op).iter().all(|&slot| slot < entries)));
        // Each level climbs in its own tree: a parent is fetched again right after.
        let restarts = seen.windows(2).filter(|pair| pair[0].0 == Op::Restart);
        assert!(restarts.clone().all(|pair| pair[1] == (Op::Node, pair[0].1)));
        let in_blas = restarts.clone().filter(|pair| blas.nodes.contains(&pair[0].1)).count();
        let in_tlas = restarts.count() - in_blas;
        match entries {
            0 => assert!(in_blas > 0 && in_tlas > 0, "{in_blas} {in_tlas}"),
            // Entries of a BLAS push those of the TLAS out, not the other way around.
            1 => assert!(in_tlas > 0, "{in_blas} {in_tlas}"),
            _ => {}
        }
    }
}

#[test]
fn places_that_the_format_cannot_hold_are_refused() {
    let far = [at(0, Vec3::new(-3.39e38, 0.0, 0.0), 255)];
    let refused = Wide::<8>::build_with(&[vec![wall(0.0)]], &far, COSTS, NodeFormat::Adreno8);
    let refused = refused.map(|_| ()).expect_err("its origins have 16 bits").to_string();
    assert!(refused.contains("use another --node-format, or scale the scene"), "{refused}");
    Wide::<8>::build_with(&[vec![wall(0.0)]], &far, COSTS, NodeFormat::Full8).expect("in f32");
}

#[test]
fn stack_entries_of_the_blas_lie_on_those_of_the_tlas() {
    let far_apart = vec![wall(0.0), wall(100.0)];
    let beside = Vec3::new(0.5, 0.5, 1.0);
    let structure =
        TwoLevel::build(&[far_apart], &[at(0, Vec3::ZERO, 255), at(0, beside, 255)], COSTS).unwrap();
    let ray = Ray::new(Vec3::new(0.9, 0.9, -10.0), Vec3::Z);
    let (hit, seen) = steps(&structure, &ray, Query::Closest, 255);
    assert_eq!(hit.primitive, 2);
    let pushed = |op| seen.iter().filter(move |step| step.0 == op).map(|step| step.1).collect::<Vec<_>>();
    assert_eq!((pushed(Op::Push), pushed(Op::Pop)), (vec![0, 1, 0], vec![1, 0, 0]), "{seen:?}");
    assert_eq!(structure.stack_entries(), 3);
}

#[test]
fn a_root_of_either_level_is_one_record_and_every_other_node_step_two() {
    let far_apart = vec![wall(0.0), wall(100.0)];
    let structure = TwoLevel::build(
        &[vec![wall(0.0)], far_apart],
        &[at(0, Vec3::ZERO, 255), at(1, Vec3::new(0.0, 0.0, 1.0), 255)],
        COSTS,
    )
    .unwrap();
    let mut work = WorkCounter::new(NodeFetch::Pair);
    let ray = Ray { origin: Vec3::new(0.2, 0.2, 0.5), ..along_z() };
    structure.trace(&ray, Query::Closest, 255, &mut work);
    // Roots of the TLAS and of mesh 1, the pair below each.
    assert_eq!((work.work().node_steps, work.work().node_fetches), (4, 6));
    assert_eq!((work.work().pushes, work.work().pops, work.work().primitive_tests), (1, 1, 1));
}

#[test]
fn a_mask_hides_an_instance_from_rays_without_a_bit_in_common_and_costs_its_record() {
    use Op::{Instance, Node, Primitive};
    for (mask, cull_mask, is_seen) in [
        (255, 255, true),
        (1, 1, true),
        (1, 2, false),
        (0, 255, false),
        (255, 0, false),
        (0b1010, 0b0110, true),
    ] {
        let structure = TwoLevel::build(&[vec![wall(0.0)]], &[at(0, Vec3::ZERO, mask)], COSTS).unwrap();
        for query in [Query::Closest, Query::Any] {
            let (hit, seen) = steps(&structure, &along_z(), query, cull_mask);
            assert_eq!(hit.is_hit(), is_seen, "{mask} {cull_mask}");
            let expected: &[_] = if is_seen {
                &[(Node, 0), (Instance, 0), (Node, 2), (Primitive, 0)]
            } else {
                &[(Node, 0), (Instance, 0)]
            };
            assert_eq!(seen, expected);
        }
    }
}

#[test]
fn what_is_behind_a_hidden_instance_is_hit_and_any_query_stops_at_the_first_hit() {
    let instances: Vec<_> = (0..8).map(|i| at(0, Vec3::new(0.0, 0.0, i as f32), 1 << i)).collect();
    let structure = TwoLevel::build(&[vec![wall(0.0)]], &instances, COSTS).unwrap();
    for visible in 0..8 {
        let hit = structure.trace(&along_z(), Query::Closest, 1 << visible, &mut Silent);
        assert_eq!((hit.primitive, hit.t), (visible, 10.0 + visible as f32));
    }
    let (_, seen) = steps(&structure, &along_z(), Query::Any, 255);
    assert_eq!(seen.iter().filter(|step| step.0 == Op::Primitive).count(), 1);
}

#[test]
fn equal_distances_are_won_by_the_lowest_primitive_whatever_the_order_of_the_leaves() {
    // The same wall in every instance, so that all boxes coincide and share a leaf.
    let instances: Vec<_> = (0..9).map(|i| at(0, Vec3::ZERO, if i < 4 { 1 } else { 2 })).collect();
    let structure = TwoLevel::build(&[vec![wall(0.0), wall(3.0)]], &instances, COSTS).unwrap();
    for (cull_mask, first) in [(1, 0), (2, 8), (3, 0)] {
        let hit = structure.trace(&along_z(), Query::Closest, cull_mask, &mut Silent);
        assert_eq!((hit.t, hit.primitive), (10.0, first));
    }
}

#[test]
fn no_instance_and_only_empty_meshes_cost_the_root_and_miss() {
    let empty = MaskedInstance::from(Instance::identity(0));
    for instances in [vec![], vec![empty; 3]] {
        let structure = TwoLevel::build(&[vec![]], &instances, COSTS).unwrap();
        let (hit, seen) = steps(&structure, &along_z(), Query::Closest, 255);
        assert_eq!((hit, seen), (Hit::miss(f32::INFINITY), vec![(Op::Node, 0)]));
        let statistics = structure.statistics();
        assert_eq!((statistics.expected_entries, statistics.overlap_share), (None, None));
        assert_eq!(statistics.warnings(64), Vec::<String>::new());
    }
    let structure = TwoLevel::build(&[], &[], COSTS).unwrap();
    assert!(!structure.trace(&along_z(), Query::Any, 255, &mut Silent).is_hit());
}

#[test]
fn primitives_of_instances_after_an_empty_one_keep_their_place() {
    let instances = [at(1, Vec3::ZERO, 255), at(0, Vec3::ZERO, 255), at(1, Vec3::new(0.0, 0.0, -5.0), 255)];
    let structure = TwoLevel::build(&[vec![], vec![wall(0.0), wall(1.0)]], &instances, COSTS).unwrap();
    assert_eq!(structure.trace(&along_z(), Query::Closest, 255, &mut Silent).primitive, 2);
}

#[test]
fn a_thousand_instances_are_each_hit_where_they_stand_and_few_are_entered() {
    let place = |i: u32| Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32) * 3.0;
    let turned = |i: u32| Affine3A::from_translation(place(i)) * Affine3A::from_rotation_z(i as f32);
    let instances: Vec<_> =
        (0..1000).map(|i| Instance { mesh: i % 2, transform: turned(i) }.into()).collect();
    let structure =
        TwoLevel::build(&[vec![wall(0.0)], vec![wall(0.5), wall(0.0)]], &instances, COSTS).unwrap();
    let mut entered = 0;
    for i in 0..1000 {
        let inside = turned(i).transform_point3(Vec3::new(0.2, 0.2, 0.0));
        let ray = Ray::new(inside - 0.25 * Vec3::Z, Vec3::Z);
        let (hit, seen) = steps(&structure, &ray, Query::Closest, 255);
        // Before instance i there are as many of one as of two triangles, or one of one more.
        let before = i / 2 * 3 + i % 2;
        assert_eq!(hit.primitive, before + i % 2);
        assert!((hit.t - 0.25).abs() < 1e-5);
        entered += seen.iter().filter(|step| step.0 == Op::Instance).count();
    }
    // The nearest box is entered first, and behind the hit nothing is.
    assert!((1000..1100).contains(&entered), "{entered}");
}

#[test]
fn the_deepest_trees_of_both_levels_fit_the_stack_that_is_stated() {
    // Each split takes the farthest box or triangle off.
    let edge = |i: i32| 2.0_f32.powi(i - 50);
    let nested: Vec<Triangle> = (0..100)
        .map(|i| {
            let s = edge(i);
            Triangle { v: [Vec3::new(s, 0.0, 0.0), Vec3::new(s, s, 0.0), Vec3::new(s, 0.0, s)] }
        })
        .collect();
    let instances: Vec<_> = (-30..30)
        .map(|i| {
            let transform = Affine3A::from_scale(Vec3::splat(2.0_f32.powi(i)));
            MaskedInstance::from(Instance { mesh: 0, transform })
        })
        .collect();
    let structure = TwoLevel::build(&[nested], &instances, [0.0, 1.0]).unwrap();
    let topology = structure.topology();
    let depth = |nodes: &[TopologyNode]| {
        let mut depths = vec![0; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            if let TopologyNode::Inner { left } = *node {
                depths[left as usize] = depths[index] + 1;
                depths[left as usize + 1] = depths[index] + 1;
            }
        }
        depths.into_iter().max().unwrap()
    };
    let trees = topology.trees();
    let (tlas, blas) = (depth(&trees[0].1.nodes), depth(&trees[1].1.nodes));
    assert!(tlas > 20 && blas > 31, "deeper than balanced trees: {tlas} and {blas}");
    assert_eq!(structure.stack_entries(), tlas + blas + 1);

    let mut deepest = 0;
    for i in 0..60 {
        let y = 0.2 * edge(i);
        for direction in [Vec3::X, Vec3::NEG_X] {
            let x = if direction.x > 0.0 { -1.0 } else { edge(99) };
            let (_, seen) = steps(&structure, &Ray::new(Vec3::new(x, y, y), direction), Query::Closest, 255);
            let pushed = seen.iter().filter(|step| step.0 == Op::Push).map(|step| step.1 + 1).max();
            deepest = deepest.max(pushed.unwrap_or(0));
        }
    }
    assert!(
        deepest < structure.stack_entries() && deepest > tlas.max(blas),
        "{deepest} of {tlas} and {blas}"
    );
}

#[test]
fn ids_of_steps_lie_in_the_topology_that_is_stated() {
    let meshes = [vec![wall(0.0); 3], vec![], (0..9).map(|i| wall(i as f32)).collect::<Vec<_>>()];
    let instances: Vec<_> = (0..12).map(|i| at(i % 3, Vec3::new(0.0, 0.0, 20.0 * i as f32), 255)).collect();
    let structure = TwoLevel::build(&meshes, &instances, [0.0, 1.0]).unwrap();
    let topology = structure.topology();
    assert_eq!(topology.validate(), Ok(()));
    let levels = topology.levels.as_ref().expect("two levels");
    assert_eq!(levels.meshes, (0..12).map(|i| i % 3).collect::<Vec<u32>>());
    let mut next = (levels.tlas_nodes, 0);
    for (blas, mesh) in levels.blases.iter().zip(&meshes) {
        assert_eq!(blas.references, next.1..next.1 + mesh.len() as u32);
        assert_eq!(blas.nodes.start, next.0.next_multiple_of(2));
        next = (blas.nodes.end, blas.references.end);
    }
    let trees = topology.trees();
    let nodes: usize = trees.iter().map(|(_, tree)| tree.nodes.len()).sum();
    assert_eq!(structure.node_count(), nodes as u64);
    assert_eq!(topology.triangles, 4 * (3 + 9));

    // Every triangle is named by the steps of the ray that comes from behind everything.
    let ray = Ray { t_max: 1.0, ..Ray::new(Vec3::new(0.7, 0.7, -5.0), Vec3::new(0.0, 0.0, 1000.0)) };
    let (hit, seen) = steps(&structure, &ray, Query::Closest, 255);
    assert!(!hit.is_hit());
    let mut blas = None;
    let mut tested = 0;
    for (op, id) in seen {
        match op {
            Op::Instance => blas = levels.blas_of(id),
            Op::Primitive => {
                assert!(blas.expect("in an instance").references.contains(&id));
                tested += 1;
            }
            Op::Node if id >= levels.tlas_nodes => {
                assert!(blas.expect("in an instance").nodes.contains(&id));
            }
            _ => {}
        }
    }
    assert_eq!(tested, 4 * 3 + 4 * 9);
}

#[test]
fn transforms_without_an_inverse_are_refused_by_number_and_reason() {
    let scale = |x: f32, y: f32, z: f32| Affine3A::from_scale(Vec3::new(x, y, z));
    let turned = Affine3A::from_rotation_x(0.7) * Affine3A::from_rotation_z(0.3);
    let refusal = |transform: Affine3A| {
        let instances = [Instance::identity(0).into(), Instance { mesh: 0, transform }.into()];
        TwoLevel::build(&[vec![wall(0.0)]], &instances, COSTS).map(|_| ()).map_err(|error| error.to_string())
    };
    for (transform, reason) in [
        (scale(0.0, 1.0, 1.0), "no inverse"),
        (scale(0.0, 0.0, 0.0), "no inverse"),
        (turned * scale(1.0, 0.0, 1.0) * turned, "flattens a direction"),
        (scale(f32::NAN, 1.0, 1.0), "not finite"),
        (Affine3A::from_translation(Vec3::new(0.0, f32::INFINITY, 0.0)), "not finite"),
        (scale(1e-40, 1.0, 1.0), "beyond those of f32"),
        (scale(2e38, 1.0, 1.0), "beyond those of f32"),
        (turned * scale(1.0, 1e-7, 1.0) * turned, "condition number"),
        (scale(8e37, 1.0, 1.0) * Affine3A::from_translation(4.0 * Vec3::X), "beyond the largest f32"),
    ] {
        let message = refusal(transform).expect_err("refused");
        assert!(
            message.starts_with("the transform of instance 1: ") && message.contains(reason),
            "{message}"
        );
    }
    for transform in [scale(1e-30, 1.0, 1e20), scale(-1.0, 1.0, 1.0), turned * scale(1.0, 1e-5, 1.0) * turned]
    {
        assert_eq!(refusal(transform), Ok(()), "{transform:?}");
    }
}

#[test]
fn other_wrong_input_is_refused_by_number_and_reason() {
    let build = |meshes: &[Vec<Triangle>], instance: Instance, costs| {
        TwoLevel::build(meshes, &[instance.into()], costs).map(|_| ()).map_err(|error| error.to_string())
    };
    let missing = build(&[vec![wall(0.0)]], Instance::identity(1), COSTS).expect_err("no such mesh");
    assert!(missing.contains("instance 0 is of mesh 1"), "{missing}");
    let bad = build(&[vec![wall(0.0), wall(f32::NAN)]], Instance::identity(0), COSTS).expect_err("NaN");
    assert!(bad.contains("triangle 1 of mesh 0"), "{bad}");
    let costs = build(&[vec![wall(0.0)]], Instance::identity(0), [1.0, 0.0]).expect_err("Ci of 0");
    assert!(costs.contains("Ci = 0"), "{costs}");
    // 2^14 triangles in 2^18 instances are 2^32.
    let many = vec![Instance::identity(0).into(); 1 << 18];
    let total = TwoLevel::build(&[vec![wall(0.0); 1 << 14]], &many, COSTS).map(|_| ()).expect_err("too many");
    assert!(total.to_string().contains("ids have 32 bits"), "{total}");
}

#[test]
fn a_direction_is_not_normalised_so_distances_are_those_of_the_world() {
    let transform =
        Affine3A::from_translation(Vec3::new(0.0, 0.0, 3.0)) * Affine3A::from_scale(Vec3::splat(4.0));
    let structure =
        TwoLevel::build(&[vec![wall(0.0)]], &[Instance { mesh: 0, transform }.into()], COSTS).unwrap();
    let ray = Ray { direction: Vec3::new(0.0, 0.0, 2.0), t_min: 6.0, ..along_z() };
    let hit = structure.trace(&ray, Query::Closest, 255, &mut Silent);
    assert_eq!((hit.t, hit.u, hit.v), (6.5, 0.05, 0.05));
    assert!(!structure.trace(&Ray { t_max: 6.4, ..ray }, Query::Any, 255, &mut Silent).is_hit());
    let object = structure.object_ray(0, &ray);
    assert_eq!(
        (object.t_min, object.t_max, object.direction),
        (6.0, f32::INFINITY, Vec3::new(0.0, 0.0, 0.5))
    );
}

#[test]
fn the_identity_keeps_signs_of_zeros_and_numbers_that_are_not_finite() {
    let structure = TwoLevel::build(&[vec![wall(0.0)]], &[Instance::identity(0).into()], COSTS).unwrap();
    let ray = Ray::new(Vec3::new(-0.0, f32::INFINITY, 1.0), Vec3::new(f32::NEG_INFINITY, -0.0, 0.0));
    let object = structure.object_ray(0, &ray);
    let bits = |ray: &Ray| [ray.origin, ray.direction].map(|v| v.to_array().map(f32::to_bits));
    assert_eq!(bits(&object), bits(&ray));
}
