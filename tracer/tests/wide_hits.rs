//! Do wide BVHs find what the binary BVH finds, and does quantisation add visits without losing a hit?

use glam::Vec3;
use proptest::prelude::*;
use scenes::Triangle;
use tracer::bvh::{self, Bvh, BvhOptions};
use tracer::wide::{self, NodeFormat, WideBvh};
use tracer::{
    AccelerationStructure, BuildOptions, Hit, NodeFetch, Observer, Op, PreparedTriangle, Query, Ray, Silent,
    Topology, TopologyNode, Traversal, TriangleTest, Work, WorkCounter,
};

fn options(format: NodeFormat) -> BvhOptions {
    BvhOptions { max_leaf: format.leaf_triangles().unwrap_or(u32::MAX), ..BvhOptions::MOBILE }
}

fn full<const W: usize>(triangles: &[Triangle], format: NodeFormat) -> WideBvh<PreparedTriangle, W> {
    WideBvh::collapse(Bvh::build(triangles, &options(format)), format).expect("coordinates are small")
}

fn point(range: f32) -> impl Strategy<Value = Vec3> {
    [-range..range, -range..range, -range..range].prop_map(Vec3::from)
}

/// Coordinates on a coarse grid: shared planes, duplicates, flat boxes and ties.
fn grid_point() -> impl Strategy<Value = Vec3> {
    [-3_i8..4, -3_i8..4, -3_i8..4].prop_map(|[x, y, z]| Vec3::new(f32::from(x), f32::from(y), f32::from(z)))
}

/// Scenes around the origin, and far from it, where origins of 16 bits are coarse.
fn soup() -> impl Strategy<Value = Vec<Triangle>> {
    let small = (point(1.0), point(0.2), point(0.2)).prop_map(|(a, b, c)| Triangle { v: [a, a + b, a + c] });
    let gridded = [grid_point(), grid_point(), grid_point()].prop_map(|v| Triangle { v });
    prop_oneof![prop::collection::vec(small, 0..150), prop::collection::vec(gridded, 0..150)]
}

fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let free = (point(3.0), point(1.0)).prop_map(|(o, d)| Ray::new(o, d));
    let axial = (grid_point(), 0_usize..3, any::<[bool; 3]>()).prop_map(|(origin, axis, negative)| {
        let mut direction = negative.map(|negative| if negative { -0.0_f32 } else { 0.0 });
        direction[axis] = if negative[axis] { -1.0 } else { 1.0 };
        Ray::new(origin, Vec3::from(direction))
    });
    prop::collection::vec(prop_oneof![free, axial], 1..40)
}

fn structure(triangles: &[Triangle], format: NodeFormat, test: TriangleTest) -> AccelerationStructure {
    let options = BuildOptions { triangle_test: test, ..BuildOptions::default() };
    AccelerationStructure::build(triangles, Traversal::WideStack { format }, &options)
        .expect("the scene is small")
}

/// Squares of two triangles each, side by side.
fn sheet(edge: u32) -> Vec<Triangle> {
    let corner = |x: u32, z: u32| Vec3::new(x as f32, ((x * z) as f32).sin(), z as f32);
    let cells = (0..edge).flat_map(|x| (0..edge).map(move |z| (x, z)));
    let square = |(x, z)| {
        let [a, b, c, d] = [(x, z), (x + 1, z), (x, z + 1), (x + 1, z + 1)].map(|(x, z)| corner(x, z));
        [Triangle { v: [a, b, c] }, Triangle { v: [b, d, c] }]
    };
    cells.flat_map(square).collect()
}

#[test]
fn most_triangles_of_a_sheet_are_in_pairs() {
    let triangles = sheet(20);
    let tree =
        WideBvh::<PreparedTriangle, 8>::build_for(&triangles, [3.0, 1.5], NodeFormat::Compressed8Pairs);
    let tree = tree.expect("coordinates are small");
    let share = 2.0 * tree.seconds().len() as f64 / triangles.len() as f64;
    assert!(share > 0.5, "{share}");
    let alone = WideBvh::<PreparedTriangle, 8>::build_for(&triangles, [3.0, 1.5], NodeFormat::Compressed8);
    assert!(alone.expect("coordinates are small").seconds().is_empty());
}

