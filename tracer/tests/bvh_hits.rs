//! Do the BVH traversals find what brute force finds, and do they do the work that theory says?

use glam::Vec3;
use proptest::prelude::*;
use scenes::Triangle;
use tracer::bvh::restart_trail::{MAX_SHORT_STACK, TrailBits};
use tracer::bvh::{self, Bvh, BvhNodeKind, BvhOptions};
use tracer::grid::{Grid, dda};
use tracer::{
    AccelerationStructure, BuildOptions, Hit, NodeFetch, Observer, Op, PreparedTriangle, Query, Ray, Silent,
    SlabRay, Traversal, Work, WorkCounter,
};

fn brute_force(triangles: &[Triangle], ray: &Ray) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    for (primitive, triangle) in (0..).zip(triangles) {
        if let Some((t, u, v)) = PreparedTriangle::from(triangle).intersect(ray, best.t)
            && (t < best.t || primitive < best.primitive)
        {
            best = Hit { t, u, v, primitive };
        }
    }
    best
}

/// Recursive traversal in axis order, the slow and obvious twin of parent links: tests a box when it comes to it.
fn axis_order_stack(bvh: &Bvh, index: u32, ray: &Ray, any: bool, best: &mut Hit, work: &mut Work) -> bool {
    let node = bvh.node(index);
    work.box_tests += 1;
    let (near, far) = SlabRay::new(ray, bvh.plane_slack()).entry_exit(&node.bounds, ray.t_min, best.t);
    let hit = near <= far;
    if !hit {
        return false;
    }
    match node.kind {
        BvhNodeKind::Inner { axis, left } => {
            let near = left + u32::from(ray.direction[axis] < 0.0);
            let far = if near == left { left + 1 } else { left };
            axis_order_stack(bvh, near, ray, any, best, work)
                || axis_order_stack(bvh, far, ray, any, best, work)
        }
        BvhNodeKind::Leaf { first, count } => {
            work.leaf_visits += 1;
            for position in first..first + count {
                work.primitive_tests += 1;
                let primitive = bvh.references()[position as usize];
                let hit = TRIANGLES.with(|all| {
                    PreparedTriangle::from(&all.borrow()[primitive as usize]).intersect(ray, best.t)
                });
                if let Some((t, u, v)) = hit
                    && (t < best.t || primitive < best.primitive)
                {
                    *best = Hit { t, u, v, primitive };
                    if any {
                        return true;
                    }
                }
            }
            false
        }
    }
}

thread_local! {
    static TRIANGLES: std::cell::RefCell<Vec<Triangle>> = const { std::cell::RefCell::new(Vec::new()) };
}

fn point(range: f32) -> impl Strategy<Value = Vec3> {
    [-range..range, -range..range, -range..range].prop_map(Vec3::from)
}

/// Coordinates on a coarse grid: shared planes, duplicates, flat boxes and ties.
fn grid_point() -> impl Strategy<Value = Vec3> {
    [-3_i8..4, -3_i8..4, -3_i8..4].prop_map(|[x, y, z]| Vec3::new(f32::from(x), f32::from(y), f32::from(z)))
}

fn soup() -> impl Strategy<Value = Vec<Triangle>> {
    let small = (point(1.0), point(0.2), point(0.2)).prop_map(|(a, b, c)| Triangle { v: [a, a + b, a + c] });
    let gridded = [grid_point(), grid_point(), grid_point()].prop_map(|v| Triangle { v });
    prop_oneof![prop::collection::vec(small, 0..120), prop::collection::vec(gridded, 0..120),]
}

fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let free = (point(3.0), point(1.0)).prop_map(|(o, d)| Ray::new(o, d));
    // Origins on vertex planes, directions along axes with either zero.
    let axial = (grid_point(), 0_usize..3, any::<[bool; 3]>()).prop_map(|(origin, axis, negative)| {
        let mut direction = negative.map(|negative| if negative { -0.0_f32 } else { 0.0 });
        direction[axis] = if negative[axis] { -1.0 } else { 1.0 };
        Ray::new(origin, Vec3::from(direction))
    });
    prop::collection::vec(prop_oneof![free, axial], 1..40)
}

