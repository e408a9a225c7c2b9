//! Is the kd-tree the one that Wald & Havran 2006 describe, whatever the triangles?

mod kd_support;

use kd_support::*;
use proptest::prelude::*;
use scenes::{Triangle, Vec3};
use tracer::Error;
use tracer::kd::{FlatCells, KdNodeKind, KdOptions, KdStatistics, KdTree, Splits};

/// Builds, checks, and returns the counts.
fn build(triangles: &[Triangle], options: &KdOptions) -> (KdTree, KdStatistics) {
    let tree = KdTree::build(triangles, options).unwrap();
    let statistics = tree.validate().unwrap();
    assert_eq!(statistics.leaves * 2, statistics.nodes + 1);
    (tree, statistics)
}

/// The slow twin: each cell prices every plane by counting all boxes again.
struct Twin<'a> {
    options: &'a KdOptions,
    depth_cap: u32,
}

type Box3 = [[f32; 2]; 3];

impl Twin<'_> {
    fn split(&self, cell: &Box3, boxes: &[(u32, Box3)]) -> Option<(usize, f32, bool)> {
        let extent = cell.map(|[low, high]| f64::from(high) - f64::from(low));
        let area = extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0];
        let mut best = self.options.intersection_cost * boxes.len() as f64 * area;
        let mut found = None;
        for axis in (0..3).filter(|&axis| extent[axis] > 0.0 && area > 0.0) {
            let [low, high] = cell[axis];
            let mut planes: Vec<f32> = boxes.iter().flat_map(|(_, b)| b[axis]).collect();
            planes.sort_by(f32::total_cmp);
            planes.dedup();
            for plane in planes {
                for planar_left in [false, true] {
                    let (left, right) = sides(boxes, axis, plane, planar_left);
                    let on_face = plane <= low && right.is_empty() | planar_left && !left.is_empty()
                        || plane >= high && !planar_left && !right.is_empty();
                    let flat_child = self.options.flat_cells == FlatCells::Allowed
                        && (plane <= low && planar_left && !left.is_empty() || on_face && plane >= high);
                    if !(low < plane && plane < high || flat_child) {
                        continue;
                    }
                    let (a, b) = (extent[(axis + 1) % 3], extent[(axis + 2) % 3]);
                    let part = |thickness: f64| a * b + (a + b) * thickness;
                    let left_area = part(f64::from(plane) - f64::from(low));
                    let right_area = part(f64::from(high) - f64::from(plane));
                    let mut cost = self.options.traversal_cost * area
                        + self.options.intersection_cost
                            * (left_area * left.len() as f64 + right_area * right.len() as f64);
                    if left.is_empty() || right.is_empty() {
                        cost *= self.options.empty_bonus;
                    }
                    if cost < best {
                        best = cost;
                        found = Some((axis, plane, planar_left));
                    }
                }
            }
        }
        found
    }

    /// Compares the subtree at `node` with the twin's.
    fn compare(&self, tree: &KdTree, node: u32, cell: Box3, boxes: &[(u32, Box3)], depth: u32) {
        let split = if depth < self.depth_cap { self.split(&cell, boxes) } else { None };
        match (tree.nodes()[node as usize].kind(), split) {
            (KdNodeKind::Leaf { first, count }, None) => {
                let ids: Vec<_> = boxes.iter().map(|b| b.0).collect();
                assert_eq!(tree.references()[first as usize..][..count as usize], ids);
            }
            (KdNodeKind::Inner { axis, split, left }, Some(expected)) => {
                assert_eq!((axis, split), (expected.0, expected.1), "node {node} at depth {depth}");
                let children = sides(boxes, axis, split, expected.2);
                for (child, mut boxes) in [(0, children.0), (1, children.1)] {
                    let mut cell = cell;
                    cell[axis][1 - child] = split;
                    for (_, b) in &mut boxes {
                        b[axis] = [b[axis][0].max(cell[axis][0]), b[axis][1].min(cell[axis][1])];
                    }
                    self.compare(tree, left + child as u32, cell, &boxes, depth + 1);
                }
            }
            (kind, expected) => panic!("node {node} at depth {depth}: {kind:?}, the twin: {expected:?}"),
        }
    }
}

