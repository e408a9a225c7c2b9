//! Passes runs of requests down a path, level by level.
//!
//! A level's answer depends only on the order of the requests that reach it, and the level above emits
//! them in order. So a whole run can go through one level before the next sees any of it, and the counts
//! are those of a simulation access by access.

use crate::config::Levels;
use crate::counts::{LevelCounts, MemoryCounts, Served};
use crate::isa::Isa;
use crate::ledger::{Ledger, Trail, memory_traffic};
use crate::level::{Below, Level, Rescale, WriteRule};
use crate::out::Out;
use crate::tlb::Tlb;
use crate::word::Word;

/// Requests taken through the levels at once.
const BLOCK: usize = 4096;
/// The most requests that a block may become on the way down.
const MOST_REQUESTS: usize = 1 << 20;

/// All levels, memory's totals and the requests in flight.
#[derive(Clone, Debug, Default)]
pub(crate) struct Engine<W: Word> {
    levels: Vec<Level<W>>,
    /// By entry level.
    entries: Vec<Entry>,
    memory: MemoryCounts,
    /// Behind the last levels, where there is one.
    tlb: Option<Tlb>,
    /// Of the latest requests to memory, which have to walk for a page.
    walks: Vec<bool>,
    front: Vec<W>,
    back: Vec<W>,
    causes: Vec<u32>,
    missed: Vec<u32>,
}

/// What can enter at a level.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Requests at once.
    block: usize,
    /// The largest number that fits all along the way, and with it all numbers of the same granule
    /// however coarse: one less than a power of two.
    max_id: u64,
}

impl<W: Word> Engine<W> {
    pub(crate) fn new(levels: &Levels, below: &[Option<Below>], isa: Isa) -> Self {
        let configs = levels.as_slice();
        let levels: Vec<Level<W>> = configs
            .iter()
            .zip(below)
            .map(|(config, &below)| Level::new(config, levels.units(), below, isa))
            .collect();
        Self::from_levels(levels, MemoryCounts::default())
    }

    fn from_levels(levels: Vec<Level<W>>, memory: MemoryCounts) -> Self {
        let entries = (0..levels.len()).map(|level| Entry::new(&levels, level)).collect();
        Self {
            levels,
            entries,
            memory,
            tlb: None,
            walks: Vec::new(),
            front: vec![W::EMPTY; BLOCK],
            back: vec![W::EMPTY; 2 * BLOCK],
            causes: vec![0; 2 * BLOCK],
            missed: vec![0; BLOCK],
        }
    }

