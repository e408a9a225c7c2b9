//! A slow and obvious simulator: every cache is a list of lines with their times, every access walks all
//! levels before the next begins.

use std::collections::{BTreeSet, HashSet};

use cachesim::{
    Access, LevelConfig, LevelCounts, Levels, MemoryCounts, MissClasses, Policy, Served, WriteMiss,
    WritePolicy,
};

/// One line in a set.
#[derive(Clone, Debug)]
struct Line {
    number: u64,
    way: u64,
    used: u64,
    entered: u64,
    prediction: u8,
    valid: BTreeSet<u64>,
    dirty: BTreeSet<u64>,
}

/// One copy of a level.
#[derive(Clone, Debug)]
struct Cache {
    sets: Vec<Vec<Line>>,
    /// Per set, for tree PLRU: each way's accesses in order.
    history: Vec<Vec<u64>>,
    random: u64,
    clock: u64,
    /// For miss classes: lines by recency, and all ever seen.
    shadow: Vec<u64>,
    seen: HashSet<u64>,
}

pub(crate) struct Naive {
    configs: Vec<LevelConfig>,
    units: u32,
    caches: Vec<Vec<Cache>>,
    counts: Vec<LevelCounts>,
    memory: MemoryCounts,
}

impl Naive {
    pub(crate) fn new(levels: &Levels) -> Self {
        let configs = levels.as_slice().to_vec();
        let cache = |config: &LevelConfig, copy: u32| Cache {
            sets: vec![Vec::new(); config.sets() as usize],
            history: vec![Vec::new(); config.sets() as usize],
            random: match config.policy {
                Policy::Random { seed } => seed + u64::from(copy),
                _ => 0,
            },
            clock: 0,
            shadow: Vec::new(),
            seen: HashSet::new(),
        };
        let caches = configs.iter().map(|c| (0..c.count).map(|copy| cache(c, copy)).collect()).collect();
        let counts = configs
            .iter()
            .map(|c| LevelCounts {
                classes: c.miss_classes.then(MissClasses::default),
                ..LevelCounts::default()
            })
            .collect();
        Self { configs, units: levels.units(), caches, counts, memory: MemoryCounts::default() }
    }

    pub(crate) fn counts(&self) -> Vec<LevelCounts> {
        self.counts.clone()
    }

    pub(crate) fn memory(&self) -> MemoryCounts {
        self.memory
    }

    pub(crate) fn run(&mut self, unit: u32, run: &[Access]) -> Served {
        let (before, memory) = (self.counts.clone(), self.memory);
        for access in run {
            self.access(0, unit, access.line().get(), access.is_write(), false);
        }
        let mut served = Served::default();
        for (level, (after, before)) in self.counts.iter().zip(before).enumerate() {
            served.levels[level].accesses = after.accesses - before.accesses;
            served.levels[level].misses = after.misses - before.misses;
        }
        served.memory = MemoryCounts {
            reads: self.memory.reads - memory.reads,
            writes: self.memory.writes - memory.writes,
            read_bytes: self.memory.read_bytes - memory.read_bytes,
            write_bytes: self.memory.write_bytes - memory.write_bytes,
        };
        served
    }

    /// Sends one granule of `level` to what is below it.
    fn below(&mut self, level: usize, unit: u32, granule: u64, write: bool) {
        let bytes = self.configs[level].granule().bytes();
        if level + 1 == self.configs.len() {
            if write {
                self.memory.writes += 1;
                self.memory.write_bytes += bytes;
            } else {
                self.memory.reads += 1;
                self.memory.read_bytes += bytes;
            }
            return;
        }
        let (above, here) = (&self.configs[level], &self.configs[level + 1]);
        let smaller = here.granule().bytes();
        let whole =
            above.write == WritePolicy::Back && above.write_miss != WriteMiss::Around && bytes >= smaller;
        let first = u128::from(granule) * u128::from(bytes);
        let last = first + u128::from(bytes) - 1;
        for part in first / u128::from(smaller)..=last / u128::from(smaller) {
            self.access(level + 1, unit, part as u64, write, whole);
        }
    }