type Boxes = Vec<(u32, Box3)>;

fn sides(boxes: &[(u32, Box3)], axis: usize, plane: f32, planar_left: bool) -> (Boxes, Boxes) {
    let keep = |is_left: bool| {
        let keeps = move |b: &&(u32, Box3)| {
            let [low, high] = b.1[axis];
            let is_planar = low == plane && high == plane;
            if is_planar {
                planar_left == is_left
            } else if is_left {
                low < plane
            } else {
                high > plane
            }
        };
        boxes.iter().filter(keeps).copied().collect()
    };
    (keep(true), keep(false))
}

fn compare_with_twin(triangles: &[Triangle]) {
    for options in all_options().iter().filter(|options| options.splits == Splits::BoundingBox) {
        let (tree, _) = build(triangles, options);
        let boxes: Boxes = (0..)
            .zip(triangles)
            .map(|(id, t)| {
                let [a, b, c] = t.v.map(|p| p + Vec3::ZERO);
                let (low, high) = (a.min(b).min(c), a.max(b).max(c));
                (id, [0, 1, 2].map(|axis| [low[axis], high[axis]]))
            })
            .collect();
        let (low, high) = bounds(triangles);
        let cell = [0, 1, 2].map(|axis| [low[axis] + 0.0, high[axis] + 0.0]);
        let twin = Twin { options, depth_cap: options.depth_cap(triangles.len()) };
        twin.compare(&tree, 0, cell, &boxes, 0);
    }
}

#[test]
fn a_soup_gives_the_tree_of_the_twin() {
    for seed in 0..4 {
        compare_with_twin(&soup(120, seed));
    }
}

#[test]
fn coplanar_quads_give_the_tree_of_the_twin() {
    compare_with_twin(&quads(2));
    compare_with_twin(&quads(3));
}

/// Every point of a triangle lies in a leaf that refers to it.
fn check_cover(triangles: &[Triangle], tree: &KdTree) {
    let mut random = Random(1);
    for (id, triangle) in (0..).zip(triangles) {
        for _ in 0..20 {
            let (u, v) = (random.signed().abs(), random.signed().abs());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = triangle.v.map(Vec3::as_dvec3);
            let point = a + (b - a) * f64::from(u) + (c - a) * f64::from(v);
            let mut node = 0;
            let mut on_a_plane = false;
            let leaf = loop {
                match tree.nodes()[node as usize].kind() {
                    KdNodeKind::Inner { axis, split, left } => {
                        on_a_plane |= (point[axis] - f64::from(split)).abs() < 1e-9;
                        node = left + u32::from(point[axis] > f64::from(split));
                    }
                    KdNodeKind::Leaf { first, count } => {
                        break &tree.references()[first as usize..][..count as usize];
                    }
                }
            };
            assert!(on_a_plane || leaf.contains(&id), "{point} of triangle {id} is in a leaf of {leaf:?}");
        }
    }
}

#[test]
fn every_point_of_a_triangle_is_in_a_leaf_that_refers_to_it() {
    let triangles = soup(2000, 9);
    for options in all_options() {
        check_cover(&triangles, &build(&triangles, &options).0);
    }
}

#[test]
fn perfect_splits_leave_fewer_references_at_less_cost() {
    let triangles = soup(2000, 10);
    let boxes = KdOptions { splits: Splits::BoundingBox, ..KdOptions::WALD_HAVRAN };
    let perfect = KdOptions::WALD_HAVRAN;
    let cost = |options: &KdOptions| build(&triangles, options).0.sah_cost(15.0, 20.0).unwrap();
    assert!(cost(&perfect) < cost(&boxes));
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let triangles = soup(40_000, 3);
    for options in [KdOptions::MOBILE, KdOptions::WALD_HAVRAN] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&triangles, &options).0)
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.nodes(), three.nodes());
        assert_eq!(one.references(), three.references());
    }
}

#[test]
fn the_order_of_triangles_does_not_change_the_cells() {
    let triangles = soup(500, 4);
    let reversed: Vec<_> = triangles.iter().rev().copied().collect();
    let counts = |triangles: &[Triangle]| build(triangles, &KdOptions::WALD_HAVRAN).1;
    assert_eq!(counts(&triangles), counts(&reversed));
}

