//! Do caches do what one says of caches? Limits are tested on both sides.

use cachesim::{
    Access, Bytes, Hierarchy, LevelConfig, Levels, LineId, LineSize, MissClasses, PathId, Policy, Ways,
    WriteMiss, WritePolicy,
};

fn line_size(bytes: u64) -> LineSize {
    LineSize::new(bytes).expect("a power of two")
}

fn level(name: &str, lines: u64, ways: Ways) -> LevelConfig {
    LevelConfig::new(name, Bytes(64 * lines), line_size(64), ways, Policy::Lru)
}

fn chain(levels: Vec<LevelConfig>) -> (Hierarchy, PathId) {
    Hierarchy::chain(&Levels::new(levels).expect("valid")).expect("valid")
}

fn ids(lines: impl IntoIterator<Item = u64>) -> Vec<LineId> {
    lines.into_iter().map(LineId::new).collect()
}

#[test]
fn a_loop_over_as_many_lines_as_fit_misses_once_per_line_and_one_more_line_misses_always() {
    for ways in [Ways::Count(1), Ways::Count(4), Ways::Count(16), Ways::Full] {
        let (mut cache, path) = chain(vec![level("L", 256, ways)]);
        for _ in 0..10 {
            cache.read(path, 0, &ids(0..256));
        }
        assert_eq!(cache.counts(0).misses, 256, "{ways:?}: all fit");
    }
    for (ways, expected) in [(Ways::Count(1), 255 + 2 * 10), (Ways::Full, 257 * 10)] {
        let (mut cache, path) = chain(vec![level("L", 256, ways)]);
        for _ in 0..10 {
            cache.read(path, 0, &ids(0..257));
        }
        assert_eq!(cache.counts(0).misses, expected, "{ways:?}: one line too many");
    }
}

#[test]
fn fifo_forgets_a_line_in_use_that_lru_keeps() {
    for (policy, misses) in [(Policy::Lru, 4), (Policy::Fifo, 5)] {
        let (mut cache, path) = chain(vec![LevelConfig { policy, ..level("L", 3, Ways::Full) }]);
        cache.read(path, 0, &ids([0, 1, 2, 0, 3, 0]));
        assert_eq!(cache.counts(0).misses, misses, "{policy:?}");
    }
}

#[test]
fn private_copies_do_not_see_each_other_and_a_shared_level_sees_all() {
    let private = LevelConfig { count: 4, ..level("L1", 16, Ways::Count(4)) };
    let (mut cache, path) = chain(vec![private, level("L2", 64, Ways::Count(4))]);
    for unit in 0..4 {
        let served = cache.read(path, unit, &ids(0..8));
        assert_eq!(served.levels[0].misses, 8, "unit {unit} has its own cold cache");
        assert_eq!(served.levels[1].misses, if unit == 0 { 8 } else { 0 });
        assert_eq!(cache.read(path, unit, &ids(0..8)).levels[0].misses, 0);
    }
}

#[test]
fn neighbouring_units_share_the_copies_of_a_level_with_fewer() {
    let first = LevelConfig { count: 4, ..level("L1", 1, Ways::Count(1)) };
    let second = LevelConfig { count: 2, ..level("L2", 16, Ways::Count(4)) };
    let (mut cache, path) = chain(vec![first, second]);
    let misses = [0, 1, 2, 3].map(|unit| cache.read(path, unit, &ids([7])).levels[1].misses);
    assert_eq!(misses, [1, 0, 1, 0]);
}

#[test]
fn paths_meet_where_they_share_a_level() {
    let levels =
        Levels::new(vec![level("texture L1", 16, Ways::Count(4)), level("UCHE", 64, Ways::Count(4))])
            .expect("valid");
    let (mut cache, paths) = Hierarchy::with_paths(&levels, &[&[1], &[0, 1]]).expect("valid");
    let (nodes, textures) = (paths[0], paths[1]);
    assert_eq!(cache.read(nodes, 0, &ids(0..8)).memory.read_bytes, 8 * 64);
    let served = cache.read(textures, 0, &ids(0..8));
    assert_eq!((served.levels[0].misses, served.levels[1].misses, served.memory.reads), (8, 0, 0));
    assert_eq!((cache.counts(0).accesses, cache.counts(1).accesses), (8, 16));
}

