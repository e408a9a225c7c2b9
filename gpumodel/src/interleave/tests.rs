use super::*;
use crate::mock::gpu;
use crate::warp::TileStream;
use cachesim::LineId;
use proptest::prelude::*;

proptest! {
    /// Why repeats of short runs need not be simulated.
    #[test]
    fn a_repeated_run_of_no_more_lines_than_ways_hits_and_leaves_an_lru_cache_as_it_was(
        runs in prop::collection::vec(prop::collection::btree_set(0_u64..6000, 1..=8), 1..400)
    ) {
        let machine = gpu(&[("value = 131072", "value = 8192")]);
        let fresh = || machine.hierarchy().unwrap();
        let ((mut once, paths), (mut twice, _)) = (fresh(), fresh());
        for run in runs {
            let lines: Vec<LineId> = run.into_iter().map(LineId::new).collect();
            let first = once.read(paths[0], 0, &lines);
            prop_assert_eq!(first, twice.read(paths[0], 0, &lines));
            let again = twice.read(paths[0], 0, &lines);
            prop_assert_eq!(again.levels[0].misses, 0);
            prop_assert_eq!(again.memory.reads, 0);
        }
    }
}

fn stream(warps: &[&[(BufferKind, u32)]]) -> TileStreams {
    let mut writer = crate::warp::StreamWriter::default();
    let mut ends = Vec::new();
    for warp in warps {
        for &(kind, line) in *warp {
            writer.lines()[0] = line;
            writer.push(Run::new(Pass::Primary, kind, false, 1, 1));
            writer.end_turn();
        }
        ends.push(writer.len());
    }
    TileStreams::joined(TileStream { words: writer.take(), warp_ends: ends, ..TileStream::default() })
}

fn interleaver(resident: u32) -> Interleaver {
    let machine = gpu(&[]);
    let (hierarchy, paths) = machine.hierarchy().unwrap();
    Interleaver::new(
        &machine,
        hierarchy,
        KindPaths::new(&paths, false),
        Places { stack_base_line: 1000, stack_stride_lines: 10, end: 0 },
        resident,
        Maps::Dropped,
    )
}

#[test]
fn a_warp_is_not_ready_before_its_data_and_its_core_lets_others_go_on() {
    let machine = gpu(&[]);
    let path = &machine.paths.ssbo;
    let [near, far] = [0, path.len()].map(|place| machine.latency_cycles(path, place));
    let mut interleaver = interleaver(2);
    // One warp on each core, and a second one on the first.
    let twice: &[(BufferKind, u32)] = &[(BufferKind::Node, 1), (BufferKind::Node, 1)];
    let others: &[(BufferKind, u32)] = &[(BufferKind::Node, 2)];
    interleaver.push(&stream(&[twice, others, others, others, twice]));
    interleaver.fill();
    let issue = |interleaver: &mut Interleaver| {
        interleaver.issue(0);
        interleaver.caches.flush_pending();
        interleaver.hold_up();
    };
    // The first warp's line comes from memory. The second one's is in the cache then.
    issue(&mut interleaver);
    issue(&mut interleaver);
    let (busy_until, shared_until) = (interleaver.busy_until[0], interleaver.shared_until[0]);
    let (late, soon) = (interleaver.ready.at(0), interleaver.ready.at(1));
    assert_eq!((soon, interleaver.next[0]), (shared_until + near, 1));
    assert!(shared_until > busy_until, "a line takes the cache's time, and none of the port's here");
    let Range { start, end } = interleaver.bank_delay;
    assert!(start < 0.0 && end > 0.0);
    assert!((far + start..shared_until + far + end).contains(&late), "{late}");
}

#[test]
fn the_core_whose_turn_starts_first_goes_first() {
    let mut writer = crate::warp::StreamWriter::default();
    let mut turn = |port_cycles: u32| {
        writer.lines()[0] = 1;
        let run = Run::new(Pass::Primary, BufferKind::Node, false, 1, 1);
        writer.push(run.with_port_cycles(port_cycles));
        writer.end_turn();
        writer.len()
    };
    // On one core a long turn and a short one, on another short ones.
    let (_, first) = (turn(500), turn(1));
    let second = (0..6).map(|_| turn(1)).last().unwrap();
    let stream = TileStream { words: writer.take(), warp_ends: vec![first, second], ..TileStream::default() };
    let mut interleaver = interleaver(1);
    interleaver.push(&TileStreams::joined(stream));
    interleaver.fill();
    for _ in 0..3 {
        interleaver.tick();
    }
    // Six turns: the long one, and five of the other core.
    let turns_left = [0, 1].map(|core| interleaver.resident[core].next.len() / 2);
    assert_eq!(turns_left, [1, 1]);
}