#[test]
fn zero_triangles_give_one_empty_leaf() {
    let (tree, statistics) = build(&[], &KdOptions::MOBILE);
    let expected = KdStatistics { nodes: 1, leaves: 1, empty_leaves: 1, ..KdStatistics::default() };
    assert_eq!(statistics, expected);
    assert_eq!(tree.sah_cost(1.0, 1.0), None);
}

#[test]
fn many_copies_of_one_triangle_give_one_cell_of_them() {
    let triangle = Triangle { v: [Vec3::ZERO, Vec3::new(1.0, 0.5, 0.0), Vec3::new(0.0, 1.0, 1.0)] };
    for count in [1, 2, 1000, 100_000] {
        let copies = vec![triangle; count];
        let (_, statistics) = build(&copies, &KdOptions::MOBILE);
        assert_eq!((statistics.nodes, statistics.references), (1, count as u64));
        // Clipping finds empty corners in the triangle's box, so there are cells; they do not exceed the budget.
        let (_, statistics) = build(&copies, &KdOptions::WALD_HAVRAN);
        let budget = KdOptions::REFERENCES_PER_TRIANGLE * count as u64 + KdOptions::FREE_REFERENCES;
        assert!(statistics.references <= budget);
    }
}

#[test]
fn degenerate_scenes_build() {
    let point = |x| Triangle { v: [Vec3::splat(x); 3] };
    let line = |x: f32| Triangle {
        v: [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0), Vec3::new(x, 0.0, 0.0)],
    };
    let floor = |x: f32| Triangle {
        v: [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, -0.0, 0.0), Vec3::new(x, 0.0, 1.0)],
    };
    let huge =
        Triangle { v: [Vec3::splat(f32::MIN), Vec3::splat(f32::MAX), Vec3::new(f32::MAX, 0.0, f32::MIN)] };
    let sliver = Triangle {
        v: [Vec3::ZERO, Vec3::new(1e30, 1.0, f32::MIN_POSITIVE), Vec3::new(1e30, 1.0_f32.next_up(), 0.0)],
    };
    let many = |make: &dyn Fn(f32) -> Triangle| (0..100).map(|i| make(i as f32)).collect::<Vec<_>>();
    let mixed = [soup(100, 1), vec![huge, sliver, point(0.0), point(-0.0)]].concat();
    for scene in [many(&point), many(&line), many(&floor), vec![huge; 10], vec![sliver; 10], mixed] {
        for options in all_options() {
            build(&scene, &options);
        }
    }
}

#[test]
fn minus_zero_is_zero() {
    let with = |zero: f32| {
        let mut triangles = quads(2);
        triangles.iter_mut().flat_map(|t| &mut t.v).flat_map(AsMut::<[f32; 3]>::as_mut).for_each(|x| {
            *x = if *x == 0.0 { zero } else { *x };
        });
        build(&triangles, &KdOptions::MOBILE).0
    };
    assert_eq!(with(0.0).nodes(), with(-0.0).nodes());
    assert_eq!(with(0.0).references(), with(-0.0).references());
}

#[test]
fn a_corner_that_is_not_finite_is_refused_by_number() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut triangles = soup(5, 1);
        triangles[3].v[1].y = bad;
        let error = KdTree::build(&triangles, &KdOptions::MOBILE).unwrap_err();
        assert!(matches!(error, Error::Options(ref message) if message.contains("triangle 3")), "{error}");
    }
}

#[test]
fn options_out_of_range_are_refused_and_their_limits_accepted() {
    let builds = |options: KdOptions| KdTree::build(&soup(20, 1), &options).is_ok();
    let base = KdOptions::MOBILE;
    assert!(builds(KdOptions { traversal_cost: 0.0, ..base }));
    assert!(!builds(KdOptions { traversal_cost: -0.1, ..base }));
    assert!(!builds(KdOptions { traversal_cost: f64::NAN, ..base }));
    assert!(!builds(KdOptions { intersection_cost: 0.0, ..base }));
    assert!(!builds(KdOptions { intersection_cost: f64::INFINITY, ..base }));
    assert!(builds(KdOptions { empty_bonus: 1.0, ..base }));
    assert!(!builds(KdOptions { empty_bonus: 1.01, ..base }));
    assert!(!builds(KdOptions { empty_bonus: 0.0, ..base }));
    assert!(builds(KdOptions { max_depth: Some(KdOptions::MAX_DEPTH), ..base }));
    assert!(!builds(KdOptions { max_depth: Some(KdOptions::MAX_DEPTH + 1), ..base }));
}

