//! Observation of a traversal: a generic parameter, silent by default, which can never change a hit.

use serde::{Deserialize, Serialize};

/// What one step of a traversal's loop body did. The counting rules of the whole project:
///
/// * A **node fetch** is a read of a node record from its buffer ("a node is traversed when it is fetched", Sousa et al.
///   2019, section 4.1). [`Op::Node`] and [`Op::Up`] fetch; no other step does.
/// * [`Op::Node`] fetches one record, or, where the traversal's [`NodeFetch`](crate::NodeFetch) is `Pair` and the id is odd,
///   the two sibling records `id` and `id + 1`: roots have even ids.
/// * [`Op::Up`] fetches an ancestor's record once more, for its links. No box is tested against it.
/// * [`Op::Restart`], [`Op::Push`] and [`Op::Pop`] fetch no node. Push and Pop move one stack entry, at depth `id`.
/// * [`Op::Primitive`] tests one triangle; `id` is the position in the structure's reference list, not the triangle's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Op {
    /// A stack entry was taken; id: depth of the entry, from 0.
    Pop = 0,
    /// The traversal began again from node `id` without fetching it yet.
    Restart = 1,
    /// The record of ancestor `id` was fetched again.
    Up = 2,
    /// Node `id` was fetched (with its sibling `id + 1` where nodes are fetched in pairs) and tested.
    Node = 3,
    /// A stack entry was written; id: depth of the entry, from 0.
    Push = 4,
    /// The record of instance `id` was read, and unless its mask hides it, the ray went into the instance's space.
    Instance = 5,
    /// The primitive at position `id` of the reference list was tested.
    Primitive = 6,
    /// An any-hit shader ran for the primitive at position `id`, or an opacity micromap spared it: then [`DECIDED_BY_MICROMAP`] is set in the id.
    AnyHit = 7,
}

/// In the id of [`Op::AnyHit`], beside the position: an opacity micromap decided and no shader ran.
pub const DECIDED_BY_MICROMAP: u32 = 1 << 28;

impl Op {
    /// All steps, in the order in which one trip of a loop body can contain them.
    pub const ALL: [Op; 8] =
        [Op::Pop, Op::Restart, Op::Up, Op::Node, Op::Push, Op::Instance, Op::Primitive, Op::AnyHit];
}

/// Sees what a traversal does. Every method is empty by default; [`Silent`] leaves them so and costs nothing.
///
/// Observers get values only: no method returns anything, so an observer cannot change a hit.
pub trait Observer {
    /// One step of the loop body.
    #[inline(always)]
    fn step(&mut self, _op: Op, _id: u32) {}
    /// `n` ray-box tests were computed.
    #[inline(always)]
    fn box_tests(&mut self, _n: u32) {}
    /// One ray-plane test of a kd inner node was computed.
    #[inline(always)]
    fn plane_test(&mut self) {}
    /// The traversal entered a leaf, empty or not.
    #[inline(always)]
    fn leaf_visit(&mut self) {}
    /// The loop bound ended the traversal before it was finished: the hit may be wrong.
    #[inline(always)]
    fn stall(&mut self) {}
}

/// Observes nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// Exact counts of the work of a traversal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Node records read: [`Op::Node`] (twice for a pair) and [`Op::Up`].
    pub node_fetches: u64,
    /// Steps of kind [`Op::Node`].
    pub node_steps: u64,
    /// Ray-box tests.
    pub box_tests: u64,
    /// Ray-plane tests.
    pub plane_tests: u64,
    /// Steps of kind [`Op::Up`].
    pub up_steps: u64,
    /// Steps of kind [`Op::Restart`].
    pub restarts: u64,
    /// Steps of kind [`Op::Push`].
    pub pushes: u64,
    /// Steps of kind [`Op::Pop`].
    pub pops: u64,
    /// Leaves entered.
    pub leaf_visits: u64,
    /// Ray-triangle tests.
    pub primitive_tests: u64,
    /// Any-hit shaders run.
    pub any_hits: u64,
    /// Traversals ended by their loop bound.
    pub stalls: u64,
}

/// Counts [`Work`] for a traversal that fetches nodes as `fetch` says.
#[derive(Clone, Copy, Debug)]
pub struct WorkCounter {
    pair: bool,
    work: Work,
}

impl WorkCounter {
    /// A counter at zero.
    pub fn new(fetch: NodeFetch) -> Self {
        Self { pair: fetch == NodeFetch::Pair, work: Work::default() }
    }

    /// The counts so far.
    pub fn work(&self) -> Work {
        self.work
    }
}

impl Observer for WorkCounter {
    #[inline(always)]
    fn step(&mut self, op: Op, id: u32) {
        let work = &mut self.work;
        match op {
            Op::Node => {
                work.node_steps += 1;
                work.node_fetches += 1 + u64::from(self.pair && id % 2 == 1);
            }
            Op::Up => {
                work.up_steps += 1;
                work.node_fetches += 1;
            }
            Op::Restart => work.restarts += 1,
            Op::Push => work.pushes += 1,
            Op::Pop => work.pops += 1,
            Op::Primitive => work.primitive_tests += 1,
            Op::AnyHit => work.any_hits += u64::from(id & DECIDED_BY_MICROMAP == 0),
            Op::Instance => {}
        }
    }

    #[inline(always)]
    fn box_tests(&mut self, n: u32) {
        self.work.box_tests += u64::from(n);
    }

    #[inline(always)]
    fn plane_test(&mut self) {
        self.work.plane_tests += 1;
    }

    #[inline(always)]
    fn leaf_visit(&mut self) {
        self.work.leaf_visits += 1;
    }

    #[inline(always)]
    fn stall(&mut self) {
        self.work.stalls += 1;
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        let Work {
            node_fetches,
            node_steps,
            box_tests,
            plane_tests,
            up_steps,
            restarts,
            pushes,
            pops,
            leaf_visits,
            primitive_tests,
            any_hits,
            stalls,
        } = other;
        self.node_fetches += node_fetches;
        self.node_steps += node_steps;
        self.box_tests += box_tests;
        self.plane_tests += plane_tests;
        self.up_steps += up_steps;
        self.restarts += restarts;
        self.pushes += pushes;
        self.pops += pops;
        self.leaf_visits += leaf_visits;
        self.primitive_tests += primitive_tests;
        self.any_hits += any_hits;
        self.stalls += stalls;
    }
}

/// How many node records one [`Op::Node`] step reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NodeFetch {
    /// The record `id`.
    Single,
    /// The sibling records `id` and `id + 1`; a root, which has an even id, alone.
    Pair,
}

/// How a traversal's shader loops, which decides which lanes of a warp wait for which (Aila & Laine 2009).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopStructure {
    /// Search steps until every lane has a leaf or is done, then primitives until every lane is done with its leaf.
    WhileWhile,
    /// One search step, then at most one primitive, per trip.
    IfIf,
    /// One search step per trip; a lane that reached a leaf finishes its primitives while the others wait.
    SingleLoop,
}