#[test]
fn paths_that_do_not_fit_are_refused() {
    let names = ["a", "b", "c"];
    let plain =
        Levels::new(names.iter().map(|name| level(name, 16, Ways::Count(4))).collect()).expect("valid");
    let cases: [(&[&[usize]], &str); 4] = [
        (&[&[]], "a path has no levels"),
        (&[&[0, 3]], "a path names level 3, expected less than 3"),
        (&[&[1, 0]], "not further from the requester"),
        (&[&[0, 1], &[0, 2]], "two paths leave this level for different ones"),
    ];
    for (paths, expected) in cases {
        let refusal = Hierarchy::with_paths(&plain, paths).expect_err("must be refused").to_string();
        assert!(refusal.contains(expected), "got '{refusal}', expected '{expected}'");
    }
    let widening = vec![level("a", 16, Ways::Full), LevelConfig { count: 2, ..level("b", 16, Ways::Full) }];
    let refusal =
        Hierarchy::chain(&Levels::new(widening).expect("valid")).expect_err("must be refused").to_string();
    assert!(refusal.contains("2 copies cannot serve the 1 copies of \"a\" evenly"), "{refusal}");
}

#[test]
fn a_dirty_line_is_written_back_when_it_leaves_or_at_the_flush_and_only_once() {
    let (mut cache, path) = chain(vec![level("L", 2, Ways::Full)]);
    cache.write(path, 0, &ids([0, 1]));
    assert_eq!(cache.memory().writes, 0);
    cache.read(path, 0, &ids([2]));
    assert_eq!((cache.memory().writes, cache.counts(0).writebacks), (1, 1), "line 0 left");
    assert_eq!(cache.flush().memory.writes, 1, "line 1 was still dirty");
    assert_eq!(cache.flush().memory.writes, 0);
    assert_eq!(cache.read(path, 0, &ids([1, 2])).levels[0].misses, 0, "a flush keeps the lines");
}

#[test]
fn write_policies_differ_in_what_reaches_memory() {
    use WriteMiss::{Around, Fetch, Validate};
    use WritePolicy::{Back, Through};
    for (write, write_miss, expected) in [
        (Back, Fetch, (1, 1)),
        (Back, Validate, (0, 1)),
        (Back, Around, (0, 3)),
        (Through, Fetch, (1, 3)),
        (Through, Validate, (0, 3)),
        (Through, Around, (0, 3)),
    ] {
        let (mut cache, path) = chain(vec![LevelConfig { write, write_miss, ..level("L", 4, Ways::Full) }]);
        cache.write(path, 0, &ids([5, 5, 5]));
        cache.flush();
        assert_eq!((cache.memory().reads, cache.memory().writes), expected, "{write:?} {write_miss:?}");
    }
}

#[test]
fn a_write_back_that_covers_the_line_below_reads_nothing() {
    let (mut cache, path) = chain(vec![level("L1", 1, Ways::Full), level("L2", 1, Ways::Full)]);
    cache.access(path, 0, &[Access::write(LineId::new(0)), Access::read(LineId::new(1))]);
    assert_eq!(cache.memory().reads, 2, "one each for lines 0 and 1, none for the write-back of 0");
    assert_eq!((cache.counts(1).writes, cache.counts(1).write_misses), (1, 1));
}

#[test]
fn a_sectored_line_is_filled_sector_by_sector() {
    let config = LevelConfig {
        sector: Some(line_size(32)),
        ..LevelConfig::new("L", Bytes(128 * 4), line_size(128), Ways::Count(4), Policy::Lru)
    };
    let (mut cache, path) = chain(vec![config]);
    assert_eq!(cache.granule(path).bytes(), 32);
    cache.read(path, 0, &ids([0, 1, 0, 4]));
    let counts = cache.counts(0);
    assert_eq!((counts.accesses, counts.misses, counts.sector_misses, counts.fills), (4, 3, 1, 3));
    assert_eq!(cache.memory().read_bytes, 3 * 32);
}