#[test]
fn the_depth_cap_is_reached_and_not_passed() {
    let triangles = soup(5000, 2);
    for cap in [0, 1, 5, 12] {
        let options = KdOptions { max_depth: Some(cap), ..KdOptions::MOBILE };
        assert_eq!(build(&triangles, &options).1.depth, cap);
    }
    let caps = [(1, 8), (66_450, 29), (262_267, 31)];
    for (count, cap) in caps {
        assert_eq!(KdOptions::MOBILE.depth_cap(count), cap);
    }
}

#[test]
fn flat_cells_appear_only_where_allowed() {
    let triangles = quads(4);
    let flat = |flat_cells| {
        let options = KdOptions { flat_cells, ..KdOptions::WALD_HAVRAN };
        build(&triangles, &options).1.flat_leaves
    };
    assert_eq!(flat(FlatCells::Forbidden), 0);
    assert!(flat(FlatCells::Allowed) > 0);
}

#[test]
fn real_scenes_cost_what_a_second_implementation_says() {
    // Expected cost with Kt = 15, Ki = 20, lambda = 0.8: box splits, perfect splits. The other implementation forbids flat cells.
    // On Dabrovic's Sponza perfect splits come out 2 % cheaper here.
    let known = [
        ("bunny_69k", 1107.4, 960.8),
        ("sponza_dabrovic_66k", 1360.1, 1255.9),
        ("sponza_crytek_262k", 1703.6, 1427.5),
    ];
    for (name, boxes, perfect) in known {
        let Some(triangles) = real_scene(name) else { continue };
        for (splits, published) in [(Splits::BoundingBox, boxes), (Splits::Perfect, perfect)] {
            let options = KdOptions { splits, flat_cells: FlatCells::Forbidden, ..KdOptions::WALD_HAVRAN };
            let ours = build(&triangles, &options).0.sah_cost(15.0, 20.0).unwrap();
            let deviation = ours / published - 1.0;
            eprintln!(
                "{name} {splits:?}: expected {published}, got {ours:.1}, deviation {:+.2} %",
                100.0 * deviation
            );
            assert!(deviation < 0.01 && deviation > -0.025);
        }
    }
}

#[test]
fn real_scenes_have_the_node_counts_of_plain_sah() {
    for (name, nodes) in [("buddha_100k", 140_213.0), ("sponza_crytek_262k", 420_000.0)] {
        let Some(triangles) = real_scene(name) else { continue };
        let options = KdOptions { flat_cells: FlatCells::Forbidden, ..KdOptions::MOBILE };
        let deviation = build(&triangles, &options).1.nodes as f64 / nodes - 1.0;
        eprintln!("{name}: expected {nodes} nodes, deviation {:+.2} %", 100.0 * deviation);
        assert!(deviation.abs() < 0.005);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn triangles_on_a_coarse_grid_give_the_tree_of_the_twin(seed in any::<u64>(), count in 1_usize..40, grid in 1_u64..6) {
        let mut random = Random(seed);
        let mut coordinate = || (random.bits() % (grid + 1)) as f32 - 2.0;
        let mut point = || Vec3::new(coordinate(), coordinate(), coordinate());
        let triangles: Vec<_> = (0..count).map(|_| Triangle { v: [point(), point(), point()] }).collect();
        compare_with_twin(&triangles);
    }

    #[test]
    fn any_finite_bits_build(bits in prop::collection::vec(any::<[u32; 9]>(), 1..40)) {
        let finite = |bits: u32| Some(f32::from_bits(bits)).filter(|x| x.is_finite()).unwrap_or(f32::MAX);
        let triangles: Vec<_> = bits
            .iter()
            .map(|b| Triangle { v: [0, 3, 6].map(|i| Vec3::from([0, 1, 2].map(|k| finite(b[i + k])))) })
            .collect();
        for options in all_options() {
            build(&triangles, &options);
        }
    }
}
