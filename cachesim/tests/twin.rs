//! Does the hierarchy count what an obvious simulator counts, access by access, whatever the policy, the
//! shape and the instruction set?

mod naive;

use cachesim::{
    Access, Bytes, Hierarchy, Isa, LevelConfig, Levels, LineId, LineSize, Missed, Policy, Served, Ways,
    WriteMiss, WritePolicy,
};
use naive::Naive;
use proptest::prelude::*;

fn line_size(log2: u32) -> LineSize {
    LineSize::new(1 << log2).expect("in range")
}

fn policy() -> impl Strategy<Value = Policy> {
    prop_oneof![
        3 => Just(Policy::Lru),
        2 => Just(Policy::Fifo),
        1 => Just(Policy::Plru),
        1 => Just(Policy::Srrip),
        1 => (0..4_u64).prop_map(|seed| Policy::Random { seed }),
    ]
}

/// A small level. `count` is left to the caller, who knows the other levels.
fn level() -> impl Strategy<Value = LevelConfig> {
    let shape = (
        policy(),
        1..20_u32,
        1..7_u64,
        any::<bool>(),
        4..8_u32,
        prop_oneof![2 => Just(None), 1 => (0..3_u32).prop_map(Some)],
    );
    let writes = (any::<bool>(), 0..3_usize, prop_oneof![3 => Just(false), 1 => Just(true)]);
    (shape, writes).prop_map(|((policy, ways, sets, full, log2, sector), (back, miss, miss_classes))| {
        let ways = if policy == Policy::Plru { ways.next_power_of_two() } else { ways };
        let line = line_size(log2);
        let size = Bytes(line.bytes() * u64::from(ways) * sets);
        let in_order = matches!(policy, Policy::Lru | Policy::Fifo);
        let ways = if full && in_order { Ways::Full } else { Ways::Count(ways) };
        LevelConfig {
            sector: sector.map(|smaller| line_size((log2 - smaller).max(3))),
            write: if back { WritePolicy::Back } else { WritePolicy::Through },
            write_miss: [WriteMiss::Fetch, WriteMiss::Validate, WriteMiss::Around][miss],
            miss_classes,
            ..LevelConfig::new("level", size, line, ways, policy)
        }
    })
}

fn levels() -> impl Strategy<Value = Levels> {
    (prop::collection::vec(level(), 1..4), 0..3_u32).prop_map(|(mut levels, doublings)| {
        let count = levels.len() as u32;
        for (index, level) in levels.iter_mut().enumerate() {
            level.name = format!("L{}", index + 1);
            level.count = 1 << doublings.saturating_sub(index as u32).min(count);
        }
        Levels::new(levels).expect("valid by construction")
    })
}

/// Runs of accesses: unit, and line and direction of each access. Lines are few, with far ones between.
fn runs() -> impl Strategy<Value = Vec<(u32, Vec<Access>)>> {
    let line = prop_oneof![
        8 => 0..40_u64,
        4 => 0..400_u64,
        1 => prop::sample::select(vec![u64::from(u32::MAX), 1 << 31, (1 << 31) - 1, (1 << 31) - 2, u64::MAX >> 8]),
    ];
    let access = (line, prop::bool::weighted(0.3)).prop_map(|(line, write)| {
        let line = LineId::new(line);
        if write { Access::write(line) } else { Access::read(line) }
    });
    prop::collection::vec((0..4_u32, prop::collection::vec(access, 1..30)), 1..30)
}

