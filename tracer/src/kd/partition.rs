//! Division of a cell's event lists between its children, in order, so that nothing large is sorted twice (Wald & Havran
//! 2006, section 4.3).

use super::clip::clip;
use super::events::{Cell, Event, EventLists, Kind, push_events};
use super::sweep::{PlanarSide, Split};
use scenes::Triangle;

const LEFT: u8 = 1;
const RIGHT: u8 = 2;
const BOTH: u8 = LEFT | RIGHT;
/// Triangles whose events are made anew.
const NEITHER: u8 = 0;

/// Where perfect splits find a triangle of an event list.
pub(super) struct Geometry<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) ids: &'a [u32],
}

/// Scratch space for divisions: one byte for each triangle that the event lists can name.
pub(super) struct Partitioner {
    sides: Vec<u8>,
    straddlers: Vec<u32>,
    fresh: EventLists,
}

impl Partitioner {
    /// For lists that name triangles below `ids`.
    pub(super) fn new(ids: usize) -> Self {
        Self { sides: vec![NEITHER; ids], straddlers: Vec::new(), fresh: EventLists::default() }
    }

    /// Divides `lists`; what `left` and `right` held is replaced. With `geometry` the triangles that cross the plane are
    /// clipped to the children, else their boxes are cut at the plane.
    pub(super) fn divide(
        &mut self,
        lists: &EventLists,
        split: &Split,
        cell: &Cell,
        geometry: Option<&Geometry>,
        left: &mut EventLists,
        right: &mut EventLists,
    ) {
        let [left_only, right_only] = self.classify(&lists.axes[split.axis], split);
        match geometry {
            None => {
                let both = lists.count - left_only - right_only;
                left.count = left_only + both;
                right.count = right_only + both;
                for axis in 0..3 {
                    let (left, right) = (&mut left.axes[axis], &mut right.axes[axis]);
                    if axis == split.axis {
                        self.divide_across(&lists.axes[axis], split.position, left, right);
                    } else {
                        self.distribute(&lists.axes[axis], left, right);
                    }
                }
            }
            Some(geometry) => {
                for &id in &self.straddlers {
                    self.sides[id as usize] = NEITHER;
                }
                for axis in 0..3 {
                    self.distribute(&lists.axes[axis], &mut left.axes[axis], &mut right.axes[axis]);
                }
                let (left_cell, right_cell) = cell.split(split.axis, split.position);
                left.count = left_only + self.merge_clipped(&left_cell, geometry, left);
                right.count = right_only + self.merge_clipped(&right_cell, geometry, right);
            }
        }
    }

    /// Notes the side of each triangle and the list of those on both; returns how many are on one side only.
    fn classify(&mut self, events: &[Event], split: &Split) -> [u32; 2] {
        self.straddlers.clear();
        let (mut left_only, mut right_only) = (0, 0);
        for event in events {
            let position = event.position();
            let side = &mut self.sides[event.id() as usize];
            if event.is_start() {
                *side = if position >= split.position { RIGHT } else { BOTH };
                right_only += u32::from(*side == RIGHT);
            } else if event.is_end() {
                // The start came before, so the side is known to be BOTH or RIGHT.
                if position <= split.position {
                    *side = LEFT;
                    left_only += 1;
                } else if *side == BOTH {
                    self.straddlers.push(event.id());
                }
            } else {
                let is_left = position < split.position
                    || position == split.position && split.planar == PlanarSide::Left;
                *side = if is_left { LEFT } else { RIGHT };
                left_only += u32::from(is_left);
                right_only += u32::from(!is_left);
            }
        }
        [left_only, right_only]
    }

    /// Copies each event to the lists of its triangle's sides.
    fn distribute(&self, events: &[Event], left: &mut Vec<Event>, right: &mut Vec<Event>) {
        // Each event is written to both lists, and kept by moving the end of the list: no branch to mispredict.
        left.resize(events.len(), Event::default());
        right.resize(events.len(), Event::default());
        let (mut lefts, mut rights) = (0, 0);
        for &event in events {
            let side = self.sides[event.id() as usize];
            left[lefts] = event;
            right[rights] = event;
            lefts += usize::from(side & LEFT);
            rights += usize::from(side >> 1);
        }
        left.truncate(lefts);
        right.truncate(rights);
    }

    /// The same across the plane: a triangle on both sides now ends in the plane on the left and begins there on the right.
    fn divide_across(&self, events: &[Event], plane: f32, left: &mut Vec<Event>, right: &mut Vec<Event>) {
        left.clear();
        right.clear();
        let ends = self.straddlers.iter().map(|&id| Event::new(plane, Kind::End, id));
        let starts = self.straddlers.iter().map(|&id| Event::new(plane, Kind::Start, id));
        let first_planar = Event::new(plane, Kind::Planar, 0);
        let after_plane = events.partition_point(|event| event.position() <= plane);
        let from_planar = events[..after_plane].partition_point(|event| *event < first_planar);
        let (before, rest) = events.split_at(from_planar);
        let (at_plane, after) = rest.split_at(after_plane - from_planar);
        let is_left = |event: &&Event| self.sides[event.id() as usize] & LEFT != 0;
        let is_right = |event: &&Event| self.sides[event.id() as usize] & RIGHT != 0;

        left.extend_from_slice(before);
        left.extend(ends);
        left.extend(at_plane.iter().filter(is_left));
        right.extend(at_plane.iter().filter(is_right));
        right.extend(starts);
        right.extend_from_slice(after);
    }

    /// Adds the events of the straddlers, clipped to `cell`; returns how many reach into it.
    fn merge_clipped(&mut self, cell: &Cell, geometry: &Geometry, into: &mut EventLists) -> u32 {
        self.fresh.clear();
        for &id in &self.straddlers {
            let triangle = &geometry.triangles[geometry.ids[id as usize] as usize];
            if let Some(bounds) = clip(triangle, cell) {
                self.fresh.count += 1;
                for (axis, list) in self.fresh.axes.iter_mut().enumerate() {
                    push_events(list, bounds.min[axis], bounds.max[axis], id);
                }
            }
        }
        for (fresh, list) in self.fresh.axes.iter_mut().zip(&mut into.axes) {
            fresh.sort_unstable();
            merge(list, fresh);
        }
        self.fresh.count
    }
}

/// Merges sorted `fresh` into sorted `list`, from the back, in place.
fn merge(list: &mut Vec<Event>, fresh: &[Event]) {
    let (mut old, mut new) = (list.len(), fresh.len());
    list.resize(old + new, Event::default());
    while new > 0 {
        if old > 0 && list[old - 1] > fresh[new - 1] {
            list[old + new - 1] = list[old - 1];
            old -= 1;
        } else {
            list[old + new - 1] = fresh[new - 1];
            new -= 1;
        }
    }
}
