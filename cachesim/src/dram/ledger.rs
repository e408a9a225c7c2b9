//! The requests under way, and the finished ones until they are fetched.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Done;
use super::bank::Direction;

#[derive(Clone, Copy, Debug)]
struct Request {
    number: u64,
    arrival: u64,
    /// Last data so far.
    end: u64,
    tag: u32,
    /// Segments not yet served.
    left: u32,
    direction: Direction,
}

/// Requests by slot, and finished ones by time, then order of submission.
#[derive(Clone, Debug, Default)]
pub(super) struct Ledger {
    requests: Vec<Request>,
    free: Vec<u32>,
    finished: BinaryHeap<Reverse<(u64, u64, u32)>>,
    numbers: u64,
    /// By direction.
    pub(super) submitted: [u64; 2],
    pub(super) read_latency: u64,
}

impl Ledger {
    /// A slot for a request whose segments are counted by [`Self::add_segment`].
    pub(super) fn open(&mut self, arrival: u64, tag: u32, direction: Direction) -> u32 {
        let request = Request { number: self.numbers, arrival, end: 0, tag, left: 0, direction };
        self.numbers += 1;
        self.submitted[direction as usize] += 1;
        if let Some(slot) = self.free.pop() {
            self.requests[slot as usize] = request;
            return slot;
        }
        self.requests.push(request);
        (self.requests.len() - 1) as u32
    }

    pub(super) fn add_segment(&mut self, slot: u32) {
        self.requests[slot as usize].left += 1;
    }

    /// A segment's last data comes at `end`.
    pub(super) fn served(&mut self, slot: u32, end: u64) {
        let request = &mut self.requests[slot as usize];
        request.left -= 1;
        request.end = request.end.max(end);
        if request.left == 0 {
            if request.direction == Direction::Read {
                self.read_latency = self.read_latency.saturating_add(request.end - request.arrival);
            }
            self.finished.push(Reverse((request.end, request.number, request.tag)));
            self.free.push(slot);
        }
    }

    pub(super) fn next_at(&self) -> Option<u64> {
        self.finished.peek().map(|Reverse((at, ..))| *at)
    }

    /// Moves what has finished by `until` to `done`.
    pub(super) fn fetch(&mut self, until: u64, done: &mut Vec<Done>) {
        while let Some(&Reverse((at_ps, _, tag))) =
            self.finished.peek().filter(|Reverse((at, ..))| *at <= until)
        {
            self.finished.pop();
            done.push(Done { at_ps, tag });
        }
    }
}