#[test]
fn misses_are_told_apart_by_cause() {
    let config = LevelConfig { miss_classes: true, ..level("L", 4, Ways::Count(1)) };
    let (mut cache, path) = chain(vec![config]);
    cache.read(path, 0, &ids([0, 4, 0]));
    let conflict = MissClasses { cold: 2, capacity: 0, conflict: 1 };
    assert_eq!(cache.counts(0).classes, Some(conflict), "0 and 4 share a set of a half empty cache");
    cache.read(path, 0, &ids([1, 2, 3, 5, 4]));
    let capacity = MissClasses { cold: 6, capacity: 1, conflict: 1 };
    assert_eq!(cache.counts(0).classes, Some(capacity), "4 other lines came between");
}

#[test]
fn lines_of_different_sizes_are_fetched_in_parts_or_found_as_neighbours() {
    let small = |name: &str| LevelConfig::new(name, Bytes(1024), line_size(32), Ways::Full, Policy::Lru);
    let large = |name: &str| LevelConfig::new(name, Bytes(4096), line_size(128), Ways::Full, Policy::Lru);
    let (mut cache, path) = chain(vec![small("L1"), large("L2")]);
    cache.read(path, 0, &ids(0..8));
    assert_eq!((cache.counts(1).accesses, cache.counts(1).misses), (8, 2));
    assert_eq!(cache.memory().read_bytes, 2 * 128);
    let (mut cache, path) = chain(vec![large("L1"), small("L2")]);
    cache.read(path, 0, &ids(0..2));
    assert_eq!((cache.counts(1).accesses, cache.counts(1).misses), (8, 8));
    assert_eq!(cache.memory().read_bytes, 8 * 32);
}

#[test]
fn any_address_is_legal_and_far_ones_are_told_from_near_ones() {
    let (mut cache, path) = chain(vec![level("L1", 64, Ways::Count(4)), level("L2", 256, Ways::Count(16))]);
    let last = u64::MAX >> 6;
    let near = [0, 1, (1 << 30) - 1];
    let far = [
        1 << 30,
        (1 << 31) - 2,
        (1 << 31) - 1,
        1 << 31,
        u64::from(u32::MAX),
        1 << 32,
        (1 << 32) + 1,
        last - 1,
        last,
    ];
    for round in 0..2 {
        let misses = cache.read(path, 0, &ids(near)).levels[0].misses
            + cache.read(path, 0, &ids(far)).levels[0].misses;
        assert_eq!(misses, if round == 0 { 12 } else { 0 });
    }
}

#[test]
fn a_line_fetched_whole_below_may_reach_beyond_the_number_asked_for() {
    let level =
        |name: &str, line: u64| LevelConfig::new(name, Bytes(1024), line_size(line), Ways::Full, Policy::Lru);
    let (mut cache, path) = chain(vec![level("L1", 16), level("L2", 64), level("L3", 16)]);
    for power in 29..=60 {
        let served = cache.read(path, 0, &ids([(1 << power) - 4]));
        assert_eq!([0, 1, 2].map(|level| served.levels[level].misses), [1, 1, 4], "below 1 << {power}");
    }
}

#[test]
fn a_reset_hierarchy_and_a_clone_repeat_every_count() {
    let random = LevelConfig { policy: Policy::Random { seed: 7 }, ..level("L1", 16, Ways::Count(4)) };
    let (mut cache, path) = chain(vec![random, level("L2", 64, Ways::Count(8))]);
    let lines = ids((0..1000).map(|i| i * i % 97));
    let first = cache.read(path, 0, &lines);
    let mut copy = cache.clone();
    assert_eq!(copy.write(path, 0, &lines), cache.write(path, 0, &lines));
    cache.reset();
    assert_eq!(cache.counts(0).accesses, 0);
    assert_eq!(cache.read(path, 0, &lines), first);
}
