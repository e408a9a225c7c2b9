//! Input at the edge of what a number can be: rays, vertices and scenes.

use crate::Size;
use crate::case::{Case, Limit};
use crate::exact::ROUNDINGS;
use crate::judge::Verdicts;
use crate::random::Random;
use crate::reference::Reference;
use crate::shapes;
use crate::structures::{Structure, Watch, all, brute_force, options, same, traversals};
use glam::Vec3;
use scenes::Triangle;
use tracer::{Query, Ray, TriangleTest};

/// Largest coordinate of an origin for which structures have to agree: some thousand triangles away.
const FARTHEST: f32 = 1e3;

pub(crate) fn cases(size: Size, watch: &Watch) -> Vec<Case> {
    let mut cases = Vec::new();
    for test in TriangleTest::ALL {
        cases.extend([
            odd_rays(size, test, watch),
            few_triangles(test, watch),
            largest_boxes(test, watch),
            collinear(test, watch),
            tiny(size, test, watch),
        ]);
        cases.extend(random_vertices(size, test, watch));
    }
    cases
}

/// Rays of which each field in turn is at the edge, or all are random bits.
fn odd_rays(size: Size, test: TriangleTest, watch: &Watch) -> Case {
    let triangles = shapes::soup(200, 3);
    let of_fields = |f: [f32; 8]| Ray {
        origin: Vec3::new(f[0], f[1], f[2]),
        t_min: f[3],
        direction: Vec3::new(f[4], f[5], f[6]),
        t_max: f[7],
    };
    let edges =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45];
    let mut rays = vec![Ray::new(Vec3::ZERO, Vec3::ZERO)];
    for edge in edges {
        for field in 0..8 {
            let mut fields = [0.1, 0.2, 0.3, 0.0, 0.4, -0.5, 0.6, 10.0];
            fields[field] = edge;
            rays.push(of_fields(fields));
        }
        rays.push(of_fields([0.1, 0.2, 0.3, 0.0, edge, edge, edge, 10.0]));
        rays.push(of_fields([edge; 8]));
    }
    let mut random = Random(31);
    for _ in 0..size.of(500, 20_000) {
        rays.push(of_fields([0; 8].map(|_| f32::from_bits(random.bits() as u32))));
    }
    let structures = all(&triangles, &options(test));
    let mut differing = 0;
    for ray in &rays {
        // Structures agree on rays from within the range that the case 'same-hits/reach' states; from beyond they only have to end.
        let is_far = ray.origin.is_finite() && ray.origin.abs().max_element() > FARTHEST;
        let expected = brute_force(&triangles, test, ray);
        for structure in &structures {
            let hit = structure.trace(watch, ray, Query::Closest);
            let agree = if expected.is_hit() { same(&hit, &expected) } else { !hit.is_hit() };
            differing += u64::from(!agree && !is_far);
        }
    }
    Case::none_of(
        format!("degenerate/rays/{}", test.name()),
        "NaN, infinity, zero and random bits in any field of a ray: every traversal ends as a loop over all triangles does",
        "differing hits",
        differing,
    )
    .because(format!("{} rays by {} traversals", rays.len(), structures.len()))
}

/// Vertices of random bits: refused by all builders where one is not finite, else built and traced.
fn random_vertices(size: Size, test: TriangleTest, watch: &Watch) -> [Case; 2] {
    let (mut accepted, mut refused, mut unlike, mut traced) = (0_u64, 0_u64, 0_u64, 0_u64);
    let mut random = Random(404);
    for round in 0..size.of(100, 2000) {
        let mut vertex = || Vec3::from([0; 3].map(|_| f32::from_bits(random.bits() as u32)));
        let mut triangles: Vec<Triangle> =
            (0..1 + round % 8).map(|_| Triangle { v: [vertex(), vertex(), vertex()] }).collect();
        if round % 2 == 0 {
            // One in 128 random numbers is not finite: half of the rounds have only finite ones.
            let coordinates = triangles.iter_mut().flat_map(|triangle| &mut triangle.v);
            coordinates.for_each(|corner| *corner = corner.map(|x| if x.is_finite() { x } else { 1.0 }));
        }
        let is_finite = triangles.iter().all(|triangle| triangle.v.iter().all(|corner| corner.is_finite()));
        for traversal in traversals() {
            match Structure::build(&triangles, traversal, &options(test)) {
                Ok(structure) => {
                    accepted += 1;
                    unlike += u64::from(!is_finite);
                    for _ in 0..4 {
                        let target = triangles[0].v[random.below(3)];
                        let origin = random.point();
                        let ray = Ray::new(origin, target - origin);
                        structure.trace(watch, &ray, Query::Closest);
                        traced += 1;
                    }
                }
                Err(_) => {
                    refused += 1;
                    unlike += u64::from(is_finite);
                }
            }
        }
    }
    [
        Case::none_of(
            format!("degenerate/vertices/{}", test.name()),
            "vertices of random bits: a structure is refused if and only if one is not finite",
            "structures",
            unlike,
        )
        .because(format!("{accepted} built and {refused} refused; {traced} rays traced")),
        Case::new(
            format!("degenerate/vertices/both/{}", test.name()),
            "vertices of random bits: some structures are refused and some are not",
            "structures of the fewer",
            Limit::AtLeast(10.0),
            accepted.min(refused) as f64,
        ),
    ]
}

