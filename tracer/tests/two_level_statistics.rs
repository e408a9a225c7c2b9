//! Do the statistics of two levels agree with closed forms and with rays, and do the warnings follow them?

use glam::{Affine3A, Vec3};
use scenes::{Instance, Triangle};
use tracer::two_level::{MaskedInstance, SMALL_BLAS_TRIANGLES, TwoLevel, TwoLevelStatistics};
use tracer::wide::{NodeFormat, WideBvh};
use tracer::{Observer, Op, PreparedTriangle, Query, Ray};

const COSTS: [f64; 2] = [1.0, 1.0];

/// Standard errors of the shares of 4096 points and of 1024 lines.
const OVERLAP_ERROR: f64 = 0.5 / 64.0;
const EMPTY_ERROR: f64 = 0.5 / 32.0;

/// The twelve triangles of a box.
fn hull(min: Vec3, max: Vec3) -> Vec<Triangle> {
    let corner = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|v| Triangle { v: v.map(corner) })
        .collect()
}

fn cube() -> Vec<Triangle> {
    hull(Vec3::ZERO, Vec3::ONE)
}

fn moved(translations: impl IntoIterator<Item = Vec3>) -> Vec<MaskedInstance> {
    let instance = |v| Instance { mesh: 0, transform: Affine3A::from_translation(v) }.into();
    translations.into_iter().map(instance).collect()
}

fn statistics(meshes: &[Vec<Triangle>], instances: &[MaskedInstance]) -> TwoLevelStatistics {
    TwoLevel::build(meshes, instances, COSTS).unwrap().statistics()
}

#[test]
fn overlap_is_the_share_of_volume_in_more_than_one_box() {
    let share = |x: f32| statistics(&[cube()], &moved([Vec3::ZERO, x * Vec3::X])).overlap_share.unwrap();
    for (x, expected) in [(0.0, 1.0), (0.25, 0.75), (0.5, 0.5), (0.9, 0.1), (1.5, 0.0)] {
        assert!((share(x) - expected).abs() < 4.0 * OVERLAP_ERROR, "{} of {expected}", share(x));
    }
    // A small cube within a large one: the volume of the small one counts twice.
    let large = hull(Vec3::ZERO, Vec3::splat(2.0));
    let both = [Instance::identity(0).into(), Instance::identity(1).into()];
    let meshes = [cube(), large];
    let binary = statistics(&meshes, &both);
    let share = binary.overlap_share.unwrap();
    assert!((share - 2.0 / 9.0).abs() < 4.0 * OVERLAP_ERROR, "{share}");
    // How a TLAS rounds its boxes is no matter.
    type Wide = TwoLevel<PreparedTriangle, WideBvh<PreparedTriangle, 8>>;
    let wide = Wide::build_with(&meshes, &both, COSTS, NodeFormat::Adreno8).unwrap().statistics();
    assert_eq!((wide.overlap_share, wide.expected_entries), (binary.overlap_share, binary.expected_entries));
}

#[test]
fn a_hundred_thousand_instances_in_one_place_or_in_a_grid_are_measured_in_little_time() {
    let start = std::time::Instant::now();
    let one_place = statistics(&[cube()], &moved((0..100_000).map(|_| Vec3::ZERO)));
    assert_eq!((one_place.overlap_share, one_place.expected_entries), (Some(1.0), Some(100_000.0)));
    let grid =
        (0..100_000).map(|i| 2.0 * Vec3::new((i % 50) as f32, (i / 50 % 50) as f32, (i / 2500) as f32));
    assert_eq!(statistics(&[cube()], &moved(grid)).overlap_share, Some(0.0));
    // Pairs would be 5e9. The limit is that of a slow machine without optimisation.
    assert!(start.elapsed().as_secs() < 60);
}

/// What rays have entered.
#[derive(Default)]
struct Entered {
    instances: u32,
    leaves: u32,
}

impl Observer for Entered {
    fn step(&mut self, op: Op, _: u32) {
        self.instances += u32::from(op == Op::Instance);
    }

    fn leaf_visit(&mut self) {
        self.leaves += 1;
    }
}