fn counted(trace: impl FnOnce(&mut WorkCounter) -> Hit, fetch: NodeFetch) -> (Hit, Work) {
    let mut counter = WorkCounter::new(fetch);
    let hit = trace(&mut counter);
    (hit, counter.work())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_traversal_finds_the_hit_of_brute_force(triangles in soup(), rays in rays(), mobile: bool) {
        let options = if mobile { BvhOptions::MOBILE } else { BvhOptions::EQUAL_COSTS };
        let bvh = Bvh::build(&triangles, &options);
        prop_assert_eq!(bvh.validate(&triangles), Ok(()));
        let links = bvh::parent_link::ParentLinks::new(&bvh);
        let grid = Grid::build(&triangles).unwrap();
        for ray in &rays {
            let expected = brute_force(&triangles, ray);
            let closest = Query::Closest;
            prop_assert_eq!(dda::trace(&grid, ray, closest, &mut Silent), expected);
            prop_assert_eq!(dda::trace(&grid, ray, Query::Any, &mut Silent).is_hit(), expected.is_hit());
            prop_assert_eq!(bvh::stack::trace(&bvh, ray, closest, &mut Silent), expected);
            prop_assert_eq!(bvh::parent_link::trace(&bvh, &links, ray, closest, &mut Silent), expected);
            for entries in [0, 1, 3, MAX_SHORT_STACK] {
                let hit = bvh::restart_trail::trace(&bvh, TrailBits::Bits64, entries, ray, closest, &mut Silent);
                prop_assert_eq!(hit, expected);
            }
            let any = bvh::stack::trace(&bvh, ray, Query::Any, &mut Silent);
            prop_assert_eq!(any.is_hit(), expected.is_hit());
            let any = bvh::parent_link::trace(&bvh, &links, ray, Query::Any, &mut Silent);
            prop_assert_eq!(any.is_hit(), expected.is_hit());
            let any = bvh::restart_trail::trace(&bvh, TrailBits::Bits64, 0, ray, Query::Any, &mut Silent);
            prop_assert_eq!(any.is_hit(), expected.is_hit());
        }
    }

    #[test]
    fn parent_links_do_the_tests_of_a_stack_in_axis_order(triangles in soup(), rays in rays(), any: bool) {
        let bvh = Bvh::build(&triangles, &BvhOptions::EQUAL_COSTS);
        let links = bvh::parent_link::ParentLinks::new(&bvh);
        TRIANGLES.set(triangles);
        let query = if any { Query::Any } else { Query::Closest };
        for ray in &rays {
            let mut expected_hit = Hit::miss(ray.t_max);
            let mut expected = Work::default();
            axis_order_stack(&bvh, 0, ray, any, &mut expected_hit, &mut expected);
            let (hit, work) = counted(|o| bvh::parent_link::trace(&bvh, &links, ray, query, o), NodeFetch::Single);
            prop_assert_eq!(hit, expected_hit);
            prop_assert_eq!(work.box_tests, expected.box_tests);
            prop_assert_eq!(work.primitive_tests, expected.primitive_tests);
            prop_assert_eq!(work.leaf_visits, expected.leaf_visits);
            prop_assert_eq!(work.node_fetches, work.box_tests + work.up_steps);
        }
    }

    #[test]
    fn a_restart_trail_with_a_deep_short_stack_fetches_what_the_stack_fetches(
        triangles in soup(), rays in rays(), any: bool
    ) {
        let bvh = Bvh::build(&triangles, &BvhOptions::EQUAL_COSTS);
        let query = if any { Query::Any } else { Query::Closest };
        for ray in &rays {
            let (hit, stack) = counted(|o| bvh::stack::trace(&bvh, ray, query, o), NodeFetch::Pair);
            let mut fewer = u64::MAX;
            for entries in [0, 1, 2, MAX_SHORT_STACK] {
                let trail = |o: &mut WorkCounter| {
                    bvh::restart_trail::trace(&bvh, TrailBits::Bits64, entries, ray, query, o)
                };
                let (trail_hit, work) = counted(trail, NodeFetch::Pair);
                prop_assert_eq!(trail_hit, hit);
                prop_assert!(work.node_fetches >= stack.node_fetches);
                prop_assert!(work.node_fetches <= fewer, "a larger short stack fetched more");
                fewer = work.node_fetches;
                if entries == MAX_SHORT_STACK {
                    prop_assert_eq!(work, stack);
                }
            }
        }
    }

    #[test]
    fn a_shallow_limit_is_kept_and_costs_no_hit(triangles in soup(), rays in rays()) {
        let max_depth = triangles.len().next_power_of_two().ilog2();
        let bvh = Bvh::build(&triangles, &BvhOptions { max_depth, ..BvhOptions::EQUAL_COSTS });
        prop_assert!(bvh.depth() <= max_depth);
        prop_assert_eq!(bvh.validate(&triangles), Ok(()));
        for ray in &rays {
            prop_assert_eq!(bvh::stack::trace(&bvh, ray, Query::Closest, &mut Silent), brute_force(&triangles, ray));
        }
    }

    #[test]
    fn any_bits_as_a_ray_end_within_the_tree(triangles in soup(), bits in any::<[u32; 8]>()) {
        let f = bits.map(f32::from_bits);
        let ray = Ray {
            origin: Vec3::new(f[0], f[1], f[2]),
            t_min: f[3],
            direction: Vec3::new(f[4], f[5], f[6]),
            t_max: f[7],
        };
        let bvh = Bvh::build(&triangles, &BvhOptions::MOBILE);
        let links = bvh::parent_link::ParentLinks::new(&bvh);
        let nodes = u64::from(bvh.node_count());
        let (_, stack) = counted(|o| bvh::stack::trace(&bvh, &ray, Query::Closest, o), NodeFetch::Pair);
        prop_assert!(stack.node_fetches <= nodes);
        let (_, linked) = counted(|o| bvh::parent_link::trace(&bvh, &links, &ray, Query::Closest, o), NodeFetch::Single);
        prop_assert!(linked.box_tests <= nodes && linked.up_steps <= nodes);
        bvh::restart_trail::trace(&bvh, TrailBits::Bits64, 0, &ray, Query::Closest, &mut Silent);
    }
}

