//! Axis-aligned boxes and the slab test of Williams et al. 2005.

use crate::ray::Ray;
use glam::Vec3;

/// An axis-aligned box; empty when any `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing and leaves every union unchanged.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box of three points.
    pub fn of_triangle(triangle: &scenes::Triangle) -> Self {
        let [a, b, c] = triangle.v;
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// The smallest box around both.
    #[inline(always)]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it contains nothing.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Edge lengths; negative where the box is empty.
    #[inline(always)]
    pub fn extent(self) -> Vec3 {
        self.max - self.min
    }

    /// Half the surface area, `dx dy + dy dz + dz dx`, in f64 so that extents up to `f32::MAX` do not overflow.
    /// 0 for an empty box.
    #[inline]
    pub fn half_area(self) -> f64 {
        let d = self.extent().as_dvec3();
        if d.min_element() < 0.0 { 0.0 } else { d.x * d.y + d.y * d.z + d.z * d.x }
    }
}

/// Half thickness of a plane, in half-ulps of the largest distance from the ray's origin to the scene's box.
const SLACK: f32 = 32.0 * f32::EPSILON / 2.0;

/// Largest half thickness, as a share of the extent of the middle one of the scene's triangles by extent.
const LARGEST_SLACK: f32 = 1.0 / 16.0;

/// How thick a ray has to take the planes of a tree, boxes and splits alike, to find what brute force finds.
///
/// The thickness bounds the rounding of a plane's distance (3 roundings, at most 1.5 ulp) and that of the hit point of a triangle
/// which is not seen edge on: the test of Moller & Trumbore accepts hits a few ulp outside the triangle, which a cell without
/// thickness would lose. The error follows the distance over which the ray is traced, so it is one figure per ray. Where
/// that distance is so large that the planes would grow as thick as triangles are wide (the origin, or one far triangle, 30,000
/// triangles away) it is capped: hits are uncertain by more there, and each ray would visit the whole tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSlack {
    scene: Aabb,
    /// Half thickness per distance.
    per_reach: f32,
    largest: f32,
}

impl PlaneSlack {
    /// The rule for a tree over triangles with these boxes.
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let scene = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        let mut extents: Vec<f32> = boxes.iter().map(|bounds| bounds.extent().max_element()).collect();
        let middle = extents.len() / 2;
        let largest = match extents.get(middle) {
            Some(_) => LARGEST_SLACK * *extents.select_nth_unstable_by(middle, f32::total_cmp).1,
            None => 0.0,
        };
        Self { scene, per_reach: SLACK, largest }
    }

    /// The same rule with `factor` times the thickness up to the same limit, for hits that are found with larger errors.
    pub(crate) fn thicker(self, factor: f32) -> Self {
        Self { per_reach: factor * self.per_reach, ..self }
    }

    /// The box around all triangles.
    pub fn scene(&self) -> &Aabb {
        &self.scene
    }

    /// The most that [`PlaneSlack::at`] gives, for whatever origin.
    pub fn largest(&self) -> f32 {
        self.largest
    }

    /// Half the thickness of every plane for a ray from `origin`.
    pub fn at(&self, origin: Vec3) -> f32 {
        let Aabb { min, max } = self.scene;
        let reach = (min - origin).abs().max((max - origin).abs()).max_element();
        (self.per_reach * reach).min(self.largest)
    }
}

/// A ray with what the slab test of Williams et al. 2005 needs once per ray.
///
/// Zero direction components become infinities of the same sign, as in IEEE division; the tests below are written for that. A NaN
/// (a plane exactly at the origin, direction parallel to it: `0 * inf`) constrains nothing, on either plane alike: every
/// comparison keeps the older bound when the new one is NaN.
///
/// Boxes are made thicker by their [`PlaneSlack`] at no cost: entries are measured from an origin moved forward, exits from one
/// moved back.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// Per axis, the origin for the nearer and for the farther plane.
    origins: [[f32; 2]; 3],
    /// Componentwise reciprocal of the direction.
    inverse: Vec3,
    /// Per axis, whether the reciprocal is negative, so that the upper plane is the nearer one.
    negative: [bool; 3],
}

/// The larger one; `current` when `candidate` is NaN.
#[inline(always)]
fn larger(candidate: f32, current: f32) -> f32 {
    if candidate > current { candidate } else { current }
}

impl SlabRay {
    /// Prepares a ray through a tree whose planes are as thick as `slack` says.
    #[inline]
    pub fn new(ray: &Ray, slack: &PlaneSlack) -> Self {
        let slack = slack.at(ray.origin);
        let inverse = ray.direction.recip();
        let negative = inverse.to_array().map(f32::is_sign_negative);
        let origins = std::array::from_fn(|axis| {
            let origin = ray.origin[axis];
            // At least one step, where the slack is lost in the rounding of a large coordinate.
            let low = (origin - slack).min(origin.next_down());
            let high = (origin + slack).max(origin.next_up());
            if negative[axis] { [low, high] } else { [high, low] }
        });
        Self { origins, inverse, negative }
    }

