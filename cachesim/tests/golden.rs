//! Known counts: do the synthetic streams and the caches agree, miss for miss, with other simulators?

use cachesim::synthetic::{Stream, lines};
use cachesim::{Bytes, Hierarchy, Isa, LevelConfig, Levels, LineId, LineSize, Policy, StackDistances, Ways};

fn line() -> LineSize {
    LineSize::new(64).expect("64 is a power of two")
}

fn misses(policy: Policy, trace: &[LineId]) -> [u64; 2] {
    let levels = Levels::new(vec![
        LevelConfig::new("L1", Bytes(16 << 10), line(), Ways::Count(4), policy),
        LevelConfig::new("L2", Bytes(1 << 20), line(), Ways::Count(16), policy),
    ])
    .expect("a plain hierarchy");
    let mut found = Isa::available().into_iter().map(|isa| {
        let (hierarchy, path) = Hierarchy::chain(&levels).expect("a plain hierarchy");
        let mut hierarchy = hierarchy.on(isa);
        hierarchy.read(path, 0, trace);
        (isa, [hierarchy.counts(0).misses, hierarchy.counts(1).misses])
    });
    let (_, scalar) = found.next().expect("scalar code runs everywhere");
    found.for_each(|(isa, misses)| assert_eq!(misses, scalar, "{isa} differs from scalar"));
    scalar
}

fn first_lines(stream: Stream, count: usize) -> Vec<u64> {
    lines(stream, count).into_iter().map(LineId::get).collect()
}

#[test]
fn the_streams_begin_with_the_published_lines() {
    assert_eq!(
        first_lines(Stream::Bvh, 6),
        [0x40_0000, 0x40_0001, 0x40_0002, 0x40_0004, 0x40_0008, 0x40_0010]
    );
    assert_eq!(first_lines(Stream::Rnd, 4), [0x25d60, 0x2ff21, 0x261ee, 0x30fca]);
    assert_eq!(first_lines(Stream::Seq, 9), [0, 0, 0, 0, 1, 1, 1, 1, 2]);
}

#[test]
fn lru_misses_on_bvh_are_the_published_ones() {
    let trace = lines(Stream::Bvh, 24_000_000);
    assert_eq!(misses(Policy::Lru, &trace[..10_000]), [2_785, 252]);
    assert_eq!(misses(Policy::Lru, &trace[..1_000_000]), [193_614, 6_767]);
    assert_eq!(misses(Policy::Lru, &trace), [4_363_526, 139_686]);
}

#[test]
fn lru_misses_on_rnd_are_the_published_ones() {
    let trace = lines(Stream::Rnd, 24_000_000);
    assert_eq!(misses(Policy::Lru, &trace[..100_000]), [99_890, 94_233]);
    assert_eq!(misses(Policy::Lru, &trace[..1_000_000]), [999_041, 938_025]);
    assert_eq!(misses(Policy::Lru, &trace), [23_976_870, 22_502_469]);
}

#[test]
fn lru_misses_on_seq_are_one_per_line() {
    assert_eq!(misses(Policy::Lru, &lines(Stream::Seq, 1_000_000)), [250_000, 250_000]);
}

#[test]
fn fifo_misses_on_bvh_are_the_published_ones() {
    assert_eq!(misses(Policy::Fifo, &lines(Stream::Bvh, 1_000_000)), [220_165, 6_767]);
}

#[test]
fn fully_associative_misses_on_bvh_are_the_published_ones() {
    let mut distances = StackDistances::new();
    for line in lines(Stream::Bvh, 24_000_000) {
        distances.touch(line);
    }
    let curve = distances.curve();
    assert_eq!(curve.cold_misses(), 104_741);
    assert_eq!(
        [16 << 10, 1 << 20, 8 << 20].map(|size: u64| curve.misses(size / 64)),
        [3_675_527, 137_331, 104_741]
    );
}