fn add(sum: &mut Served, served: Served) {
    for (sum, served) in sum.levels.iter_mut().zip(served.levels) {
        sum.accesses += served.accesses;
        sum.misses += served.misses;
    }
    sum.memory.reads += served.memory.reads;
    sum.memory.writes += served.memory.writes;
    sum.memory.read_bytes += served.memory.read_bytes;
    sum.memory.write_bytes += served.memory.write_bytes;
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn every_level_counts_what_the_naive_twin_counts(levels in levels(), runs in runs(), far in any::<bool>(), reads_first in 0..30_usize) {
        let mut twin = Naive::new(&levels);
        let machines = Isa::available();
        let mut fast: Vec<_> = machines.iter().map(|&isa| {
            let (hierarchy, path) = Hierarchy::chain(&levels).expect("valid by construction");
            (hierarchy.on(isa), path)
        }).collect();
        for (index, (unit, run)) in runs.iter().enumerate() {
            let unit = unit % levels.units();
            let run: Vec<Access> = run
                .iter()
                .filter(|access| far || access.line().get() < 1000)
                .map(|access| if index < reads_first { Access::read(access.line()) } else { *access })
                .collect();
            let expected = twin.run(unit, &run);
            for ((hierarchy, path), isa) in fast.iter_mut().zip(&machines) {
                prop_assert_eq!(hierarchy.access(*path, unit, &run), expected, "run {} on {}", index, isa);
            }
        }
        for _ in 0..2 {
            for ((hierarchy, _), isa) in fast.iter_mut().zip(&machines) {
                for (index, level) in twin.counts().into_iter().enumerate() {
                    prop_assert_eq!(hierarchy.counts(index), level, "level {} on {}", index, isa);
                }
                prop_assert_eq!(hierarchy.memory(), twin.memory(), "memory on {}", isa);
                hierarchy.flush();
            }
            twin.flush();
        }
    }

    #[test]
    fn every_class_of_a_run_counts_what_its_accesses_cause_one_by_one(
        levels in levels(),
        runs in runs(),
        far in any::<bool>(),
        classes in prop::collection::vec(0..5_u8, 30),
    ) {
        let mut twin = Naive::new(&levels);
        let machines = Isa::available();
        let mut fast: Vec<_> = machines.iter().map(|&isa| {
            let (hierarchy, path) = Hierarchy::chain(&levels).expect("valid by construction");
            (hierarchy.on(isa), path, [Served::default(); 5])
        }).collect();
        let mut expected = [Served::default(); 5];
        for (unit, run) in &runs {
            let unit = unit % levels.units();
            let run: Vec<Access> =
                run.iter().filter(|access| far || access.line().get() < 1000).copied().collect();
            let mut expected_missed = Missed::default();
            for ((access, &class), place) in run.iter().zip(&classes).zip(0..) {
                let served = twin.run(unit, std::slice::from_ref(access));
                for (missed, level) in expected_missed.levels.iter_mut().zip(served.levels) {
                    missed.extend((0..level.misses).map(|_| place));
                }
                expected_missed.memory.extend((0..served.memory.reads).map(|_| place));
                add(&mut expected[usize::from(class)], served);
            }
            for (hierarchy, path, served) in &mut fast {
                let mut missed = Missed::default();
                hierarchy.access_by_class(*path, unit, &run, &classes[..run.len()], served, &mut missed);
                prop_assert_eq!(&missed, &expected_missed);
            }
        }
        for ((_, _, served), isa) in fast.iter().zip(&machines) {
            prop_assert_eq!(served, &expected, "{}", isa);
        }
    }

    #[test]
    fn a_larger_fully_associative_lru_cache_holds_all_that_a_smaller_one_holds(
        lines in prop::collection::vec(0..60_u64, 1..400),
    ) {
        let mut distances = cachesim::StackDistances::new();
        lines.iter().for_each(|&line| distances.touch(LineId::new(line)));
        let curve = distances.curve();
        let mut fewer = u64::MAX;
        for capacity in 1..70 {
            let config = LevelConfig::new("L", Bytes(64 * capacity), line_size(6), Ways::Full, Policy::Lru);
            let levels = Levels::new(vec![config]).expect("a plain level");
            let (mut hierarchy, path) = Hierarchy::chain(&levels).expect("a plain level");
            let lines: Vec<LineId> = lines.iter().copied().map(LineId::new).collect();
            hierarchy.read(path, 0, &lines);
            let misses = hierarchy.counts(0).misses;
            prop_assert_eq!(curve.misses(capacity), misses, "{} lines", capacity);
            prop_assert!(misses <= fewer);
            fewer = misses;
        }
        prop_assert_eq!(fewer, curve.cold_misses());
        prop_assert_eq!(curve.misses(0), lines.len() as u64);
        prop_assert!(curve.points().all(|(lines, misses)| curve.misses(lines) == misses && curve.misses(lines - 1) > misses));
    }
}