    /// Serves `items` in order from level `entry` on and tells `ledger` what they caused. Returns the
    /// rest, not served, from the first block on that holds a number too large for `W`.
    #[inline]
    pub(crate) fn run<'a, T: Copy, L: Ledger>(
        &mut self,
        entry: usize,
        unit: u32,
        items: &'a [T],
        split: impl Fn(T) -> (u64, bool),
        ledger: &mut L,
    ) -> &'a [T] {
        let Entry { block, max_id } = self.entries[entry];
        let mut rest = items;
        while !rest.is_empty() {
            let (now, later) = rest.split_at(block.min(rest.len()));
            // The limit is one less than a power of two: no number is beyond it exactly if all bits of all are within.
            let mut bits = 0;
            for (word, &item) in self.front.iter_mut().zip(now) {
                let (id, write) = split(item);
                bits |= id;
                *word = W::truncated(id).with_flag(write);
            }
            if bits > max_id {
                return rest;
            }
            ledger.enter(now.len());
            self.descend(entry, self.levels[entry].entry_rule, unit, now.len(), ledger);
            rest = later;
        }
        rest
    }

    /// Takes the first `len` requests in `front` down from level `entry`.
    #[inline]
    fn descend<L: Ledger>(&mut self, entry: usize, rule: WriteRule, unit: u32, len: usize, ledger: &mut L) {
        let (mut index, mut rule, mut len) = (entry, rule, len);
        for position in 0.. {
            let level = &mut self.levels[index];
            let needed = len * level.fan_out;
            if self.back.len() < needed {
                self.back.resize(needed, W::EMPTY);
            }
            if self.causes.len() < self.back.len() {
                self.causes.resize(self.back.len(), 0);
            }
            if self.missed.len() < len {
                self.missed.resize(len, 0);
            }
            let Self { front, back, causes, missed, .. } = self;
            let out = Out { words: back, causes, missed, traced: L::TRACED };
            let tally = level.run(unit, &front[..len], out, rule);
            let trail = Trail { missed: &missed[..tally.misses as usize], causes: &causes[..tally.sent] };
            ledger.level(position, len, tally.misses, trail);
            std::mem::swap(front, back);
            len = tally.sent;
            if len == 0 {
                return;
            }
            let Some(below) = level.below else {
                let requests = &self.front[..len];
                if let Some(tlb) = &mut self.tlb {
                    let address = |word: &W| word.id().saturating_mul(level.granule_bytes);
                    self.walks.clear();
                    self.walks.extend(requests.iter().map(|word| tlb.translate(address(word))));
                }
                ledger.memory(requests, level.granule_bytes, &self.walks);
                self.memory.add(&memory_traffic(requests, level.granule_bytes));
                return;
            };
            if let Rescale::Finer(bits) = below.rescale {
                ledger.split(bits);
            }
            len = self.rescale(len, below.rescale);
            index = below.level;
            rule = below.rule;
        }
    }

    fn rescale(&mut self, len: usize, rescale: Rescale) -> usize {
        match rescale {
            Rescale::Coarser(0) => len,
            Rescale::Coarser(bits) => {
                for word in &mut self.front[..len] {
                    *word = word.shifted_right(bits);
                }
                len
            }
            Rescale::Finer(bits) => {
                let needed = len << bits;
                if self.back.len() < needed {
                    self.back.resize(needed, W::EMPTY);
                }
                for (parts, &word) in self.back.chunks_exact_mut(1 << bits).zip(&self.front[..len]) {
                    for (part, id) in parts.iter_mut().zip(word.id() << bits..) {
                        *part = W::from_id(id).with_flag(word.flagged());
                    }
                }
                std::mem::swap(&mut self.front, &mut self.back);
                len << bits
            }
        }
    }

    pub(crate) fn flush(&mut self) -> Served {
        let mut flushed = Served::default();
        for index in 0..self.levels.len() {
            for copy in 0..self.levels[index].copies() {
                let mut dirty = Vec::new();
                self.levels[index].clean(copy, &mut dirty);
                let unit = self.levels[index].unit_of_copy(copy);
                self.write_below(index, unit, &dirty, &mut flushed);
            }
        }
        flushed
    }

    /// Writes granules of level `index` to what lies below it. `written.levels` goes by level index.
    fn write_below(&mut self, index: usize, unit: u32, dirty: &[W], written: &mut Served) {
        let Some(below) = self.levels[index].below else {
            let memory = memory_traffic(dirty, self.levels[index].granule_bytes);
            written.memory.add(&memory);
            self.memory.add(&memory);
            return;
        };
        let block = self.entries[index].block;
        for block in dirty.chunks(block) {
            let mut along = Served::default();
            self.front[..block.len()].copy_from_slice(block);
            let len = self.rescale(block.len(), below.rescale);
            self.descend(below.level, below.rule, unit, len, &mut along);
            written.memory.add(&along.memory);
            let mut level = Some(below.level);
            for served in along.levels {
                let Some(index) = level else { break };
                written.levels[index].accesses += served.accesses;
                written.levels[index].misses += served.misses;
                level = self.levels[index].below.map(|below| below.level);
            }
        }
    }

    pub(crate) fn counts(&self, level: usize) -> LevelCounts {
        self.levels[level].counts()
    }

    pub(crate) fn memory(&self) -> MemoryCounts {
        self.memory
    }

    /// Puts a TLB between the last levels and memory.
    pub(crate) fn set_tlb(&mut self, tlb: Option<Tlb>) {
        self.tlb = tlb;
    }

    /// Pages that were walked for.
    pub(crate) fn page_walks(&self) -> u64 {
        self.tlb.as_ref().map_or(0, Tlb::walks)
    }

    pub(crate) fn widened(self) -> Engine<u64> {
        let levels = self.levels.into_iter().map(Level::widened).collect();
        let mut engine = Engine::from_levels(levels, self.memory);
        engine.set_tlb(self.tlb);
        engine
    }
}

impl Entry {
    fn new<W: Word>(levels: &[Level<W>], entry: usize) -> Self {
        let (mut most, mut growth, mut bits) = (1, 0, 0_u32);
        let mut level = Some(&levels[entry]);
        let mut net = 0_i32;
        while let Some(here) = level {
            most *= here.fan_out;
            level = here.below.map(|below| {
                match below.rescale {
                    Rescale::Coarser(by) => net -= by as i32,
                    Rescale::Finer(by) => net += by as i32,
                }
                bits += below.rescale.growth();
                growth = growth.max(net);
                &levels[below.level]
            });
        }
        let worst = most.saturating_mul(1 << bits);
        Self { block: (MOST_REQUESTS / worst).clamp(1, BLOCK), max_id: W::MAX_ID >> 1 >> growth.max(0) }
    }
}
