//! Events: where triangles begin and end along an axis.

use crate::aabb::Aabb;
use glam::Vec3;
use std::ops::Range;

/// What happens at an event. The order is that of Wald & Havran 2006 among events at one position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub(super) enum Kind {
    /// A triangle ends.
    End = 0,
    /// A triangle lies in the plane.
    Planar = 1,
    /// A triangle begins.
    Start = 2,
}

/// One event in 8 bytes: position in the upper word, in a form that orders as integers do; kind in the next two bits;
/// triangle in the rest. The integer order is (position, kind, triangle).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event(u64);

impl Event {
    const ID_BITS: u32 = 30;
    const ID_MASK: u64 = (1 << Self::ID_BITS) - 1;

    /// `-0.0` counts as `0.0`.
    #[inline(always)]
    pub(super) fn new(position: f32, kind: Kind, id: u32) -> Self {
        let bits = (position + 0.0).to_bits();
        let ordered = bits ^ (((bits as i32) >> 31) as u32 | 0x8000_0000);
        Self(u64::from(ordered) << 32 | u64::from(kind as u32) << Self::ID_BITS | u64::from(id))
    }

    #[inline(always)]
    pub(super) fn position(self) -> f32 {
        let ordered = (self.0 >> 32) as u32;
        f32::from_bits(ordered ^ (((!ordered as i32) >> 31) as u32 | 0x8000_0000))
    }

    #[inline(always)]
    pub(super) fn is_end(self) -> bool {
        self.0 & (3 << Self::ID_BITS) == 0
    }

    #[inline(always)]
    pub(super) fn is_planar(self) -> bool {
        self.0 & (1 << Self::ID_BITS) != 0
    }

    #[inline(always)]
    pub(super) fn is_start(self) -> bool {
        self.0 & (2 << Self::ID_BITS) != 0
    }

    #[inline(always)]
    pub(super) fn id(self) -> u32 {
        (self.0 & Self::ID_MASK) as u32
    }

    #[inline(always)]
    pub(super) fn with_id(self, id: u32) -> Self {
        Self(self.0 & !Self::ID_MASK | u64::from(id))
    }

    /// Whether both are the same kind of event at the same position.
    #[inline(always)]
    pub(super) fn same_place(self, other: Self) -> bool {
        (self.0 ^ other.0) >> Self::ID_BITS == 0
    }
}

/// Appends the one or two events of triangle `id` between `low` and `high`.
pub(super) fn push_events(list: &mut Vec<Event>, low: f32, high: f32, id: u32) {
    if low == high {
        list.push(Event::new(low, Kind::Planar, id));
    } else {
        list.push(Event::new(low, Kind::Start, id));
        list.push(Event::new(high, Kind::End, id));
    }
}

/// The triangles of a cell as three sorted event lists, one for each axis; each triangle has events in all three.
#[derive(Debug, Default)]
pub(super) struct EventLists {
    pub(super) axes: [Vec<Event>; 3],
    /// Number of triangles.
    pub(super) count: u32,
}

impl EventLists {
    /// Sorts the events of all boxes.
    pub(super) fn sorted(boxes: &[Aabb]) -> Self {
        use rayon::prelude::*;
        let mut lists = Self { count: boxes.len() as u32, ..Self::default() };
        lists.axes.par_iter_mut().enumerate().for_each(|(axis, list)| {
            list.reserve_exact(2 * boxes.len());
            for (id, bounds) in (0..).zip(boxes) {
                push_events(list, bounds.min[axis], bounds.max[axis], id);
            }
            list.par_sort_unstable();
        });
        lists
    }

    pub(super) fn clear(&mut self) {
        self.axes.iter_mut().for_each(Vec::clear);
        self.count = 0;
    }

    /// The triangles, in no particular order.
    pub(super) fn ids(&self) -> impl Iterator<Item = u32> {
        self.axes[0].iter().filter(|event| !event.is_end()).map(|event| event.id())
    }
}

/// A box of space; unlike [`Aabb`] never empty, and without negative zeros.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

impl Cell {
    pub(super) fn range(&self, axis: usize) -> Range<f32> {
        self.min[axis]..self.max[axis]
    }

    pub(super) fn extent(&self, axis: usize) -> f64 {
        f64::from(self.max[axis]) - f64::from(self.min[axis])
    }

    pub(super) fn split(&self, axis: usize, position: f32) -> (Self, Self) {
        let (mut left, mut right) = (*self, *self);
        left.max[axis] = position;
        right.min[axis] = position;
        (left, right)
    }
}
