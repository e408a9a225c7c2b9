//! Does a scene of instances give the hits of its flattened triangles, and does its trace come back from a file?

use glam::{Affine3A, Quat, Vec3};
use scenes::{Instance, Triangle};
use std::path::Path;
use tracer::two_level::Levels;
use tracer::wide::NodeFormat;
use tracer::{
    AccelerationStructure, BuildOptions, FrameTracer, Op, Query, Ray, Rays, SceneIdentity, Silent, Step,
    Tile, TileSource, Topology, TopologyNode, TraceFile, TraceWriter, Traversal, TriangleTest,
};

/// Two meshes of a ragged sheet each, placed seven times, turned and scaled; the last two interpenetrate.
fn scene() -> (Vec<Vec<Triangle>>, Vec<Instance>) {
    let sheet = |edge: u32, height: f32| {
        let corner = |x: u32, z: u32| {
            let (x, z) = (x as f32 / edge as f32, z as f32 / edge as f32);
            Vec3::new(x - 0.5, height * (9.0 * x).sin() * (7.0 * z).cos(), z - 0.5)
        };
        let cells = (0..edge).flat_map(|x| (0..edge).map(move |z| (x, z)));
        cells
            .flat_map(|(x, z)| {
                let [a, b, c, d] =
                    [(x, z), (x + 1, z), (x, z + 1), (x + 1, z + 1)].map(|(x, z)| corner(x, z));
                [Triangle { v: [a, b, c] }, Triangle { v: [b, d, c] }]
            })
            .collect()
    };
    let place = |number: u32| {
        let at = number.min(5) as f32;
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, at).normalize(), 0.4 * number as f32);
        let scale = Vec3::new(1.0 + 0.2 * at, 0.7, 1.5);
        let transform =
            Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(1.3 * at, 0.2 * at, -0.4 * at));
        Instance { mesh: number % 2, transform }
    };
    (vec![sheet(6, 0.2), sheet(3, 0.4)], (0..7).map(place).collect())
}

fn flattened(meshes: &[Vec<Triangle>], instances: &[Instance]) -> Vec<Triangle> {
    let of_instance = |instance: &Instance| {
        let world = |triangle: &Triangle| Triangle { v: triangle.v.map(|v| instance.transform_point(v)) };
        meshes[instance.mesh as usize].iter().map(world).collect::<Vec<_>>()
    };
    instances.iter().flat_map(of_instance).collect()
}

fn rays() -> Vec<Ray> {
    let ray = |index: u32| {
        let (x, y) = ((index % 64) as f32 / 64.0, (index / 64) as f32 / 64.0);
        Ray::new(Vec3::new(3.0, 6.0, 5.0), Vec3::new(10.0 * x - 5.5, -6.0, 7.0 * y - 10.0))
    };
    (0..64 * 64).map(ray).collect()
}

const TRAVERSALS: [Traversal; 8] = [
    Traversal::TwoLevelStack { format: None },
    Traversal::TwoLevelStack { format: Some(NodeFormat::Full4) },
    Traversal::TwoLevelStack { format: Some(NodeFormat::Compressed8) },
    Traversal::TwoLevelStack { format: Some(NodeFormat::Compressed8Pairs) },
    Traversal::TwoLevelStack { format: Some(NodeFormat::Adreno8) },
    Traversal::TwoLevelShortStack { format: NodeFormat::Adreno8, short_stack: 8 },
    Traversal::TwoLevelShortStack { format: NodeFormat::Adreno8, short_stack: 1 },
    Traversal::TwoLevelShortStack { format: NodeFormat::Full4, short_stack: 0 },
];

#[test]
fn hits_of_turned_and_scaled_instances_are_those_of_the_flattened_scene() {
    let (meshes, instances) = scene();
    let triangles = flattened(&meshes, &instances);
    for triangle_test in TriangleTest::ALL {
        let options = BuildOptions { triangle_test, ..BuildOptions::default() };
        let flat =
            AccelerationStructure::build(&triangles, Traversal::BvhStack, &options).expect("a good scene");
        for traversal in TRAVERSALS {
            let levels = AccelerationStructure::build_two_level(&meshes, &instances, traversal, &options)
                .expect("a good scene");
            let mut hits = 0;
            for ray in rays() {
                let [expected, found] =
                    [&flat, &levels].map(|tree| tree.trace(&ray, Query::Closest, &mut Silent));
                let any = levels.trace(&ray, Query::Any, &mut Silent);
                hits += u32::from(found.is_hit());
                assert_eq!(
                    found.primitive, expected.primitive,
                    "{ray:?} {traversal:?}: {found:?} {expected:?}"
                );
                assert_eq!(any.is_hit(), expected.is_hit(), "{ray:?}");
                let near = !found.is_hit() || (found.t - expected.t).abs() <= 1e-5 * expected.t;
                assert!(near, "{ray:?} {traversal:?}: {found:?} {expected:?}");
            }
            assert!((1000..4000).contains(&hits), "{hits} hits say little");
        }
    }
}

#[test]
fn traversals_of_other_structures_and_stacks_that_are_too_long_are_refused() {
    let (meshes, instances) = scene();
    let refused = |traversal| {
        let options = BuildOptions::default();
        let built = AccelerationStructure::build_two_level(&meshes, &instances, traversal, &options);
        built.map(|_| ()).expect_err("refused").to_string()
    };
    assert!(refused(Traversal::BvhStack).contains("bvh stack walks no two levels"));
    let long = Traversal::TwoLevelShortStack { format: NodeFormat::Adreno8, short_stack: 65 };
    assert!(refused(long).contains("a short stack of 65 entries"));
}