    /// Entry and exit distance of a box, clipped to `[t_min, t_max]`; the box is hit where entry <= exit.
    #[inline(always)]
    pub fn entry_exit(&self, bounds: &Aabb, t_min: f32, t_max: f32) -> (f32, f32) {
        let mut entry = t_min;
        let mut exit = t_max;
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let (near, far) = if self.negative[axis] { (high, low) } else { (low, high) };
            let [near_origin, far_origin] = self.origins[axis];
            entry = larger((near - near_origin) * self.inverse[axis], entry);
            exit = -larger(-((far - far_origin) * self.inverse[axis]), -exit);
        }
        (entry, exit)
    }

    /// [`SlabRay::entry_exit`] of `W` boxes at once: where each is entered, and in bit `i` whether box `i` is hit. `planes` holds the lower planes
    /// of all boxes in x, y and z, then the upper ones.
    #[inline(always)]
    pub(crate) fn entries<const W: usize>(
        &self,
        planes: &[[f32; W]; 6],
        t_min: f32,
        t_max: f32,
    ) -> ([f32; W], u32) {
        let (mut entries, mut exits) = ([t_min; W], [-t_max; W]);
        for axis in 0..3 {
            let (near, far) = if self.negative[axis] { (axis + 3, axis) } else { (axis, axis + 3) };
            let [near_origin, far_origin] = self.origins[axis];
            for lane in 0..W {
                entries[lane] =
                    larger((planes[near][lane] - near_origin) * self.inverse[axis], entries[lane]);
                exits[lane] = larger(-((planes[far][lane] - far_origin) * self.inverse[axis]), exits[lane]);
            }
        }
        let mut hits = 0;
        for lane in 0..W {
            hits |= u32::from(entries[lane] <= -exits[lane]) << lane;
        }
        (entries, hits)
    }

    /// [`SlabRay::entry_exit`] of two boxes at once: entry and exit of the left one, then of the right one, bit for bit as
    /// the single test gives them. `planes` holds per axis: left min, right min, left max, right max.
    ///
    /// Four lanes (left entry, right entry, left exit negated, right exit negated) go through the same three operations per
    /// axis, which compilers turn into vector instructions on any machine.
    #[inline(always)]
    pub(crate) fn entry_exit_pair(&self, planes: &[f32; 12], t_min: f32, t_max: f32) -> (f32, f32, f32, f32) {
        let mut lanes = [t_min, t_min, -t_max, -t_max];
        for axis in 0..3 {
            let near = 4 * axis + 2 * usize::from(self.negative[axis]);
            let far = 4 * axis + 2 * usize::from(!self.negative[axis]);
            let plane = [planes[near], planes[near + 1], planes[far], planes[far + 1]];
            let [near_origin, far_origin] = self.origins[axis];
            let origin = [near_origin, near_origin, far_origin, far_origin];
            let inverse = self.inverse[axis];
            let scale = [inverse, inverse, -inverse, -inverse];
            for lane in 0..4 {
                lanes[lane] = larger((plane[lane] - origin[lane]) * scale[lane], lanes[lane]);
            }
        }
        (lanes[0], -lanes[2], lanes[1], -lanes[3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_test_gives_the_bits_of_the_single_test() {
        let values = [0.0, -0.0, 1.0, -1.0, 0.3, 1e30, -1e-30, f32::INFINITY, f32::NAN];
        let mut state = 1_u32;
        let mut pick = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            values[(state >> 16) as usize % values.len()]
        };
        for _ in 0..100_000 {
            let mut point = || Vec3::new(pick(), pick(), pick());
            let (origin, direction) = (point(), point());
            let boxes = [Aabb { min: point(), max: point() }, Aabb { min: point(), max: point() }];
            let slab = SlabRay::new(&Ray::new(origin, direction), &PlaneSlack::new(&boxes));
            let mut planes = [0.0; 12];
            for axis in 0..3 {
                for (side, bounds) in boxes.iter().enumerate() {
                    planes[4 * axis + side] = bounds.min[axis];
                    planes[4 * axis + 2 + side] = bounds.max[axis];
                }
            }
            let pair = slab.entry_exit_pair(&planes, 0.0, 10.0);
            let (left, right) =
                (slab.entry_exit(&boxes[0], 0.0, 10.0), slab.entry_exit(&boxes[1], 0.0, 10.0));
            let bits = |x: f32| if x.is_nan() { 0 } else { x.to_bits() };
            let wide = std::array::from_fn(|plane| {
                boxes.map(|bounds| if plane < 3 { bounds.min[plane] } else { bounds.max[plane - 3] })
            });
            let (entries, hits) = slab.entries(&wide, 0.0, 10.0);
            assert_eq!(entries.map(bits), [left.0, right.0].map(bits));
            assert_eq!(hits, u32::from(left.0 <= left.1) | u32::from(right.0 <= right.1) << 1);
            assert_eq!(
                [pair.0, pair.1, pair.2, pair.3].map(bits),
                [left.0, left.1, right.0, right.1].map(bits)
            );
        }
    }

    #[test]
    fn a_ray_in_the_plane_of_a_face_hits_the_box_on_either_side_and_for_either_zero() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let slack = PlaneSlack::new(&[bounds]);
        for zero in [0.0, -0.0] {
            for x in [0.0, 1.0] {
                let ray = Ray::new(Vec3::new(x, 0.5, -1.0), Vec3::new(zero, zero, 1.0));
                let (near, far) = SlabRay::new(&ray, &slack).entry_exit(&bounds, 0.0, f32::INFINITY);
                assert!(near <= far, "x = {x}, direction {zero:?}");
            }
            let beside = Ray::new(Vec3::new(1.0 + 4.0 * SLACK, 0.5, -1.0), Vec3::new(zero, zero, 1.0));
            let (near, far) = SlabRay::new(&beside, &slack).entry_exit(&bounds, 0.0, f32::INFINITY);
            assert!(near > far);
        }
    }
}
