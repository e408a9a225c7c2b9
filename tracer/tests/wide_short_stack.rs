//! Does a short stack find what a full one finds, whatever it loses, and does it climb only where it has lost something?

use glam::Vec3;
use proptest::prelude::*;
use scenes::Triangle;
use tracer::wide::NodeFormat;
use tracer::wide::short_stack::DRIVER_ENTRIES;
use tracer::{
    AccelerationStructure, BuildOptions, Hit, NodeFetch, Query, Ray, Silent, Traversal, Work, WorkCounter,
};

fn build(triangles: &[Triangle], traversal: Traversal) -> AccelerationStructure {
    AccelerationStructure::build(triangles, traversal, &BuildOptions::default()).expect("the scene is small")
}

fn short(triangles: &[Triangle], format: NodeFormat, short_stack: u32) -> AccelerationStructure {
    build(triangles, Traversal::WideShortStack { format, short_stack })
}

fn work(structure: &AccelerationStructure, ray: &Ray, query: Query) -> (Hit, Work) {
    let mut counter = WorkCounter::new(NodeFetch::Single);
    let hit = structure.trace(ray, query, &mut counter);
    (hit, counter.work())
}

/// Coordinates on a coarse grid give shared planes, duplicates, flat boxes and ties.
fn soup() -> impl Strategy<Value = Vec<Triangle>> {
    let point = || [-1.0_f32..1.0, -1.0..1.0, -1.0..1.0].prop_map(Vec3::from);
    let on_grid = || [-3_i8..4, -3_i8..4, -3_i8..4].prop_map(|at| Vec3::from(at.map(f32::from)));
    let small =
        (point(), point(), point()).prop_map(|(a, b, c)| Triangle { v: [a, a + 0.2 * b, a + 0.2 * c] });
    let gridded = [on_grid(), on_grid(), on_grid()].prop_map(|v| Triangle { v });
    prop_oneof![prop::collection::vec(small, 0..200), prop::collection::vec(gridded, 0..200)]
}

/// Triangles across the z axis, each twice as far as the one before, so that no split halves them.
fn spreading() -> Vec<Triangle> {
    let at = |z: f32| [Vec3::new(-z, -z, z), Vec3::new(2.0 * z, -z, z), Vec3::new(-z, 2.0 * z, z)];
    (0..60).map(|step| Triangle { v: at(1.5_f32.powi(step)) }).collect()
}

fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let ray = ([-3.0_f32..3.0, -3.0..3.0, -3.0..3.0], [-1.0_f32..1.0, -1.0..1.0, -1.0..1.0])
        .prop_map(|(origin, direction)| Ray::new(origin.into(), direction.into()));
    prop::collection::vec(ray, 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn hits_are_those_of_the_binary_stack(
        triangles in prop_oneof![soup(), Just(spreading())], rays in rays(), entries in 0..=DRIVER_ENTRIES,
    ) {
        let binary = build(&triangles, Traversal::BvhStack);
        for format in NodeFormat::ALL {
            let structure = short(&triangles, format, entries);
            for ray in &rays {
                let expected = binary.trace(ray, Query::Closest, &mut Silent);
                prop_assert_eq!(structure.trace(ray, Query::Closest, &mut Silent), expected, "{:?}", format);
                let any = structure.trace(ray, Query::Any, &mut Silent);
                prop_assert_eq!(any.is_hit(), expected.is_hit(), "{:?}", format);
            }
        }
    }

    /// Without a hit nothing is culled, so a stack that keeps everything visits what the full one does.
    #[test]
    fn a_deep_short_stack_visits_what_a_full_one_does_where_nothing_is_hit(triangles in soup(), rays in rays()) {
        let format = NodeFormat::Adreno8;
        let (full, deep) = (build(&triangles, Traversal::WideStack { format }), short(&triangles, format, 64));
        for ray in &rays {
            let ((hit, full), (_, deep)) = (work(&full, ray, Query::Closest), work(&deep, ray, Query::Closest));
            prop_assert_eq!((deep.restarts, deep.stalls), (0, 0));
            prop_assert!(deep.node_steps >= full.node_steps && deep.primitive_tests >= full.primitive_tests);
            if !hit.is_hit() {
                prop_assert_eq!(
                    (deep.node_steps, deep.primitive_tests, deep.pops),
                    (full.node_steps, full.primitive_tests, full.pops)
                );
                // A node pushes once, however many of its children are left.
                prop_assert!(deep.pushes <= full.pushes && deep.pushes <= deep.node_steps);
            }
        }
    }
}

#[test]
fn a_stack_climbs_where_it_has_lost_entries_and_nowhere_else() {
    let triangles = spreading();
    // Through all boxes and past all triangles.
    let ray = Ray::new(Vec3::new(-0.9, -0.9, 0.5), Vec3::new(-0.85, -0.85, 1.0));
    let restarts = |entries: u32| {
        let (hit, work) = work(&short(&triangles, NodeFormat::Full4, entries), &ray, Query::Closest);
        (hit, work.restarts)
    };
    let (hit, without) = restarts(0);
    let (_, all) = restarts(64);
    assert_eq!(all, 0);
    assert!(without > 0, "{without}");
    for entries in 0..=64 {
        let (found, climbed) = restarts(entries);
        assert_eq!(found, hit);
        assert!(climbed <= without, "{entries} entries: {climbed} of {without}");
    }
    let depth = short(&triangles, NodeFormat::Full4, 0).depth();
    assert_eq!(restarts(depth + 1).1, 0, "one entry per node of the path");
    assert!(restarts(1).1 > 0, "{depth}");
}
