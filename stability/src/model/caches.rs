//! Caches from one line to a gibibyte.

use crate::Size;
use crate::case::Case;
use crate::random::Random;
use crate::structures::Watch;
use cachesim::{Bytes, Hierarchy, LevelConfig, Levels, LineId, LineSize, Policy, StackDistances, Ways};

const LINE: u64 = 64;

pub(crate) fn cases(size: Size, _: &Watch) -> Vec<Case> {
    let ((full, of_sets), random) =
        rayon::join(|| (resident(size, Ways::Full), resident(size, Ways::Count(8))), || random(size));
    vec![full, of_sets, random]
}

/// Misses of a cache of `lines` lines.
fn misses(lines: u64, ways: Ways, stream: impl Iterator<Item = u64>) -> u64 {
    let line = LineSize::new(LINE).expect("a power of two");
    let level = LevelConfig::new("cache", Bytes(lines * LINE), line, ways, Policy::Lru);
    let levels = Levels::new(vec![level]).expect("the cache can be simulated");
    let (mut hierarchy, path) = Hierarchy::chain(&levels).expect("one level");
    let mut chunk = Vec::with_capacity(4096);
    let mut stream = stream.map(LineId::new).peekable();
    let mut missed = 0;
    while stream.peek().is_some() {
        chunk.clear();
        chunk.extend(stream.by_ref().take(4096));
        missed += hierarchy.read(path, 0, &chunk).levels[0].misses;
    }
    missed
}

/// A stream as long as the cache, three times over, misses once for each line; with one line more in each set it misses always.
fn resident(size: Size, ways: Ways) -> Case {
    let (name, of_a_set, least) = match ways {
        Ways::Full => ("fully associative", None, 0),
        Ways::Count(ways) => ("8-way", Some(u64::from(ways)), 3),
    };
    let largest = size.of(18, 24);
    let mut unlike = 0;
    for shift in least..=largest {
        let lines = 1_u64 << shift;
        let sets = of_a_set.map_or(1, |ways| lines / ways);
        let rounds = |length: u64| (0..3).flat_map(move |_| 0..length);
        unlike += misses(lines, ways, rounds(lines)).abs_diff(lines);
        unlike += misses(lines, ways, rounds(lines + sets)).abs_diff(3 * (lines + sets));
    }
    Case::none_of(
        format!("caches/{}", if of_a_set.is_some() { "8-way" } else { "full" }),
        format!(
            "{name} LRU caches from {} B to {} MiB: a stream that fits misses once a line, one line more in each set and it misses always",
            LINE << least,
            (LINE << largest) >> 20
        ),
        "misses too many or too few",
        unlike,
    )
    .under("lines", (1_u64 << largest) as f64)
}

/// Misses at random fall with every doubling, to those that stack distances say.
fn random(size: Size) -> Case {
    let count = size.of(100_000, 2_000_000);
    let stream = || {
        let mut random = Random(1 << 30);
        (0..count).map(move |_| random.log_uniform(1.0, (1 << 24) as f64) as u64)
    };
    let mut distances = StackDistances::new();
    stream().for_each(|line| distances.touch(LineId::new(line)));
    let curve = distances.curve();
    let (mut unlike, mut before) = (0, u64::MAX);
    for shift in 0..=size.of(18, 24) {
        let found = misses(1 << shift, Ways::Full, stream());
        unlike += found.abs_diff(curve.misses(1 << shift)) + u64::from(found > before);
        before = found;
    }
    Case::none_of(
        "caches/random",
        "fully associative LRU caches of every power of two miss what stack distances say, and never more than half of one",
        "misses too many or too few",
        unlike,
    )
    .because(format!("{count} accesses to {} lines", curve.cold_misses()))
}
