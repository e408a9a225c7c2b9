//! What happens when.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cycles of the shader clock since the start of the frame: finite and not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct Time(pub(super) f64);

impl Eq for Time {}

#[expect(clippy::derive_ord_xor_partial_ord, reason = "times are finite, so both orders are one")]
impl Ord for Time {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Something that happens. A place is a slot of a core: `core * slots + slot`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Event {
    /// The warp at a place has what its next turn needs.
    Ready(u32),
    /// The warp at a place has computed what its turn computes on the ALU.
    Computed(u32),
    /// The ALU of a core takes another warp, before the one that it had has its results.
    Issued(u32),
    /// The warp at a place has what it needs of the elementary function unit.
    Functions(u32),
    /// The load/store unit of a core goes on.
    LoadStore(u32),
    /// A copy of a cache can wait for one more line: level and copy.
    Unblock(u32, u32),
    /// A request arrives at the memory controller.
    Memory(u32),
}

/// Events in order of time, those at the same time in the order in which they were announced.
#[derive(Debug, Default)]
pub(super) struct Events {
    queue: BinaryHeap<Reverse<(Time, u64, Event)>>,
    announced: u64,
}

impl Events {
    pub(super) fn push(&mut self, at: f64, event: Event) {
        self.queue.push(Reverse((Time(at), self.announced, event)));
        self.announced += 1;
    }

    pub(super) fn next_at(&self) -> Option<f64> {
        self.queue.peek().map(|Reverse((at, ..))| at.0)
    }

    pub(super) fn pop(&mut self) -> Option<(f64, Event)> {
        self.queue.pop().map(|Reverse((at, _, event))| (at.0, event))
    }
}

/// Times that have been promised, to be forgotten once they have passed.
#[derive(Debug, Default)]
pub(super) struct Promises<T: Ord> {
    queue: BinaryHeap<Reverse<(Time, T)>>,
}

impl<T: Ord + Copy> Promises<T> {
    pub(super) fn push(&mut self, at: f64, what: T) {
        self.queue.push(Reverse((Time(at), what)));
    }

    pub(super) fn next_at(&self) -> Option<f64> {
        self.queue.peek().map(|Reverse((at, _))| at.0)
    }

    /// The earliest, if it is due.
    pub(super) fn pop_due(&mut self, now: f64) -> Option<T> {
        if self.next_at()? > now {
            return None;
        }
        self.queue.pop().map(|Reverse((_, what))| what)
    }

    pub(super) fn len(&self) -> usize {
        self.queue.len()
    }
}