fn with_tracer(traversal: Traversal, check: impl FnOnce(&FrameTracer<'_>)) {
    let (meshes, instances) = scene();
    let triangles = flattened(&meshes, &instances);
    let options = BuildOptions::default();
    let structure = AccelerationStructure::build_two_level(&meshes, &instances, traversal, &options)
        .expect("a good scene");
    let identity = SceneIdentity { name: "instances".to_owned(), hash: 7 };
    let lights = vec![Vec3::new(0.0, 9.0, 0.0)];
    check(&FrameTracer::new(&structure, &options, &triangles, identity, Rays::List(rays()), lights));
}

fn write(tracer: &FrameTracer<'_>, path: &Path, change: impl Fn(&mut Tile)) {
    let mut writer = TraceWriter::create(path, tracer.header(), tracer.topology()).expect("it is created");
    let mut tile = Tile::default();
    for index in 0..tracer.header().frame.tiles() {
        tracer.tile(index, &mut tile).expect("it is traced");
        change(&mut tile);
        let encoded = tracer::EncodedTile::new(&tile, tracer.header()).expect("it is small");
        writer.write_tile(&encoded).expect("it is written");
    }
    writer.finish(0).expect("it is written");
}

#[test]
fn two_levels_come_back_from_a_file_and_steps_into_unknown_instances_do_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("instances.rbt");
    for traversal in TRAVERSALS {
        with_tracer(traversal, |tracer| {
            write(tracer, &path, |_| {});
            let file = TraceFile::open(&path).expect("it is sound");
            assert_eq!((file.header(), file.topology()), (tracer.header(), tracer.topology()));
            let (mut tile, mut expected) = (Tile::default(), Tile::default());
            let mut entered = 0;
            for index in 0..file.header().frame.tiles() {
                file.tile(index, &mut tile).expect("it is sound");
                tracer.tile(index, &mut expected).expect("it is traced");
                assert_eq!(tile, expected);
                let steps = tile.ray_sets.iter().flat_map(|set| &set.steps);
                entered += steps.filter(|step| step.op() == Op::Instance).count();
            }
            assert!(entered > 1000, "{entered}");

            for (instance, is_known) in [(6, true), (7, false)] {
                let enter = |tile: &mut Tile| {
                    let steps = tile.ray_sets[0].steps.iter_mut();
                    steps
                        .filter(|step| step.op() == Op::Instance)
                        .for_each(|step| *step = Step::new(Op::Instance, instance));
                };
                write(tracer, &path, enter);
                let read = TraceFile::open(&path).expect("its head is sound").tile(0, &mut tile);
                assert_eq!(read.is_ok(), is_known, "{instance}");
                if let Err(error) = read {
                    assert!(error.to_string().contains("Instance step with id 7, below 7"), "{error}");
                }
            }
        });
    }
}

#[test]
fn links_that_leave_their_tree_or_lead_nowhere_are_refused() {
    with_tracer(Traversal::TwoLevelStack { format: None }, |tracer| {
        let good = tracer.topology();
        assert_eq!(good.validate(), Ok(()));
        let levels = good.levels.clone().expect("two levels");
        let first_blas = levels.blases[0].nodes.start as usize;
        let refusal = |change: &dyn Fn(&mut Topology, &mut Levels)| {
            let (mut bad, mut of_bad) = (good.clone(), levels.clone());
            change(&mut bad, &mut of_bad);
            bad.levels = Some(of_bad);
            bad.validate().expect_err("a contradiction")
        };
        // From the TLAS into a BLAS, from a BLAS into the next, back to itself, an instance and a mesh that are not there.
        assert!(
            refusal(&|bad, _| bad.nodes[0] = TopologyNode::Inner { left: first_blas as u32 + 1 })
                .contains("tree of node 0: inner node 0")
        );
        let next = levels.blases[1].nodes.start;
        let in_blas = format!("tree of node {first_blas}");
        assert!(
            refusal(&|bad, _| bad.nodes[first_blas] = TopologyNode::Inner { left: next + 1 })
                .contains(&in_blas)
        );
        assert!(
            refusal(&|bad, _| bad.nodes[first_blas] = TopologyNode::Inner { left: first_blas as u32 })
                .contains(&in_blas)
        );
        assert!(refusal(&|_, levels| levels.tlas_references[0] = 7).contains("7 of 7"));
        assert!(refusal(&|_, levels| levels.meshes[0] = 2).contains("instance 0 has no BLAS of the 2"));
        assert!(refusal(&|_, levels| levels.tlas_nodes -= 1).contains("a BLAS of nodes"));
        assert!(refusal(&|_, levels| levels.tlas_nodes = u32::MAX).contains("a BLAS of nodes"));
        assert!(refusal(&|bad, _| bad.triangles += 1).contains("triangles of the scene"));
        assert!(refusal(&|bad, _| bad.references[0] = levels.blases[1].references.start).contains(&in_blas));
        assert!(refusal(&|_, levels| levels.blases.truncate(1)).contains("do not fill the lists"));
    });
}