#[test]
fn cores_and_slots_take_turns_and_ticks_are_counted() {
    let mut interleaver = interleaver(2);
    let turns: &[(BufferKind, u32)] = &[(BufferKind::Node, 1), (BufferKind::Node, 2)];
    // Nine warps of two turns on four cores of two slots: eight are resident at once, the ninth follows the first.
    interleaver.push(&stream(&[turns; 9]));
    interleaver.drain(Pass::Primary);
    let Finished { schedule, phases, .. } = interleaver.finish();
    assert_eq!(schedule.warps, 9);
    // 18 turns, 16 of which have one of every core beside them, if no core is quicker than the others.
    assert_eq!(phases[0].windows.iter().map(|window| window.turns).sum::<u64>(), 18);
    assert!((5..=18).contains(&schedule.ticks) && (1..=4).contains(&schedule.full_ticks));
}

#[test]
fn time_begins_anew_with_each_phase() {
    let mut interleaver = interleaver(1);
    let turns: &[(BufferKind, u32)] = &[(BufferKind::Node, 1); 50];
    let ready = |interleaver: &mut Interleaver| {
        interleaver.push(&stream(&[turns; 4]));
        interleaver.fill();
        interleaver.issue(0);
        interleaver.ready.at(0)
    };
    let first = ready(&mut interleaver);
    interleaver.drain(Pass::Primary);
    let second = ready(&mut interleaver);
    assert!(second <= first, "{second} after {first}, though the line is in a cache by now");
}

#[test]
fn of_equal_times_the_first_is_taken() {
    assert_eq!(first_of(&[3.0, 1.0, f64::INFINITY, 1.0]), 1);
    assert_eq!(first_of(&[f64::INFINITY, 7.0]), 1);
}

#[test]
fn every_resident_warp_has_a_stack_of_its_own() {
    let mut interleaver = interleaver(2);
    let stack: &[(BufferKind, u32)] = &[(BufferKind::Stack, 0)];
    interleaver.push(&stream(&[stack; 8]));
    interleaver.drain(Pass::Primary);
    let passes = interleaver.finish().traffic;
    assert_eq!(passes[Pass::Primary as usize].stack.levels[1].misses, 8);
}

#[test]
fn the_next_warp_of_a_slot_inherits_its_stack() {
    let mut interleaver = interleaver(1);
    let stack: &[(BufferKind, u32)] = &[(BufferKind::Stack, 0)];
    interleaver.push(&stream(&[stack; 8]));
    interleaver.drain(Pass::Primary);
    let passes = interleaver.finish().traffic;
    assert_eq!(
        (
            passes[Pass::Primary as usize].stack.levels[1].accesses,
            passes[Pass::Primary as usize].stack.levels[1].misses
        ),
        (8, 4)
    );
}

#[test]
fn the_order_of_accesses_does_not_depend_on_how_many_tiles_are_known() {
    let turns: Vec<(BufferKind, u32)> = (0..40).map(|turn| (BufferKind::Node, turn * 37 % 5000)).collect();
    let tiles: Vec<_> = (1..12).map(|tile| stream(&vec![&turns[..tile * 3]; tile])).collect();
    let mut eager = interleaver(3);
    for tile in &tiles {
        eager.push(tile);
        eager.run_ahead();
    }
    let mut lazy = interleaver(3);
    tiles.iter().for_each(|tile| lazy.push(tile));
    eager.drain(Pass::Primary);
    lazy.drain(Pass::Primary);
    assert_eq!(eager.finish(), lazy.finish());
}

#[test]
fn turns_that_are_looked_at_tell_how_many_lines_they_have_on_their_way_and_how_unequally() {
    // By turn, new lines: 1, 2, 3; a turn without any has one that is there already.
    let turns = [[1, 1, 1], [2, 3, 2], [4, 5, 6], [1, 1, 1]];
    let mut writer = crate::warp::StreamWriter::default();
    for lines in turns {
        for line in lines {
            writer.lines()[0] = line;
            writer.push(Run::new(Pass::Primary, BufferKind::Image, false, 1, 1));
        }
        writer.end_turn();
    }
    let ends = vec![writer.len()];
    let stream = TileStream { words: writer.take(), warp_ends: ends, ..TileStream::default() };
    let mut interleaver = interleaver(1);
    interleaver.push(&TileStreams::joined(stream));
    interleaver.drain(Pass::Primary);
    let waits = interleaver.finish().phases[0].windows[0].waits;
    // The texture L1 belongs to a core, so what it has is not on its way.
    assert_eq!((waits.turns, waits.lines, waits.squares), (4, 1 + 2 + 3, 1 + 4 + 9));
}

proptest! {
    #[test]
    fn the_first_of_the_least_is_found(
        times in prop::collection::vec(prop_oneof![(0_u8..6).prop_map(f64::from), Just(f64::INFINITY)], 1..140),
    ) {
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        let expected = times.iter().position(|&time| time == least);
        prop_assert_eq!(Some(first_of(&times)), expected);
    }
}
