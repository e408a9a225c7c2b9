//! The lanes of a warp in lockstep: which of them take which step when.
//!
//! A warp executes one kind of step at a time, for all lanes whose turn it is; the others wait (Aila & Laine 2009). In one trip of the
//! loop body the kinds come in the order of [`Op::ALL`], so that a lane can, for instance, pop a node, fetch it and push its far
//! child in one trip, and a kind that no lane needs is skipped by the whole warp.

use super::prefixes::Prefixes;
use tracer::{LoopStructure, Op, Step};

/// Kinds of one search step, in the order of the loop body. To enter an instance is to go on searching, in another tree.
const SEARCH: [Op; 6] = [Op::Pop, Op::Restart, Op::Up, Op::Node, Op::Push, Op::Instance];

/// When lanes that found a hit which a shader decides about take that step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AnyHits {
    /// In the loop over triangles, right after the test.
    InLoop,
    /// When no lane of the warp can go on: a query returns to its shader for the whole warp.
    OnReturn,
}

/// Sees what a warp executes.
pub(crate) trait Body {
    /// A trip of a loop began, with this many lanes.
    fn trip(&mut self, lanes: u32);

    /// Groups of `lanes` took a step of kind `op`, each on its own of `ids`; groups come in the order of their lowest lanes.
    ///
    /// # Errors
    /// A sentence when an id is out of range.
    fn step(&mut self, op: Op, lanes: &[u64], ids: &[u32]) -> Result<(), String>;
}

/// The groups of a warp's lanes in their step lists.
pub(crate) struct Lockstep {
    groups: Prefixes,
    /// Leaders of groups by the kind of their next step.
    waiting: [u64; Op::ALL.len()],
    /// Lanes of those groups.
    waiting_lanes: [u64; Op::ALL.len()],
    lanes: [u64; 64],
    ids: [u32; 64],
}

impl Lockstep {
    pub(crate) fn new() -> Self {
        Self {
            groups: Prefixes::new(),
            waiting: [0; Op::ALL.len()],
            waiting_lanes: [0; Op::ALL.len()],
            lanes: [0; 64],
            ids: [0; 64],
        }
    }

    /// Runs the lanes whose steps lie in `ranges` of `steps`, as `(lane, start, end)` with rising lanes, to their ends.
    ///
    /// # Errors
    /// What `body` says, or that a step is of a kind that no loop here has.
    #[inline]
    pub(crate) fn run<B: Body>(
        &mut self,
        (structure, any_hits): (LoopStructure, AnyHits),
        steps: &[Step],
        ranges: impl Iterator<Item = (usize, u32, u32)>,
        body: &mut B,
    ) -> Result<(), String> {
        self.waiting = [0; Op::ALL.len()];
        self.waiting_lanes = [0; Op::ALL.len()];
        if let Some(leader) = self.groups.gather(steps, ranges) {
            self.arrive(steps, leader);
        }
        loop {
            let searching = self.searching();
            let testing = self.waiting[Op::Primitive as usize];
            if searching | testing == 0 {
                if self.waiting[Op::AnyHit as usize] == 0 {
                    return Ok(());
                }
                self.step(Op::AnyHit, steps, body)?;
                continue;
            }
            let any_hits = any_hits == AnyHits::InLoop;
            match structure {
                LoopStructure::WhileWhile => {
                    while self.search_trip(steps, body)? {}
                    while self.primitive_trip(any_hits, steps, body)? {}
                }
                LoopStructure::SingleLoop => {
                    self.search_trip(steps, body)?;
                    while self.primitive_trip(any_hits, steps, body)? {}
                }
                LoopStructure::IfIf => {
                    self.search_trip(steps, body)?;
                    self.primitive_trip(any_hits, steps, body)?;
                }
            }
        }
    }