/// No triangle, one, and one without area.
fn few_triangles(test: TriangleTest, watch: &Watch) -> Case {
    let triangle = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
    let across = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
    let in_plane = Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X);
    let line = Triangle { v: [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X] };
    let point = Triangle { v: [Vec3::ONE; 3] };
    let to_point = Ray::new(Vec3::ZERO, Vec3::ONE);
    let expectations: [(&[Triangle], Ray, bool); 6] = [
        (&[], across, false),
        (&[triangle], across, true),
        (&[triangle], in_plane, false),
        (&[triangle], Ray { t_max: 1.0_f32.next_down(), ..across }, false),
        (&[line], Ray::new(Vec3::new(0.5, 0.0, 1.0), Vec3::NEG_Z), false),
        (&[point], to_point, false),
    ];
    let mut unlike = 0;
    for (triangles, ray, is_hit) in expectations {
        for structure in all(triangles, &options(test)) {
            unlike += u64::from(structure.trace(watch, &ray, Query::Closest).is_hit() != is_hit);
        }
    }
    Case::none_of(
        format!("degenerate/few/{}", test.name()),
        "no triangle, one, one seen edge on, a line, a point: hit across, and missed otherwise",
        "wrong hits",
        unlike,
    )
}

/// Coordinates up to the largest float.
fn largest_boxes(test: TriangleTest, watch: &Watch) -> Case {
    let far = f32::MAX;
    let triangles = [
        Triangle { v: [Vec3::splat(-far), Vec3::splat(far), Vec3::ZERO] },
        Triangle { v: [Vec3::new(-far, -far, 5.0), Vec3::new(far, -far, 5.0), Vec3::new(0.0, far, 5.0)] },
        Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] },
    ];
    let mut unlike = 0;
    for structure in all(&triangles, &options(test)) {
        let ray = Ray::new(Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
        unlike += u64::from(structure.trace(watch, &ray, Query::Closest).primitive != 2);
        for direction in [Vec3::splat(far), Vec3::splat(-far), Vec3::splat(f32::MIN_POSITIVE)] {
            structure.trace(watch, &Ray::new(Vec3::splat(0.5), direction), Query::Closest);
        }
    }
    Case::none_of(
        format!("degenerate/largest-boxes/{}", test.name()),
        "a small triangle among triangles as large as floats go is hit by every traversal",
        "wrong hits",
        unlike,
    )
    .under("extent", f64::from(far))
}

/// The collinear triangle of pbrt's tests.
fn collinear(test: TriangleTest, watch: &Watch) -> Case {
    let corner = |y| Vec3::new(-1113.4546, y, -56.24319);
    let triangle = Triangle { v: [corner(-79.049614), corner(-87.09227), corner(-79.209015)] };
    let ray = Ray {
        t_max: 0.9999,
        ..Ray::new(Vec3::new(-1081.4792, 99.999954, 87.77011), Vec3::new(-32.1073, -183.35587, -144.60764))
    };
    let hits = all(&[triangle], &options(test))
        .iter()
        .filter(|structure| structure.trace(watch, &ray, Query::Closest).is_hit())
        .count();
    Case::none_of(
        format!("degenerate/collinear/{}", test.name()),
        "the collinear triangle of pbrt's tests is missed by every traversal",
        "hits",
        hits as u64,
    )
}

/// A triangle of edge 2e-4, the size that an absolute threshold on the determinant drops.
fn tiny(size: Size, test: TriangleTest, watch: &Watch) -> Case {
    let edge = 2e-4;
    let triangles = [Triangle { v: [Vec3::ZERO, Vec3::new(edge, 0.0, 0.0), Vec3::new(0.0, edge, 0.0)] }];
    let reference = Reference::new(&triangles);
    let structures = all(&triangles, &options(test));
    let mut random = Random(2e4 as u64);
    let mut verdicts = Verdicts::default();
    for _ in 0..size.of(500, 5000) {
        let distance = random.log_uniform(1e-4, 100.0) as f32;
        let origin = distance * random.direction();
        let target = Vec3::new(0.4 * edge * random.unit() as f32, 0.4 * edge * random.unit() as f32, 0.0);
        let ray = Ray::new(origin, target - origin);
        let exact = reference.nearest(&ray);
        for structure in &structures {
            let hit = structure.trace(watch, &ray, Query::Closest);
            verdicts = verdicts.and(Verdicts::of(&reference, &ray, &hit, exact));
        }
    }
    Case::none_of(
        format!("degenerate/tiny/{}", test.name()),
        format!(
            "a triangle of edge 2e-4 from 1e-4 to 100 away: no decision is wrong beyond {ROUNDINGS} roundings"
        ),
        "wrong decisions",
        verdicts.wrong,
    )
    .under("largest condition of a hit", verdicts.condition)
    .because(format!(
        "{} of {} rays differ, {} of them lost",
        verdicts.differing, verdicts.rays, verdicts.lost
    ))
}
