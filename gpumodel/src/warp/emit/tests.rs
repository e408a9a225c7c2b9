use super::super::steps::{Stepper, Walk};
use super::*;
use crate::layout::{Buffers, NodeRecords, PrimitiveOrder};
use crate::mock::{Recorded, config, gpu};
use crate::replay::ReplayConfig;
use crate::schedule::LaneMap;
use cachesim::LineSize;
use proptest::prelude::*;
use tracer::{Accel, NodeFetch};

const LEAVES: u32 = 64;
const MARKS: u32 = Run::CROSSES | Run::BEGINS;

fn program(source: &Recorded, records: NodeRecords, order: PrimitiveOrder) -> Program {
    let config = ReplayConfig { node_records: records, primitive_order: Some(order), ..config(gpu(&[])) };
    let line = LineSize::new(64).expect("a power of two");
    let buffers = Buffers::new(source, &config, 1, line, line).expect("the mock is valid");
    Program::new(&source.header, &source.topology, buffers, &config).expect("the mock is valid")
}

fn emitted(source: &Recorded, program: &Program, tree_turns: TreeTurns) -> TileStreams {
    let lane_map = LaneMap::new(&gpu(&[]), source.header.frame, crate::config::Stage::Fragment);
    let rect = source.header.frame.tile(0);
    let walk = Walk::new(&source.header, &source.topology, &config(gpu(&[])));
    let mut emitter = Emitter::new(tree_turns);
    let tile = (&source.tiles[0], rect);
    let tally = Stepper::new()
        .run(&source.header, (&walk, &program.wanted()), &lane_map, tile, |warp| {
            emitter.trace(program, warp, 0, rect)
        })
        .expect("the mock is valid");
    emitter.take(program, &tally, None)
}

/// The words of a warp in the order of its turns, without the marks of where it goes over.
fn in_order(streams: &TileStreams, warp: usize) -> Vec<u32> {
    let (tree, own) = (&streams.tree, &streams.own);
    let (mut next, mut other) = ((tree, tree.warp(warp)), (own, own.warp(warp)));
    if next.1.is_empty() || (!other.1.is_empty() && Run::from_word(own.words[other.1.start]).begins()) {
        std::mem::swap(&mut next, &mut other);
    }
    let mut words = Vec::new();
    while !next.1.is_empty() {
        let (stream, range) = &mut next;
        let header = stream.words[range.start];
        let run = Run::from_word(header);
        words.push(header & !MARKS);
        words.extend_from_slice(&stream.words[range.start + 1..][..run.lines()]);
        range.start += 1 + run.lines();
        if run.crosses() || range.start >= range.end {
            std::mem::swap(&mut next, &mut other);
        }
    }
    assert!(other.1.is_empty(), "a stream that nobody reads to its end");
    words
}

proptest! {
    #[test]
    fn two_streams_hold_the_turns_of_one_in_the_same_order(
        rays in prop::collection::vec(
            (prop::collection::vec((0..5_usize, 0..LEAVES), 0..30), prop::option::of(0..LEAVES)), 1..100
        ),
        records in prop::sample::select(vec![NodeRecords::Packed, NodeRecords::ChildBoxes]),
        order in prop::sample::select(vec![PrimitiveOrder::Leaf, PrimitiveOrder::Indexed]),
    ) {
        let step = |&(op, id): &(usize, u32)| match op {
            // Left children, and often the root.
            0 | 1 => (Op::Node, if id % 3 == 0 { 0 } else { 2 * id - 1 }),
            2 => (Op::Primitive, id),
            3 => (Op::Push, id % 4),
            _ => (Op::Pop, id % 4),
        };
        let rays: Vec<_> = rays
            .iter()
            .map(|(steps, hit)| (steps.iter().map(step).collect(), hit.unwrap_or(tracer::NO_HIT)))
            .collect();
        let mut source = Recorded::list(Accel::Bvh, "stack", LEAVES, &rays);
        source.header.node_fetch = NodeFetch::Pair;
        source.header.stack_entries = 4;
        let program = program(&source, records, order);
        let [joined, apart, elsewhere] = [TreeTurns::Joined, TreeTurns::Apart, TreeTurns::Elsewhere]
            .map(|tree_turns| emitted(&source, &program, tree_turns));
        for warp in 0..joined.warps() {
            prop_assert_eq!(in_order(&apart, warp), in_order(&joined, warp));
        }
        prop_assert_eq!(&elsewhere.own.words, &apart.own.words);
        prop_assert!(elsewhere.tree.warp(0).is_empty());
    }
}