/// Edge of the `i`-th of the nested triangles below, small enough for its square to be a float.
fn nested_edge(i: i32) -> f32 {
    2.0_f32.powi(i - 50)
}

/// A chain: each split takes one triangle off, so the tree is as deep as it may be.
fn nested(count: i32) -> Vec<Triangle> {
    (0..count)
        .map(|i| {
            let s = nested_edge(i);
            Triangle { v: [Vec3::new(s, 0.0, 0.0), Vec3::new(s, s, 0.0), Vec3::new(s, 0.0, s)] }
        })
        .collect()
}

#[test]
fn the_narrowest_trail_is_taken_that_the_depth_allows_and_changes_no_step() {
    assert_eq!(TrailBits::fitting(31), TrailBits::Bits32);
    assert_eq!(TrailBits::fitting(32), TrailBits::Bits64);
    for (nesting, expected) in [(20, TrailBits::Bits32), (100, TrailBits::Bits64)] {
        let triangles = nested(nesting);
        let options = BuildOptions { traversal_cost: 0.0, ..BuildOptions::default() };
        let [fitting, wide] = [None, Some(TrailBits::Bits64)].map(|bits| {
            let traversal = Traversal::BvhRestartTrail { bits, short_stack: 0 };
            AccelerationStructure::build(&triangles, traversal, &options).expect("valid")
        });
        assert_eq!(fitting.trail_bits(), Some(expected), "{} levels", fitting.depth());
        assert_eq!(wide.trail_bits(), Some(TrailBits::Bits64));
        for i in 0..nesting {
            let y = 0.2 * nested_edge(i);
            let ray = Ray::new(Vec3::new(-1.0, y, y), Vec3::X);
            let [ours, theirs] = [&fitting, &wide].map(|structure| {
                let mut steps = Steps::default();
                (structure.trace(&ray, Query::Closest, &mut steps), steps.0)
            });
            assert_eq!(ours, theirs);
        }
    }
}

#[test]
fn both_trails_agree_at_the_depth_limit_of_the_32_bit_one() {
    let triangles = nested(100);
    for bits in [TrailBits::Bits32, TrailBits::Bits64] {
        let options =
            BvhOptions { traversal_cost: 0.0, max_depth: bits.max_depth(), ..BvhOptions::EQUAL_COSTS };
        let bvh = Bvh::build(&triangles, &options);
        // The chain is deeper than the narrow trail is wide, so that one's limit is reached.
        match bits {
            TrailBits::Bits32 => assert_eq!(bvh.depth(), 31),
            TrailBits::Bits64 => assert!((32..=63).contains(&bvh.depth())),
        }
        for i in 0..100 {
            let y = 0.2 * nested_edge(i);
            for direction in [Vec3::X, Vec3::NEG_X] {
                let x = if direction.x > 0.0 { -1.0 } else { nested_edge(101) };
                let ray = Ray::new(Vec3::new(x, y, y), direction);
                let expected = brute_force(&triangles, &ray);
                assert!(expected.is_hit());
                for entries in [0, 2] {
                    let hit =
                        bvh::restart_trail::trace(&bvh, bits, entries, &ray, Query::Closest, &mut Silent);
                    assert_eq!(hit, expected);
                }
            }
        }
    }
}

#[test]
fn a_hundred_thousand_copies_of_one_triangle_build_and_the_first_one_is_hit() {
    let one = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
    let bvh = Bvh::build(&vec![one; 100_000], &BvhOptions::MOBILE);
    let ray = Ray::new(Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
    let hit = bvh::stack::trace(&bvh, &ray, Query::Closest, &mut Silent);
    assert_eq!((hit.primitive, hit.t), (0, 1.0));
}

#[test]
fn coordinates_up_to_the_largest_float_build_and_trace() {
    let far = f32::MAX;
    let triangles = [
        Triangle { v: [Vec3::splat(-far), Vec3::splat(far), Vec3::ZERO] },
        Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] },
    ];
    let bvh = Bvh::build(&triangles, &BvhOptions::MOBILE);
    assert_eq!(bvh.validate(&triangles), Ok(()));
    let ray = Ray::new(Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
    assert_eq!(bvh::stack::trace(&bvh, &ray, Query::Closest, &mut Silent).primitive, 1);
}

/// Counts pairs, to see that observers are told what the counting rules say.
#[derive(Default)]
struct Steps(Vec<(Op, u32)>);

impl Observer for Steps {
    fn step(&mut self, op: Op, id: u32) {
        self.0.push((op, id));
    }
}

#[test]
fn an_empty_scene_costs_the_root_fetch_and_misses() {
    let bvh = Bvh::build(&[], &BvhOptions::MOBILE);
    let mut steps = Steps::default();
    let hit = bvh::stack::trace(&bvh, &Ray::new(Vec3::ZERO, Vec3::X), Query::Closest, &mut steps);
    assert!(!hit.is_hit());
    assert_eq!(steps.0, [(Op::Node, 0)]);
}
