//! The transform of an instance: rays into the space of its mesh, boxes out of it, and what either loses to rounding.

use crate::aabb::Aabb;
use crate::ray::Ray;
use glam::{Affine3A, DMat3, DVec3, Vec3};

/// Half an ulp of 1: the largest relative error of one rounding to f32.
const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Largest condition number, above which a transformed ray is known to less than a sixteenth of its distance.
const MAX_CONDITION: f64 = (1 << 20) as f64;

/// A transform that can be inverted in f32.
#[derive(Clone, Debug)]
pub(super) struct Transform {
    /// Object to world, the exact values of the f32 transform.
    matrix: DMat3,
    translation: DVec3,
    /// World to object, before it is rounded.
    inverse_matrix: DMat3,
    inverse_translation: DVec3,
    is_identity: bool,
}

impl Transform {
    /// # Errors
    /// What is wrong with a transform that is not finite, or has no inverse that f32 can hold.
    pub(super) fn new(transform: &Affine3A) -> Result<Self, String> {
        if !transform.is_finite() {
            return Err("it has a number that is not finite; expected 12 finite numbers".to_owned());
        }
        let columns = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis];
        let [x, y, z] = columns.map(|column| Vec3::from(column).as_dvec3());
        let matrix = DMat3::from_cols(x, y, z);
        let translation = Vec3::from(transform.translation).as_dvec3();
        let inverse_matrix = matrix.try_inverse().ok_or_else(|| {
            "it has no inverse, as it flattens a direction to nothing; expected a scale other than 0: flatten the mesh itself"
                .to_owned()
        })?;
        let inverse_translation = -(inverse_matrix * translation);
        let is_identity = *transform == Affine3A::IDENTITY;
        let this = Self { matrix, translation, inverse_matrix, inverse_translation, is_identity };
        let condition = this.condition();
        if condition > MAX_CONDITION {
            return Err(format!(
                "its condition number is {condition:.1e}, expected at most {MAX_CONDITION:.1e}: it flattens a direction to almost \
                 nothing, so that f32 cannot hold its inverse; flatten the mesh itself"
            ));
        }
        let fits = |axis: usize| {
            let largest = inverse_matrix.row(axis).abs().max_element();
            largest >= f64::from(f32::MIN_POSITIVE)
                && largest.max(inverse_translation[axis].abs()) <= f64::from(f32::MAX)
        };
        if !(0..3).all(fits) {
            return Err("its inverse has numbers beyond those of f32; scale the mesh itself and bring the scale nearer to 1"
                .to_owned());
        }
        Ok(this)
    }

    /// By how much the way from the world into object space and back may amplify relative rounding errors: the largest row sum
    /// of `|M| |inverse of M|` (Skeel 1979). 1 for scaling, at most 3 for rotation.
    pub(super) fn condition(&self) -> f64 {
        let product = self.matrix.abs() * self.inverse_matrix.abs();
        (product * DVec3::ONE).max_element()
    }

    /// The world-to-object transform in f32; `None` for the identity, which leaves rays as they are.
    pub(super) fn to_object(&self) -> Option<WorldToObject> {
        let row = |axis: usize| {
            let row = self.inverse_matrix.row(axis);
            [row.x, row.y, row.z, self.inverse_translation[axis]].map(|value| value as f32)
        };
        (!self.is_identity).then(|| WorldToObject { rows: [row(0), row(1), row(2)] })
    }

    /// The world box of what lies in `bounds`: the box of the transformed box (Arvo 1990), rounded outwards, and wider by what a
    /// ray from within it loses when it is transformed. A ray from farther away loses more, in proportion to the distance.
    ///
    /// Transforming `p` by f32 rows rounds each row and does four products and sums: with `x` the largest coordinates of the
    /// box and `b` the inverse translation, that moves the ray by at most 5 roundings of `|inverse of M| x + |b|` in object space.
    pub(super) fn world_box(&self, bounds: &Aabb) -> Aabb {
        if self.is_identity || bounds.is_empty() {
            return *bounds;
        }
        let [low, high] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
        let mut min = self.translation;
        let mut max = self.translation;
        for axis in 0..3 {
            let (at_low, at_high) = (self.matrix.col(axis) * low[axis], self.matrix.col(axis) * high[axis]);
            min += at_low.min(at_high);
            max += at_low.max(at_high);
        }
        let largest = min.abs().max(max.abs());
        let in_object = self.inverse_matrix.abs() * largest + self.inverse_translation.abs();
        let lost = 5.0 * UNIT_ROUNDOFF * (self.matrix.abs() * in_object);
        let (min, max) = (min - lost, max + lost);
        Aabb {
            min: Vec3::new(round_down(min.x), round_down(min.y), round_down(min.z)),
            max: -Vec3::new(round_down(-max.x), round_down(-max.y), round_down(-max.z)),
        }
    }
}

/// The largest f32 that is at most `value`.
fn round_down(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) > value { nearest.next_down() } else { nearest }
}

/// A 3x4 world-to-object transform in f32, as the record of an instance holds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorldToObject {
    rows: [[f32; 4]; 3],
}

impl WorldToObject {
    /// The ray in object space. The direction keeps the length that it gets there, so that `t` is the same parameter in both
    /// spaces (Vulkan, "Ray Intersection Candidate Determination").
    ///
    /// Written out in scalar f32, so that the bits are the same on any machine.
    #[inline]
    pub(super) fn ray(&self, ray: &Ray) -> Ray {
        let Ray { origin: o, t_min, direction: d, t_max } = *ray;
        let origin = self.rows.map(|[x, y, z, w]| x * o.x + y * o.y + z * o.z + w);
        let direction = self.rows.map(|[x, y, z, _]| x * d.x + y * d.y + z * d.z);
        Ray { origin: Vec3::from(origin), t_min, direction: Vec3::from(direction), t_max }
    }
}
