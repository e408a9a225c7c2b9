//! Scenes with instances, and what f64 says about their hits.

use glam::{Affine3A, DMat3, DVec3, Quat, Vec3};
use proptest::prelude::*;
use scenes::{Instance, Triangle};
use tracer::Ray;
use tracer::two_level::MaskedInstance;

/// Costs of the builds.
pub(crate) const COSTS: [f64; 2] = [3.0, 1.5];

#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) meshes: Vec<Vec<Triangle>>,
    pub(crate) instances: Vec<MaskedInstance>,
}

impl Scene {
    /// Instance and triangle of each primitive, in the order of the flattened scene.
    pub(crate) fn primitives(&self) -> Vec<(&MaskedInstance, Triangle)> {
        let mut all = Vec::new();
        for instance in &self.instances {
            let mesh = &self.meshes[instance.placement.mesh as usize];
            all.extend(mesh.iter().map(|&triangle| (instance, triangle)));
        }
        all
    }

    /// In world space, as `scenes::Scene::triangles` makes it.
    pub(crate) fn flattened(&self) -> Vec<Triangle> {
        let world = |(instance, Triangle { v }): (&MaskedInstance, Triangle)| Triangle {
            v: v.map(|corner| instance.placement.transform_point(corner)),
        };
        self.primitives().into_iter().map(world).collect()
    }
}

/// Evenly spread; from integers, as proptest 1.12 can fail an assertion of its own over a range of floats.
fn between(low: f32, high: f32) -> impl Strategy<Value = f32> {
    const STEPS: u32 = 1 << 24;
    (0..=STEPS).prop_map(move |step| low + (high - low) * (step as f32 / STEPS as f32))
}

fn point(range: f32) -> impl Strategy<Value = Vec3> {
    let axis = || between(-range, range);
    [axis(), axis(), axis()].prop_map(Vec3::from)
}

/// Coordinates on a coarse grid: shared planes, duplicates, flat boxes and ties.
fn grid_point() -> impl Strategy<Value = Vec3> {
    [-2_i8..3, -2_i8..3, -2_i8..3].prop_map(|[x, y, z]| Vec3::new(f32::from(x), f32::from(y), f32::from(z)))
}

fn mesh() -> impl Strategy<Value = Vec<Triangle>> {
    let small = (point(1.0), point(0.5), point(0.5)).prop_map(|(a, b, c)| Triangle { v: [a, a + b, a + c] });
    // Moller & Trumbore find hits of a triangle without area anywhere, so no tree could be as thick as that.
    let gridded = [grid_point(), grid_point(), grid_point()]
        .prop_map(|v| Triangle { v })
        .prop_filter("a triangle with an area", |triangle| !triangle.is_degenerate());
    prop_oneof![
        1 => Just(Vec::new()),
        4 => prop::collection::vec(small, 1..40),
        4 => prop::collection::vec(gridded, 1..40),
    ]
}

/// Rotations, scales with a sign per axis, on either side of each other, and moves by up to 10,000.
pub(crate) fn transform() -> impl Strategy<Value = Affine3A> {
    let rotation = || {
        (point(1.0), between(0.0, 6.0))
            .prop_map(|(axis, angle)| Quat::from_axis_angle(axis.try_normalize().unwrap_or(Vec3::X), angle))
    };
    let factor = || between(0.1, 4.0);
    let scale = ([factor(), factor(), factor()], any::<[bool; 3]>()).prop_map(|(scale, mirrored)| {
        let sign = mirrored.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        Vec3::from(scale) * Vec3::from(sign)
    });
    let translation = prop_oneof![point(2.0), point(100.0), point(10_000.0)];
    let affine =
        (rotation(), scale, rotation(), translation).prop_map(|(outer, scale, inner, translation)| {
            Affine3A::from_translation(translation)
                * Affine3A::from_quat(outer)
                * Affine3A::from_scale(scale)
                * Affine3A::from_quat(inner)
        });
    let moved = point(3.0).prop_map(Affine3A::from_translation);
    prop_oneof![1 => Just(Affine3A::IDENTITY), 1 => moved, 6 => affine]
}