    /// Lanes whose next step is one of the search.
    fn searching(&self) -> u64 {
        SEARCH.iter().fold(0, |lanes, &op| lanes | self.waiting_lanes[op as usize])
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

    /// One trip of the triangle loop, with the any-hit shaders of what it finds; false if no lane needed it.
    #[inline(always)]
    fn primitive_trip<B: Body>(
        &mut self,
        any_hits: bool,
        steps: &[Step],
        body: &mut B,
    ) -> Result<bool, String> {
        let testing = self.waiting_lanes[Op::Primitive as usize];
        if testing == 0 {
            return Ok(false);
        }
        body.trip(testing.count_ones());
        self.step(Op::Primitive, steps, body)?;
        if any_hits && self.waiting[Op::AnyHit as usize] != 0 {
            self.step(Op::AnyHit, steps, body)?;
        }
        Ok(true)
    }

    #[inline(always)]
    fn step<B: Body>(&mut self, op: Op, steps: &[Step], body: &mut B) -> Result<(), String> {
        let mut leaders = std::mem::take(&mut self.waiting[op as usize]);
        self.waiting_lanes[op as usize] = 0;
        let mut active = 0;
        while leaders != 0 {
            let leader = leaders.trailing_zeros() as usize % 64;
            leaders &= leaders - 1;
            self.lanes[active % 64] = self.groups.lanes(leader);
            self.ids[active % 64] = self.groups.advance(steps, leader).id();
            active += 1;
            self.arrive(steps, leader);
        }
        body.step(op, &self.lanes[..active], &self.ids[..active])
    }

    /// Parts the group where its lanes part, and queues what it has become.
    #[inline(always)]
    fn arrive(&mut self, steps: &[Step], leader: usize) {
        while let Some(branch) = self.groups.part(leader) {
            self.enqueue(steps, branch);
        }
        self.enqueue(steps, leader);
    }

    /// Queues a group by its next step; one at its end is done.
    #[inline(always)]
    fn enqueue(&mut self, steps: &[Step], leader: usize) {
        if let Some(step) = self.groups.peek(steps, leader) {
            let op = step.op() as usize;
            self.waiting[op] |= 1 << leader;
            self.waiting_lanes[op] |= self.groups.lanes(leader);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What a warp executed: trips and steps with their lanes.
    #[derive(Debug, Default, PartialEq)]
    struct Log(Vec<(Option<Op>, Vec<u8>, Vec<u32>)>);

    impl Body for Log {
        fn trip(&mut self, lanes: u32) {
            self.0.push((None, Vec::new(), vec![lanes]));
        }

        fn step(&mut self, op: Op, lanes: &[u64], ids: &[u32]) -> Result<(), String> {
            assert!(
                lanes.is_sorted_by_key(|lanes| lanes.trailing_zeros()),
                "groups in order of their lowest lanes"
            );
            let of_group = |(&lanes, &id): (&u64, &u32)| {
                (0..64_u8).filter(move |lane| lanes >> lane & 1 != 0).map(move |lane| (lane, id))
            };
            let mut by_lane: Vec<_> = lanes.iter().zip(ids).flat_map(of_group).collect();
            by_lane.sort_unstable();
            let (lanes, ids) = by_lane.into_iter().unzip();
            self.0.push((Some(op), lanes, ids));
            Ok(())
        }
    }

    /// The definition, lane by lane, without masks.
    fn naive((structure, any_hits): (LoopStructure, AnyHits), lanes: &[Vec<(Op, u32)>]) -> Log {
        let mut log = Log::default();
        let mut at = vec![0; lanes.len()];
        let next = |at: &[usize], lane: usize| lanes[lane].get(at[lane]).copied();
        let wants = |at: &[usize], search: bool| -> u32 {
            let is_wanted = |&lane: &usize| {
                next(at, lane).is_some_and(|(op, _)| op != Op::AnyHit && SEARCH.contains(&op) == search)
            };
            (0..lanes.len()).filter(is_wanted).count() as u32
        };
        let asks = |at: &[usize]| {
            (0..lanes.len()).any(|lane| next(at, lane).is_some_and(|(op, _)| op == Op::AnyHit))
        };
        let step = |at: &mut Vec<usize>, log: &mut Log, op: Op| {
            let (mut who, mut ids) = (Vec::new(), Vec::new());
            for lane in 0..lanes.len() {
                if let Some((_, id)) = next(at, lane).filter(|&(next_op, _)| next_op == op) {
                    at[lane] += 1;
                    who.push(lane as u8);
                    ids.push(id);
                }
            }
            if !who.is_empty() {
                log.0.push((Some(op), who, ids));
            }
        };
        let search = |at: &mut Vec<usize>, log: &mut Log| {
            let count = wants(at, true);
            if count > 0 {
                log.trip(count);
                SEARCH.into_iter().for_each(|op| step(at, log, op));
            }
            count > 0
        };
        let test = |at: &mut Vec<usize>, log: &mut Log| {
            let count = wants(at, false);
            if count > 0 {
                log.trip(count);
                step(at, log, Op::Primitive);
                if any_hits == AnyHits::InLoop {
                    step(at, log, Op::AnyHit);
                }
            }
            count > 0
        };
        while wants(&at, true) + wants(&at, false) > 0 || asks(&at) {
            if wants(&at, true) + wants(&at, false) == 0 {
                step(&mut at, &mut log, Op::AnyHit);
                continue;
            }
            match structure {
                LoopStructure::WhileWhile => {
                    while search(&mut at, &mut log) {}
                    while test(&mut at, &mut log) {}
                }
                LoopStructure::SingleLoop => {
                    search(&mut at, &mut log);
                    while test(&mut at, &mut log) {}
                }
                LoopStructure::IfIf => {
                    search(&mut at, &mut log);
                    test(&mut at, &mut log);
                }
            }
        }
        log
    }

    fn run(loops: (LoopStructure, AnyHits), lanes: &[Vec<(Op, u32)>]) -> Result<Log, String> {
        let mut steps = Vec::new();
        let ranges: Vec<_> = lanes
            .iter()
            .enumerate()
            .map(|(lane, of_lane)| {
                let start = steps.len() as u32;
                steps.extend(of_lane.iter().map(|&(op, id)| Step::new(op, id)));
                (lane, start, steps.len() as u32)
            })
            .collect();
        let mut log = Log::default();
        Lockstep::new().run(loops, &steps, ranges.into_iter(), &mut log)?;
        Ok(log)
    }

    fn any_list(longest: usize) -> impl Strategy<Value = Vec<(Op, u32)>> {
        let ops = [
            Op::Pop,
            Op::Restart,
            Op::Up,
            Op::Node,
            Op::Push,
            Op::Instance,
            Op::Primitive,
            Op::Node,
            Op::Primitive,
            Op::AnyHit,
        ];
        let step = (0..ops.len(), 0_u32..1000).prop_map(move |(op, id)| (ops[op], id));
        prop::collection::vec(step, 0..longest)
    }

    fn any_steps() -> impl Strategy<Value = Vec<Vec<(Op, u32)>>> {
        prop::collection::vec(any_list(24), 0..=64)
    }

    /// Each lane begins as an earlier one, as far as its own list is not longer, and goes on in its own way.
    fn like_steps() -> impl Strategy<Value = Vec<Vec<(Op, u32)>>> {
        let lane = (any_list(6), any::<prop::sample::Index>(), 0_usize..60);
        prop::collection::vec(lane, 1..=64).prop_map(|lanes| {
            let mut lists = vec![Vec::new()];
            for (own, like, shared) in lanes {
                let like: &Vec<_> = like.get(&lists);
                lists.push(like[..shared.min(like.len())].iter().copied().chain(own).collect());
            }
            lists.split_off(1)
        })
    }

    fn all_loops() -> impl Iterator<Item = (LoopStructure, AnyHits)> {
        [LoopStructure::WhileWhile, LoopStructure::SingleLoop, LoopStructure::IfIf]
            .into_iter()
            .flat_map(|structure| [AnyHits::InLoop, AnyHits::OnReturn].map(|any_hits| (structure, any_hits)))
    }

    proptest! {
        #[test]
        fn groups_do_what_the_definition_says(lanes in prop_oneof![any_steps(), like_steps()]) {
            for loops in all_loops() {
                prop_assert_eq!(run(loops, &lanes).unwrap(), naive(loops, &lanes));
            }
        }

        #[test]
        fn a_warp_takes_at_least_the_steps_of_its_longest_lane_and_at_most_those_of_all(lanes in any_steps()) {
            let longest = lanes.iter().map(Vec::len).max().unwrap_or(0);
            let all: usize = lanes.iter().map(Vec::len).sum();
            for loops in all_loops() {
                let log = run(loops, &lanes).unwrap();
                let steps = log.0.iter().filter(|(op, ..)| op.is_some()).count();
                prop_assert!(longest <= steps && steps <= all, "{longest} <= {steps} <= {all}");
            }
        }
    }

    #[test]
    fn a_lane_in_a_leaf_waits_for_the_searching_ones_only_in_while_while() {
        use Op::{Node, Primitive};
        let lanes = [vec![(Node, 0), (Primitive, 7)], vec![(Node, 0), (Node, 1), (Node, 3)]];
        let ops = |structure| -> Vec<Op> {
            run((structure, AnyHits::InLoop), &lanes)
                .unwrap()
                .0
                .into_iter()
                .filter_map(|(op, ..)| op)
                .collect()
        };
        assert_eq!(ops(LoopStructure::WhileWhile), [Node, Node, Node, Primitive]);
        assert_eq!(ops(LoopStructure::SingleLoop), [Node, Primitive, Node, Node]);
        assert_eq!(ops(LoopStructure::IfIf), [Node, Primitive, Node, Node]);
    }

    #[test]
    fn a_lane_pops_fetches_and_pushes_in_one_trip() {
        let lanes = [vec![(Op::Pop, 0), (Op::Node, 5), (Op::Push, 0)]];
        let log = run((LoopStructure::WhileWhile, AnyHits::InLoop), &lanes).unwrap();
        assert_eq!(log.0.iter().filter(|(op, ..)| op.is_none()).count(), 1);
    }

    #[test]
    fn a_lane_that_enters_an_instance_searches_on_while_others_wait_in_their_leaves() {
        use Op::{Instance, Node, Primitive};
        let lanes = [vec![(Node, 8), (Primitive, 7)], vec![(Node, 0), (Instance, 1), (Node, 4)]];
        let log = run((LoopStructure::WhileWhile, AnyHits::InLoop), &lanes).unwrap();
        let ops: Vec<Op> = log.0.into_iter().filter_map(|(op, ..)| op).collect();
        assert_eq!(ops, [Node, Instance, Node, Primitive]);
    }

    #[test]
    fn a_lane_with_a_hit_to_decide_about_waits_for_its_warp_only_where_queries_return() {
        use Op::{AnyHit, Node, Primitive};
        let lanes = [
            vec![(Primitive, 7), (AnyHit, 7), (Primitive, 8), (AnyHit, 8)],
            vec![(Primitive, 7), (Primitive, 8), (Primitive, 9), (Node, 1)],
        ];
        let ops = |any_hits| -> Vec<Op> {
            let log = run((LoopStructure::WhileWhile, any_hits), &lanes).unwrap();
            log.0.into_iter().filter_map(|(op, ..)| op).collect()
        };
        assert_eq!(ops(AnyHits::InLoop), [Primitive, AnyHit, Primitive, AnyHit, Primitive, Node]);
        assert_eq!(
            ops(AnyHits::OnReturn),
            [Primitive, Primitive, Primitive, Node, AnyHit, Primitive, AnyHit]
        );
    }
}
