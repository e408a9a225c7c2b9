//! Which children of a kd node a ray meets: the one set of rules that all kd traversals share.
//!
//! In exact arithmetic the cells that a ray meets follow each other with intervals that touch. In f32 that is not enough: a
//! ray through a corner or along a plane meets cells of no length, a plane in a face makes a cell of no thickness, and the
//! triangle test of Moller & Trumbore itself accepts hits a few ulp outside the triangle. A traversal that steps over such a
//! cell loses what only that cell refers to. So every plane is taken to be a slab, whose half thickness
//! [`PlaneSlack`](crate::PlaneSlack) gives. A plane then gives an interval `[low, high]` of the ray parameter: the near child
//! ends at `high`, the far one begins at `low`, and a cell belongs to the ray when its interval is not empty. Cells are visited
//! depth first, near child first. Every traversal visits just these, in that order.
//!
//! A hit ends the search only before the slab in which the next cell begins: beyond it a triangle may be nearer by rounding, or
//! as near with a lower index. A ray that hits a wall lying in a split plane therefore looks into one more cell than it needs.
//! On the two Sponzas that is 0.5 % and 1.4 % of the node fetches of primary rays; the thickness itself adds less than 0.1 %.

use crate::plane_ray::{Interval, PlaneRay};

/// A cell to be visited.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Visit {
    pub(super) node: u32,
    pub(super) interval: Interval,
}

/// What to do at an inner node.
#[derive(Clone, Copy, Debug)]
pub(super) enum Descent {
    /// The ray meets one child only.
    One(Visit),
    /// It meets both, in this order.
    Both(Visit, Visit),
}

impl PlaneRay {
    /// Chooses the children of an inner node that the ray meets. A distance that overflow has made NaN excludes none.
    #[inline(always)]
    pub(super) fn descend(&self, axis: usize, split: f32, left: u32, interval: Interval) -> Descent {
        let axis = &self.axes[axis];
        let (low, high) = axis.distances(split);
        let (near, far) = (left + axis.near, left + (axis.near ^ 1));
        if low > interval.exit {
            Descent::One(Visit { node: near, interval })
        } else if high < interval.entry {
            Descent::One(Visit { node: far, interval })
        } else {
            Descent::Both(
                Visit { node: near, interval: interval.until((low, high)) },
                Visit { node: far, interval: interval.from(low) },
            )
        }
    }

    /// Whether `child`, the left or the right one, is the nearer child of a node that splits `axis`.
    #[inline(always)]
    pub(super) fn is_near(&self, axis: usize, left: u32, child: u32) -> bool {
        left + self.axes[axis].near == child
    }
}