pub(crate) fn scene(transforms: impl Strategy<Value = Affine3A>) -> impl Strategy<Value = Scene> {
    let mask = prop_oneof![Just(u8::MAX), any::<u8>()];
    let instances = prop::collection::vec((any::<prop::sample::Index>(), transforms, mask), 0..14);
    (prop::collection::vec(mesh(), 1..4), instances).prop_map(|(meshes, instances)| {
        let instances = instances
            .into_iter()
            .map(|(mesh, transform, mask)| MaskedInstance {
                placement: Instance { mesh: mesh.index(meshes.len()) as u32, transform },
                mask,
            })
            .collect();
        Scene { meshes, instances }
    })
}

/// How a ray is chosen once the scene is known.
#[derive(Clone, Debug)]
pub(crate) enum Aim {
    /// From `distance` away to a point of a triangle; barycentrics from 0 to 1 include its edges and corners.
    At { triangle: prop::sample::Index, weights: [f32; 2], direction: Vec3, distance: f32 },
    /// From a corner of a triangle, and so often from a face of a box.
    From { triangle: prop::sample::Index, direction: Vec3 },
    /// Anywhere near zero.
    Free(Ray),
}

pub(crate) fn aims() -> impl Strategy<Value = Vec<Aim>> {
    let weight = || prop_oneof![4 => between(0.0, 1.0), 1 => Just(0.0_f32), 1 => Just(1.0_f32)];
    let distance = prop_oneof![between(0.1, 10.0), between(10.0, 10_000.0)];
    let at = (any::<prop::sample::Index>(), [weight(), weight()], point(1.0), distance).prop_map(
        |(triangle, weights, direction, distance)| Aim::At { triangle, weights, direction, distance },
    );
    let axis = (0_usize..3, any::<bool>()).prop_map(|(axis, negative)| {
        let mut direction = Vec3::ZERO;
        direction[axis] = if negative { -1.0 } else { 1.0 };
        direction
    });
    let from = (any::<prop::sample::Index>(), prop_oneof![axis, point(1.0)])
        .prop_map(|(triangle, direction)| Aim::From { triangle, direction });
    let free =
        (point(5.0), point(1.0)).prop_map(|(origin, direction)| Aim::Free(Ray::new(origin, direction)));
    prop::collection::vec(prop_oneof![6 => at, 2 => from, 1 => free], 1..30)
}

impl Aim {
    /// The ray, into a flattened scene.
    pub(crate) fn ray(&self, flattened: &[Triangle]) -> Ray {
        match self {
            Aim::At { triangle, weights: [a, b], direction, distance } if !flattened.is_empty() => {
                let [p, q, r] = triangle.get(flattened).v;
                let target = p + *a * (q - p) + (1.0 - a) * b * (r - p);
                Ray::new(target - *distance * direction.normalize_or(Vec3::X), *direction)
            }
            Aim::From { triangle, direction } if !flattened.is_empty() => {
                Ray::new(triangle.get(flattened).v[0], *direction)
            }
            Aim::Free(ray) => *ray,
            _ => Ray::new(Vec3::ZERO, Vec3::X),
        }
    }
}

/// Where f64 puts a hit, and how far f32 arithmetic may put it from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// Parameter and weights of the second and third vertex.
    pub(crate) at: [f64; 3],
    /// Largest errors of the three.
    pub(crate) error: [f64; 3],
}

impl Verdict {
    /// No rounding can turn it into a miss.
    pub(crate) fn is_certain(&self, ray: &Ray) -> bool {
        self.margin(ray, 1.0)
    }

    /// Some rounding may give a hit.
    pub(crate) fn is_possible(&self, ray: &Ray) -> bool {
        self.margin(ray, -1.0)
    }

    fn margin(&self, ray: &Ray, sign: f64) -> bool {
        let ([t, u, v], [dt, du, dv]) = (self.at, self.error.map(|error| sign * error));
        u >= du
            && v >= dv
            && 1.0 - u - v >= du + dv
            && t >= f64::from(ray.t_min) + dt
            && t <= f64::from(ray.t_max) - dt
    }
}

/// In which arithmetic a structure finds a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Space {
    /// The ray is transformed, by f32 rows.
    Object,
    /// The triangle is, in f32.
    World,
}

