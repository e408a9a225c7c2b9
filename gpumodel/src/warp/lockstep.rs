//! The lanes of a warp in lockstep: which of them take which step when.
//!
//! A warp executes one kind of step at a time, for all lanes whose turn it is; the others wait (Aila & Laine 2009). In one trip of the
//! loop body the kinds come in the order of [`Op::ALL`], so that a lane can, for instance, pop a node, fetch it and push its far
//! child in one trip, and a kind that no lane needs is skipped by the whole warp.

use tracer::{LoopStructure, Op, Step};

/// Kinds of one search step, in the order of the loop body.
const SEARCH: [Op; 5] = [Op::Pop, Op::Restart, Op::Up, Op::Node, Op::Push];

/// Lanes that are done wait in a queue of their own, after those of [`Op::ALL`].
const DONE: usize = Op::ALL.len();

/// Sees what a warp executes.
pub(crate) trait Body {
    /// A trip of a loop began, with this many lanes.
    fn trip(&mut self, lanes: u32);

    /// Lanes `lanes` took a step of kind `op` on `ids`, lane by lane.
    ///
    /// # Errors
    /// A sentence when an id is out of range.
    fn step(&mut self, op: Op, lanes: &[u8], ids: &[u32]) -> Result<(), String>;
}

/// Positions of a warp's lanes in their step lists.
pub(crate) struct Lockstep {
    next: [u32; 64],
    end: [u32; 64],
    /// Lanes by the kind of their next step.
    waiting: [u64; DONE + 1],
    lanes: [u8; 64],
    ids: [u32; 64],
}

impl Lockstep {
    pub(crate) fn new() -> Self {
        Self { next: [0; 64], end: [0; 64], waiting: [0; DONE + 1], lanes: [0; 64], ids: [0; 64] }
    }

    /// Runs the lanes whose steps lie in `ranges` of `steps`, as `(lane, start, end)`, to their ends.
    ///
    /// # Errors
    /// What `body` says, or that a step is of a kind that no loop here has.
    #[inline]
    pub(crate) fn run<B: Body>(
        &mut self,
        structure: LoopStructure,
        steps: &[Step],
        ranges: impl Iterator<Item = (usize, u32, u32)>,
        body: &mut B,
    ) -> Result<(), String> {
        self.waiting = [0; DONE + 1];
        for (lane, start, end) in ranges {
            self.next[lane] = start;
            self.end[lane] = end;
            self.enqueue(steps, lane);
        }
        loop {
            let searching = self.searching();
            let testing = self.waiting[Op::Primitive as usize];
            if searching | testing == 0 {
                break;
            }
            match structure {
                LoopStructure::WhileWhile => {
                    while self.search_trip(steps, body)? {}
                    while self.primitive_trip(steps, body)? {}
                }
                LoopStructure::SingleLoop => {
                    self.search_trip(steps, body)?;
                    while self.primitive_trip(steps, body)? {}
                }
                LoopStructure::IfIf => {
                    self.search_trip(steps, body)?;
                    self.primitive_trip(steps, body)?;
                }
            }
        }
        match [Op::Instance, Op::AnyHit].into_iter().find(|&op| self.waiting[op as usize] != 0) {
            Some(op) => Err(format!("it has steps of kind {op:?}, which no modelled shader takes")),
            None => Ok(()),
        }
    }

    fn searching(&self) -> u64 {
        SEARCH.iter().fold(0, |lanes, &op| lanes | self.waiting[op as usize])
    }

    /// One trip of the search loop; false if no lane needed it.
    #[inline(always)]
    fn search_trip<B: Body>(&mut self, steps: &[Step], body: &mut B) -> Result<bool, String> {
        let searching = self.searching();
        if searching == 0 {
            return Ok(false);
        }
        body.trip(searching.count_ones());
        for op in SEARCH {
            if self.waiting[op as usize] != 0 {
                self.step(op, steps, body)?;
            }
        }
        Ok(true)
    }

    /// One trip of the triangle loop; false if no lane needed it.
    #[inline(always)]
    fn primitive_trip<B: Body>(&mut self, steps: &[Step], body: &mut B) -> Result<bool, String> {
        let testing = self.waiting[Op::Primitive as usize];
        if testing == 0 {
            return Ok(false);
        }
        body.trip(testing.count_ones());
        self.step(Op::Primitive, steps, body)?;
        Ok(true)
    }

    #[inline(always)]
    fn step<B: Body>(&mut self, op: Op, steps: &[Step], body: &mut B) -> Result<(), String> {
        let mut lanes = std::mem::take(&mut self.waiting[op as usize]);
        let mut active = 0;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % 64;
            lanes &= lanes - 1;
            let at = self.next[lane];
            self.lanes[active % 64] = lane as u8;
            self.ids[active % 64] = steps[at as usize].id();
            active += 1;
            self.next[lane] = at + 1;
            self.enqueue(steps, lane);
        }
        body.step(op, &self.lanes[..active], &self.ids[..active])
    }

    #[inline(always)]
    fn enqueue(&mut self, steps: &[Step], lane: usize) {
        let next = self.next[lane];
        let queue = if next < self.end[lane] { steps[next as usize].op() as usize } else { DONE };
        self.waiting[queue] |= 1 << lane;
    }
}