#[test]
fn positions_that_cannot_be_second_are_refused() {
    let triangles = sheet(4);
    let traversal = Traversal::WideStack { format: NodeFormat::Compressed8Pairs };
    let good =
        AccelerationStructure::build(&triangles, traversal, &BuildOptions::default()).unwrap().topology();
    assert_eq!(good.validate(), Ok(()));
    assert!(!good.seconds.is_empty());
    let references = good.references.len() as u32;
    for seconds in [vec![0], vec![references], vec![3, 3], vec![5, 2], vec![4, 5]] {
        let bad = Topology { seconds: seconds.clone(), ..good.clone() };
        let refused = bad.validate().expect_err("no such pairs");
        assert!(refused.contains("cannot be second to the one before"), "{seconds:?}: {refused}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn pairs_share_an_edge_and_leave_the_tree_as_it_is(
        triangles in prop_oneof![soup(), (1_u32..8).prop_map(sheet)]
    ) {
        let build = |format| WideBvh::<PreparedTriangle, 8>::build_for(&triangles, [3.0, 1.5], format).unwrap();
        let (alone, pairs) = (build(NodeFormat::Compressed8), build(NodeFormat::Compressed8Pairs));
        prop_assert_eq!(pairs.validate(&triangles), Ok(()));
        let [alone_shape, shape] = [Topology::of_wide(&alone), Topology::of_wide(&pairs)];
        prop_assert_eq!(shape.validate(), Ok(()));
        prop_assert_eq!(alone_shape.nodes, shape.nodes);
        for &second in pairs.seconds() {
            let [a, b] = [second - 1, second].map(|at| triangles[pairs.references()[at as usize] as usize].v);
            let shared = b.iter().filter(|corner| a.contains(corner)).count();
            prop_assert!(shared >= 2, "{:?} {:?}", a, b);
        }
    }

    #[test]
    fn every_format_finds_the_hit_of_the_binary_stack(triangles in soup(), rays in rays(), shift in 0..3_usize) {
        let shift = Vec3::new(0.0, -1000.0, 123_456.0) * [0.0, 1.0, -1.0][shift];
        let moved: Vec<_> = triangles.iter().map(|t| Triangle { v: t.v.map(|corner| corner + shift) }).collect();
        for test in TriangleTest::ALL {
            let binary = BuildOptions { triangle_test: test, ..BuildOptions::default() };
            let binary = AccelerationStructure::build(&moved, Traversal::BvhStack, &binary).unwrap();
            for format in NodeFormat::ALL {
                let wide = structure(&moved, format, test);
                for ray in &rays {
                    let ray = Ray::new(ray.origin + shift, ray.direction);
                    let expected = binary.trace(&ray, Query::Closest, &mut Silent);
                    prop_assert_eq!(wide.trace(&ray, Query::Closest, &mut Silent), expected, "{:?}", format);
                    let any = wide.trace(&ray, Query::Any, &mut Silent);
                    prop_assert_eq!(any.is_hit(), expected.is_hit(), "{:?}", format);
                }
            }
        }
    }

    #[test]
    fn trees_are_sound(triangles in soup()) {
        prop_assert_eq!(full::<4>(&triangles, NodeFormat::Full4).validate(&triangles), Ok(()));
        for format in [NodeFormat::Full8, NodeFormat::Compressed8, NodeFormat::Adreno8] {
            let tree = full::<8>(&triangles, format);
            prop_assert_eq!(tree.validate(&triangles), Ok(()));
            let statistics = tree.statistics();
            prop_assert!(statistics.children == statistics.leaves + statistics.nodes - 1);
            prop_assert!(statistics.largest_leaf <= format.leaf_triangles().unwrap_or(u32::MAX));
            let topology = Topology::of_wide(&tree);
            prop_assert_eq!(topology.validate(), Ok(()));
            let inner: u32 = topology.nodes.iter().map(|node| match node {
                TopologyNode::Wide { count, .. } => *count,
                other => unreachable!("{other:?}"),
            }).sum();
            prop_assert_eq!(u64::from(inner), statistics.nodes - 1, "each node but the root is some node's child");
        }
    }

    /// Over one tree, so that only the boxes differ. Larger boxes are entered earlier, so that the order of visits can change; a query
    /// for the closest hit that finds none visits every node whose box is hit, in whatever order.
    #[test]
    fn quantised_boxes_add_visits_and_take_none_away(triangles in soup(), rays in rays()) {
        let options = options(NodeFormat::Compressed8);
        let binary = || Bvh::<PreparedTriangle>::build(&triangles, &options);
        let exact = WideBvh::<_, 8>::collapse(binary(), NodeFormat::Full8).unwrap();
        let quantised = WideBvh::<_, 8>::collapse(binary(), NodeFormat::Compressed8).unwrap();
        for ray in &rays {
            let mut visited = [const { Vec::new() }; 2];
            let hit = wide::stack::trace(&exact, ray, Query::Closest, &mut Visited(&mut visited[0]));
            wide::stack::trace(&quantised, ray, Query::Closest, &mut Visited(&mut visited[1]));
            if !hit.is_hit() {
                let [exact, quantised] = visited;
                prop_assert!(exact.iter().all(|step| quantised.contains(step)), "{:?} {:?}", exact, quantised);
            }
        }
    }

    #[test]
    fn work_obeys_the_counting_rules(triangles in soup(), rays in rays(), any: bool) {
        let query = if any { Query::Any } else { Query::Closest };
        for format in NodeFormat::ALL {
            let wide = structure(&triangles, format, TriangleTest::MoellerTrumbore);
            for ray in &rays {
                let mut counter = WorkCounter::new(NodeFetch::Single);
                let hit = wide.trace(ray, query, &mut counter);
                let Work { node_fetches, node_steps, box_tests, pushes, pops, leaf_visits, stalls, .. } = counter.work();
                prop_assert_eq!(node_fetches, node_steps);
                prop_assert!(box_tests <= node_steps * u64::from(format.width()));
                prop_assert!(pops <= pushes && (pops == pushes || (any && hit.is_hit())));
                // The root, the nearest child of a node, and what is popped.
                prop_assert!(node_steps + leaf_visits <= 1 + node_steps + pops);
                prop_assert_eq!(stalls, 0);
            }
        }
    }
}

struct Visited<'a>(&'a mut Vec<(Op, u32)>);