const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Room for products of errors, which the bounds below leave out.
const SECOND_ORDER: f64 = 1.25;

/// A vector that f32 knows up to an error.
#[derive(Clone, Copy)]
struct Rounded {
    value: DVec3,
    error: DVec3,
}

/// `a . (b x c)` and the largest error of its value in f32: errors of the vectors, and six roundings of each product.
fn triple(a: Rounded, b: Rounded, c: Rounded) -> (f64, f64) {
    // The triple product with all terms positive.
    let permanent = |a: DVec3, b: DVec3, c: DVec3| {
        let [a, b, c] = [a, b, c].map(DVec3::abs);
        a.x * (b.y * c.z + b.z * c.y) + a.y * (b.z * c.x + b.x * c.z) + a.z * (b.x * c.y + b.y * c.x)
    };
    let error = permanent(a.error, b.value, c.value)
        + permanent(a.value, b.error, c.value)
        + permanent(a.value, b.value, c.error)
        + 6.0 * UNIT_ROUNDOFF * permanent(a.value, b.value, c.value);
    (a.value.dot(b.value.cross(c.value)), SECOND_ORDER * error)
}

/// The hit of Moller & Trumbore 1997 in f64, and the largest error of their algorithm in f32 by a running error analysis; `None` where
/// f32 does not even know the sign of the determinant.
pub(crate) fn verdict(
    instance: &MaskedInstance,
    triangle: &Triangle,
    ray: &Ray,
    space: Space,
) -> Option<Verdict> {
    let transform = &instance.placement.transform;
    let columns = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis];
    let [x, y, z] = columns.map(|column| Vec3::from(column).as_dvec3());
    let matrix = DMat3::from_cols(x, y, z);
    let translation = Vec3::from(transform.translation).as_dvec3();
    let is_identity = *transform == Affine3A::IDENTITY;
    let corners = triangle.v.map(Vec3::as_dvec3);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());

    // Corners, origin and direction in the space of the test, each with its error.
    let (corners, corner_error, origin, direction) = match space {
        Space::World => {
            let largest = corners.iter().map(|v| matrix.abs() * v.abs()).fold(DVec3::ZERO, DVec3::max);
            let rounding = if is_identity { 0.0 } else { 4.0 * UNIT_ROUNDOFF };
            let error = rounding * (largest + translation.abs());
            let exact = |value| Rounded { value, error: DVec3::ZERO };
            (corners.map(|v| matrix * v + translation), error, exact(origin), exact(direction))
        }
        Space::Object => {
            let inverse = matrix.inverse();
            let back = -(inverse * translation);
            let rounding = if is_identity { 0.0 } else { UNIT_ROUNDOFF };
            let origin = Rounded {
                value: inverse * origin + back,
                error: 5.0 * rounding * (inverse.abs() * origin.abs() + back.abs()),
            };
            let direction = Rounded {
                value: inverse * direction,
                error: 4.0 * rounding * (inverse.abs() * direction.abs()),
            };
            (corners, DVec3::ZERO, origin, direction)
        }
    };
    let difference = |a: DVec3, b: DVec3, error: DVec3| Rounded {
        value: a - b,
        error: error + UNIT_ROUNDOFF * (a - b).abs(),
    };
    let e1 = difference(corners[1], corners[0], 2.0 * corner_error);
    let e2 = difference(corners[2], corners[0], 2.0 * corner_error);
    let s = difference(origin.value, corners[0], origin.error + corner_error);

    let (det, det_error) = triple(e1, direction, e2);
    if det.abs() <= 2.0 * det_error {
        return None;
    }
    let share = |(product, error): (f64, f64)| {
        let value = product / det;
        let error =
            (error + value.abs() * (det_error + 3.0 * UNIT_ROUNDOFF * det.abs())) / (det.abs() - det_error);
        (value, error)
    };
    let (u, du) = share(triple(s, direction, e2));
    let (v, dv) = share(triple(direction, s, e1));
    let (t, dt) = share(triple(e2, s, e1));
    Some(Verdict { at: [t, u, v], error: [dt, du, dv] })
}