    fn access(&mut self, level: usize, unit: u32, granule: u64, write: bool, whole: bool) {
        let config = self.configs[level].clone();
        let copy = (unit / (self.units / config.count)) as usize;
        let per_line = config.line.bytes() / config.granule().bytes();
        let (number, sector) = (granule / per_line, granule % per_line);
        let cache = &mut self.caches[level][copy];
        let counts = &mut self.counts[level];
        cache.clock += 1;
        let clock = cache.clock;
        let at = (number % config.sets()) as usize;
        let allocate = !write || config.write_miss != WriteMiss::Around;
        let fetch = !write || (config.write_miss == WriteMiss::Fetch && !whole);
        let through = write && config.write == WritePolicy::Through;
        let mut to_send = Vec::new();

        counts.accesses += 1;
        counts.writes += u64::from(write);
        let found = cache.sets[at].iter().position(|line| line.number == number);
        if let Some(index) = found {
            let line = &mut cache.sets[at][index];
            line.used = clock;
            line.prediction = 0;
            let way = line.way;
            cache.history[at].push(way);
        }
        let hit = found.is_some_and(|index| cache.sets[at][index].valid.contains(&sector));
        if let Some(classes) = &mut counts.classes {
            classify(cache, &config, number, found.is_none(), allocate, classes);
        }
        if hit {
            counts.hits += 1;
        } else {
            counts.misses += 1;
            counts.write_misses += u64::from(write);
            counts.sector_misses += u64::from(found.is_some());
        }
        if !hit && allocate && fetch {
            counts.fills += 1;
            to_send.push((granule, false));
        }
        if hit || allocate {
            let index = found.unwrap_or_else(|| {
                let way = if (cache.sets[at].len() as u64) < config.way_count() {
                    cache.sets[at].len() as u64
                } else {
                    let way = victim(cache, &config, at);
                    let index = cache.sets[at].iter().position(|line| line.way == way).expect("a full set");
                    let line = cache.sets[at].remove(index);
                    counts.writebacks += line.dirty.len() as u64;
                    to_send.extend(line.dirty.iter().map(|sector| (line.number * per_line + sector, true)));
                    way
                };
                cache.history[at].push(way);
                cache.sets[at].push(Line {
                    number,
                    way,
                    used: clock,
                    entered: clock,
                    prediction: 2,
                    valid: BTreeSet::new(),
                    dirty: BTreeSet::new(),
                });
                cache.sets[at].len() - 1
            });
            let line = &mut cache.sets[at][index];
            line.valid.insert(sector);
            if write && !through {
                line.dirty.insert(sector);
            }
        }
        if through || (write && !hit && !allocate) {
            to_send.push((granule, true));
        }
        for (granule, write) in to_send {
            self.below(level, unit, granule, write);
        }
    }

    /// Writes back level by level, each copy in order of addresses.
    pub(crate) fn flush(&mut self) {
        for level in 0..self.configs.len() {
            let units_per_copy = self.units / self.configs[level].count;
            let per_line = self.configs[level].line.bytes() / self.configs[level].granule().bytes();
            for copy in 0..self.caches[level].len() {
                let mut dirty = Vec::new();
                let cache = &mut self.caches[level][copy];
                for line in cache.sets.iter_mut().flatten() {
                    let sectors = std::mem::take(&mut line.dirty);
                    dirty.extend(sectors.into_iter().map(|sector| line.number * per_line + sector));
                }
                dirty.sort_unstable();
                self.counts[level].writebacks += dirty.len() as u64;
                for granule in dirty {
                    self.below(level, copy as u32 * units_per_copy, granule, true);
                }
            }
        }
    }
}

/// The way to replace in a full set, from the policies' definitions.
fn victim(cache: &mut Cache, config: &LevelConfig, at: usize) -> u64 {
    let set = &mut cache.sets[at];
    let least = |key: fn(&Line) -> u64| set.iter().min_by_key(|line| key(line)).expect("a full set").way;
    match config.policy {
        Policy::Lru => least(|line| line.used),
        Policy::Fifo => least(|line| line.entered),
        Policy::Plru => plru_victim(&cache.history[at], 0, config.way_count()),
        Policy::Srrip => loop {
            set.sort_by_key(|line| line.way);
            if let Some(line) = set.iter().find(|line| line.prediction == 3) {
                break line.way;
            }
            set.iter_mut().for_each(|line| line.prediction += 1);
        },
        Policy::Random { .. } => {
            cache.random = cache.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (cache.random ^ (cache.random >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((u128::from(z ^ (z >> 31)) * u128::from(config.way_count())) >> 64) as u64
        }
    }
}

/// Of `ways` ways from `first`: goes into the half that was not accessed last, over and over.
fn plru_victim(history: &[u64], first: u64, ways: u64) -> u64 {
    if ways == 1 {
        return first;
    }
    let middle = first + ways / 2;
    match history.iter().rev().find(|&&way| way >= first && way < first + ways) {
        Some(&way) if way < middle => plru_victim(history, middle, ways / 2),
        _ => plru_victim(history, first, ways / 2),
    }
}

fn classify(
    cache: &mut Cache,
    config: &LevelConfig,
    number: u64,
    missed: bool,
    allocate: bool,
    classes: &mut MissClasses,
) {
    let first = cache.seen.insert(number);
    let place = cache.shadow.iter().position(|&line| line == number);
    if missed {
        if first {
            classes.cold += 1;
        } else if place.is_none() {
            classes.capacity += 1;
        } else {
            classes.conflict += 1;
        }
    }
    if let Some(place) = place {
        cache.shadow.remove(place);
    }
    if place.is_some() || allocate {
        cache.shadow.insert(0, number);
        cache.shadow.truncate(config.lines() as usize);
    }
}