impl Observer for Visited<'_> {
    fn step(&mut self, op: Op, id: u32) {
        if matches!(op, Op::Node | Op::Primitive) {
            self.0.push((op, id));
        }
    }
}

/// Triangles one behind the other, seen end on.
fn row(count: u32) -> Vec<Triangle> {
    let at = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(2.0, -1.0, z), Vec3::new(-1.0, 2.0, z)];
    (0..count).map(|index| Triangle { v: at(index as f32) }).collect()
}

#[test]
fn children_are_visited_from_near_to_far_on_either_side() {
    let triangles = row(8);
    let wide = full::<8>(&triangles, NodeFormat::Adreno8);
    assert_eq!(wide.statistics().nodes, 1, "eight leaves of one triangle");
    for (origin, direction, nearest) in [(-1.0, Vec3::Z, 0), (9.0, -Vec3::Z, 7)] {
        let mut visited = Vec::new();
        let ray = Ray::new(Vec3::new(0.0, 0.0, origin), direction);
        let hit = wide::stack::trace(&wide, &ray, Query::Closest, &mut Visited(&mut visited));
        assert_eq!(hit.primitive, nearest);
        assert_eq!(visited.len(), 2, "the root, and one triangle: the others lie behind it: {visited:?}");
    }
}

#[test]
fn a_full_tree_of_width_four_is_half_as_deep() {
    let triangles = row(64);
    let binary = Bvh::build(&triangles, &BvhOptions { max_leaf: 1, ..BvhOptions::EQUAL_COSTS });
    let binary_depth = binary.depth();
    let wide = WideBvh::<_, 4>::collapse(binary, NodeFormat::Full4).unwrap();
    assert_eq!((binary_depth, wide.depth()), (6, 2));
    let statistics = wide.statistics();
    assert_eq!((statistics.nodes, statistics.leaves), (1 + 4 + 16, 64));
}

#[test]
fn scenes_without_and_with_one_triangle_have_a_root() {
    for count in [0, 1] {
        let triangles = row(count);
        for format in NodeFormat::ALL {
            let wide = structure(&triangles, format, TriangleTest::MoellerTrumbore);
            let ray = Ray::new(Vec3::new(0.0, 0.0, -1.0), Vec3::Z);
            let mut counter = WorkCounter::new(NodeFetch::Single);
            let hit = wide.trace(&ray, Query::Closest, &mut counter);
            assert_eq!(hit.is_hit(), count == 1);
            assert_eq!((counter.work().node_fetches, counter.work().box_tests), (1, u64::from(count)));
        }
    }
}

#[test]
fn copies_of_one_triangle_are_split_to_the_limit_of_a_leaf() {
    let triangles = vec![row(1)[0]; 100];
    let wide = full::<8>(&triangles, NodeFormat::Adreno8);
    assert_eq!(wide.validate(&triangles), Ok(()));
    assert_eq!(wide.statistics().leaves, 100);
    let ray = Ray::new(Vec3::new(0.0, 0.0, -1.0), Vec3::Z);
    let hit: Hit = wide::stack::trace(&wide, &ray, Query::Closest, &mut Silent);
    assert_eq!(hit.primitive, 0, "among equals the lowest");
}

#[test]
fn what_origins_of_16_bits_cannot_hold_is_refused() {
    let far = Triangle { v: [Vec3::splat(f32::MIN), Vec3::ZERO, Vec3::X] };
    let built = AccelerationStructure::build(
        &[far],
        Traversal::WideStack { format: NodeFormat::Adreno8 },
        &BuildOptions::default(),
    );
    let error = built.err().expect("no such number").to_string();
    assert!(error.contains("adreno-8") && error.contains("--node-format"), "{error}");
}

#[test]
fn the_binary_tree_keeps_to_its_limit_of_triangles_in_a_leaf() {
    let triangles = row(1000);
    for max_leaf in [1, 2, 3, 7] {
        let bvh = Bvh::build(&triangles, &BvhOptions { max_leaf, traversal_cost: 1e9, ..BvhOptions::MOBILE });
        assert_eq!(bvh.validate(&triangles), Ok(()));
        assert!(bvh.statistics().largest_leaf <= max_leaf);
        let ray = Ray::new(Vec3::new(0.0, 0.0, 999.5), -Vec3::Z);
        assert_eq!(bvh::stack::trace(&bvh, &ray, Query::Closest, &mut Silent).primitive, 999);
    }
}