/// Lines spread evenly over all that meet a box: those that meet the ball around it, as far as they meet the box.
fn lines(low: Vec3, high: Vec3, count: usize) -> Vec<Ray> {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    let (middle, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    let mut lines = Vec::new();
    while lines.len() < count {
        let direction = Vec3::new(random(), random(), random());
        let (x, y) = (random(), random());
        if direction.length_squared() > 1.0 || direction == Vec3::ZERO || x * x + y * y > 1.0 {
            continue;
        }
        let direction = direction.normalize();
        let (across, up) = direction.any_orthonormal_pair();
        let origin = middle + radius * (x * across + y * up - 2.0 * direction);
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        if a.min(b).max_element() <= a.max(b).min_element() {
            lines.push(Ray::new(origin, direction));
        }
    }
    lines
}

/// A mesh that fills its box and that hardly any ray hits: small triangles at two opposite corners, in one leaf each.
fn hollow() -> Vec<Triangle> {
    let at = |corner: Vec3, inwards: f32| Triangle {
        v: [
            corner,
            corner + Vec3::new(0.01 * inwards, 0.0, 0.0),
            corner + Vec3::new(0.0, 0.01 * inwards, 0.001 * inwards),
        ],
    };
    vec![at(Vec3::ZERO, 1.0), at(Vec3::ONE, -1.0)]
}

#[test]
fn random_rays_enter_as_many_instances_as_expected() {
    let instances =
        moved([Vec3::ZERO, Vec3::new(0.5, 0.0, 0.25), Vec3::new(3.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 4.0)]);
    let structure = TwoLevel::build(&[hollow()], &instances, COSTS).unwrap();
    let expected = structure.statistics().expected_entries.unwrap();
    // Boxes of half area 3 in one of 4 x 3 x 5.
    assert!((expected - 12.0 / 47.0).abs() < 1e-5, "{expected}");
    let lines = lines(Vec3::ZERO, Vec3::new(4.0, 3.0, 5.0), 40_000);
    let counts: Vec<f64> = lines
        .iter()
        .map(|ray| {
            let mut entered = Entered::default();
            structure.trace(ray, Query::Closest, 255, &mut entered);
            f64::from(entered.instances)
        })
        .collect();
    let mean = counts.iter().sum::<f64>() / counts.len() as f64;
    let variance = counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / counts.len() as f64;
    let error = (variance / counts.len() as f64).sqrt();
    assert!((mean - expected).abs() < 4.0 * error, "{mean} +- {error} of {expected}");
}

#[test]
fn empty_space_is_the_share_of_rays_that_enter_a_box_and_no_leaf() {
    // A full box has none, and neither has one of a single leaf.
    let one_leaf = vec![Triangle { v: [Vec3::ZERO, Vec3::new(1.0, 0.2, 0.1), Vec3::ONE] }];
    for mesh in [cube(), one_leaf] {
        let statistics = statistics(&[mesh], &[Instance::identity(0).into()]);
        assert_eq!(statistics.blases[0].empty_share, Some(0.0));
    }
    // Two cubes at opposite corners of a box, and two specks.
    let mut apart = cube();
    apart.extend(hull(Vec3::splat(3.0), Vec3::splat(4.0)));
    for (mesh, size) in [(apart, 4.0), (hollow(), 1.0)] {
        let structure = TwoLevel::build(&[mesh], &[Instance::identity(0).into()], COSTS).unwrap();
        let lines = lines(Vec3::ZERO, Vec3::splat(size), 20_000);
        let missed = lines.iter().filter(|ray| {
            let mut entered = Entered::default();
            structure.trace(ray, Query::Closest, 255, &mut entered);
            // The leaf of the TLAS is one.
            entered.leaves == 1
        });
        let expected = missed.count() as f64 / lines.len() as f64;
        let share = structure.statistics().blases[0].empty_share.unwrap();
        assert!(expected > 0.5 && (share - expected).abs() < 4.0 * EMPTY_ERROR, "{share} of {expected}");
    }
}

#[test]
fn a_mesh_without_an_instance_is_measured_and_not_warned_of() {
    let statistics = statistics(&[cube(), hollow()], &[Instance::identity(0).into()]);
    assert_eq!(
        statistics.blases.iter().map(|blas| (blas.instances, blas.triangles)).collect::<Vec<_>>(),
        [(1, 12), (0, 2)]
    );
    assert_eq!(statistics.warnings(SMALL_BLAS_TRIANGLES), Vec::<String>::new());
}

#[test]
fn each_warning_comes_with_its_cause_alone() {
    let warnings = |x: f32, small| statistics(&[cube()], &moved([Vec3::ZERO, x * Vec3::X])).warnings(small);
    // 12 triangles are fewer than 13, and two instances could be one BLAS.
    assert_eq!(warnings(2.0, 12), Vec::<String>::new());
    let small = warnings(2.0, 13);
    assert!(
        small.len() == 1
            && small[0].starts_with("1 of 1 BLASes, with 2 of 2 instances, have fewer than 13 triangles")
    );
    // A quarter of overlap is allowed.
    assert_eq!(warnings(0.8, 0), Vec::<String>::new());
    let overlap = warnings(0.7, 0);
    assert!(overlap.len() == 1 && overlap[0].contains("a random ray enters 1.4 BLASes"), "{overlap:?}");
    let empty = statistics(&[cube(), hollow()], &[Instance::identity(1).into()]).warnings(0);
    assert!(empty.len() == 1 && empty[0].starts_with("1 of 1 BLASes are mostly empty space"), "{empty:?}");
    assert!(empty[0].contains("mesh 1"));
}
