//! A ray as axis-aligned planes cut it: what the traversals of kd-trees and grids share.
//!
//! Distances are a pure function of plane and ray, and rise with the plane in the direction of the ray, so intervals that are
//! computed again (from a cell's box, or on a new descent) are equal bit by bit.

use crate::aabb::{Aabb, PlaneSlack};
use crate::observe::Observer;
use crate::ray::{Hit, Ray};

/// Direction components below this share of the largest one are replaced by it, so that reciprocals stay finite.
/// Over the length of a scene that moves the ray by at most a 500th of the slack.
const SMALLEST_COMPONENT: f32 = 1.0 / (1 << 30) as f32;

/// A ray along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayAxis {
    origin: f32,
    inverse: f32,
    /// The slack as a distance along the ray.
    slack: f32,
    /// 1 where the ray goes down, so that the upper side of a plane is the nearer one; else 0.
    pub(crate) near: u32,
}

impl RayAxis {
    /// Where the ray meets a plane without thickness.
    #[inline(always)]
    pub(crate) fn distance(&self, plane: f32) -> f32 {
        (plane - self.origin) * self.inverse
    }

    /// Where a plane begins and where it ends, its thickness included.
    #[inline(always)]
    pub(crate) fn distances(&self, plane: f32) -> (f32, f32) {
        let distance = self.distance(plane);
        (distance - self.slack, distance + self.slack)
    }
}

/// A ray with what the plane test needs once per ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneRay {
    pub(crate) axes: [RayAxis; 3],
}

/// The part of a ray in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Interval {
    /// Where the cell may begin.
    pub(crate) entry: f32,
    /// Where the cell may end.
    pub(crate) exit: f32,
    /// No later cell begins before this.
    pub(crate) rest: f32,
}

impl PlaneRay {
    /// Prepares a ray and finds its part in the scene's box: `None` where it misses the box or can hit nothing (a scene without
    /// triangles, a component of origin or direction that is not finite, a direction of zero, `t_min > t_max`, NaN).
    pub(crate) fn new<O: Observer>(
        slack: &PlaneSlack,
        ray: &Ray,
        observer: &mut O,
    ) -> Option<(Self, Interval)> {
        observer.box_tests(1);
        let largest = ray.direction.abs().max_element();
        let can_hit =
            ray.origin.is_finite() & ray.direction.is_finite() & (largest > 0.0) & (ray.t_min <= ray.t_max);
        let scene = slack.scene();
        if !can_hit || scene.is_empty() {
            return None;
        }
        let slack = slack.at(ray.origin);
        let smallest = largest * SMALLEST_COMPONENT;
        let axes = [0, 1, 2].map(|axis| {
            let direction = ray.direction[axis];
            let inverse = direction.abs().max(smallest).copysign(direction).recip();
            RayAxis {
                origin: ray.origin[axis],
                inverse,
                slack: slack * inverse.abs(),
                near: u32::from(direction.is_sign_negative()),
            }
        });
        let plane_ray = Self { axes };
        let interval = plane_ray.interval(ray, scene);
        (interval.entry <= interval.exit).then_some((plane_ray, interval))
    }

    /// The ray's part in a cell, from the cell's box.
    ///
    /// A bound that overflow has made NaN constrains nothing.
    #[inline(always)]
    pub(crate) fn interval(&self, ray: &Ray, bounds: &Aabb) -> Interval {
        let mut interval = Interval { entry: ray.t_min, exit: ray.t_max, rest: f32::INFINITY };
        for (axis, (low, high)) in
            self.axes.iter().zip(bounds.min.to_array().into_iter().zip(bounds.max.to_array()))
        {
            let (first, last) = if axis.near == 0 { (low, high) } else { (high, low) };
            interval = interval.from(axis.distances(first).0).until(axis.distances(last));
        }
        interval
    }
}

impl Interval {
    /// The part beyond a plane that begins at `low`.
    #[inline(always)]
    pub(crate) fn from(self, low: f32) -> Self {
        Self { entry: if low > self.entry { low } else { self.entry }, ..self }
    }

    /// The part before a plane that begins at `low` and ends at `high`.
    #[inline(always)]
    pub(crate) fn until(self, (low, high): (f32, f32)) -> Self {
        Self {
            exit: if high < self.exit { high } else { self.exit },
            rest: if low < self.rest { low } else { self.rest },
            ..self
        }
    }

    /// Whether the search can end with this hit after the cell: no later cell can hold a nearer one.
    #[inline(always)]
    pub(crate) fn settles(&self, best: &Hit) -> bool {
        best.t < self.rest
    }
}
