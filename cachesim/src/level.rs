//! One level of a hierarchy: its private copies, what it does with writes, and its totals.

use crate::config::{LevelConfig, WriteMiss, WritePolicy};
use crate::counts::LevelCounts;
use crate::isa::Isa;
use crate::out::Out;
use crate::store::Store;
use crate::word::Word;

/// What one pass of requests through one copy of a level did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// Requests passed on below, now at the start of the output.
    pub(crate) sent: usize,
    pub(crate) misses: u64,
    pub(crate) writes: u64,
    pub(crate) write_misses: u64,
    pub(crate) sector_misses: u64,
    pub(crate) fills: u64,
    pub(crate) writebacks: u64,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        let Self { sent, misses, writes, write_misses, sector_misses, fills, writebacks } = other;
        self.sent += sent;
        self.misses += misses;
        self.writes += writes;
        self.write_misses += write_misses;
        self.sector_misses += sector_misses;
        self.fills += fills;
        self.writebacks += writebacks;
    }
}

/// What a level does with a write, decided once when the hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WriteRule {
    /// Written data moves on at once, and lines are never dirty.
    pub(crate) through: bool,
    /// A write that misses takes a line.
    pub(crate) allocate: bool,
    /// A write that misses and takes a line reads it first.
    pub(crate) fetch: bool,
}

impl WriteRule {
    /// `whole`: every write that arrives covers at least one granule of this level, so that no line needs
    /// to be read before it.
    pub(crate) fn new(config: &LevelConfig, whole: bool) -> Self {
        Self {
            through: config.write == WritePolicy::Through,
            allocate: config.write_miss != WriteMiss::Around,
            fetch: config.write_miss == WriteMiss::Fetch && !whole,
        }
    }
}

/// How a granule number becomes that of the level below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rescale {
    /// The granules are equal, or the lower one is `1 << n` times as large.
    Coarser(u32),
    /// The lower granule is `1 << n` times smaller: one request becomes as many.
    Finer(u32),
}

impl Rescale {
    pub(crate) fn between(above: &LevelConfig, below: &LevelConfig) -> Self {
        let (above, below) = (above.granule().log2(), below.granule().log2());
        if below >= above { Self::Coarser(below - above) } else { Self::Finer(above - below) }
    }

    /// Bits by which a number can grow.
    pub(crate) fn growth(self) -> u32 {
        match self {
            Self::Coarser(_) => 0,
            Self::Finer(bits) => bits,
        }
    }
}

/// The level that another level misses to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Below {
    pub(crate) level: usize,
    pub(crate) rescale: Rescale,
    /// Write rule of the level below for what comes from here.
    pub(crate) rule: WriteRule,
}

/// One level with all its copies.
#[derive(Clone, Debug)]
pub(crate) struct Level<W: Word> {
    pub(crate) below: Option<Below>,
    /// Rule for accesses that enter the hierarchy here.
    pub(crate) entry_rule: WriteRule,
    pub(crate) granule_bytes: u64,
    /// The most requests that one request can cause below.
    pub(crate) fan_out: usize,
    copies: Vec<Store<W>>,
    copy_of_unit: Vec<u16>,
    counts: LevelCounts,
}

impl<W: Word> Level<W> {
    pub(crate) fn new(config: &LevelConfig, units: u32, below: Option<Below>, isa: Isa) -> Self {
        let units_per_copy = units / config.count;
        Self {
            below,
            entry_rule: WriteRule::new(config, false),
            granule_bytes: config.granule().bytes(),
            fan_out: 1 + (config.line.bytes() / config.granule().bytes()) as usize,
            copies: (0..config.count).map(|copy| Store::new(config, copy, isa)).collect(),
            copy_of_unit: (0..units).map(|unit| (unit / units_per_copy) as u16).collect(),
            counts: LevelCounts::default(),
        }
    }

    /// Serves `input` from the copy that belongs to `unit`, in order. What has to go below comes first in
    /// `out`, in order.
    ///
    /// # Panics
    /// If there is no such unit.
    #[inline]
    pub(crate) fn run(&mut self, unit: u32, input: &[W], out: Out<'_, W>, rule: WriteRule) -> Tally {
        let copy = usize::from(self.copy_of_unit[unit as usize]);
        let tally = self.copies[copy].run(input, out, rule);
        let Tally { sent: _, misses, writes, write_misses, sector_misses, fills, writebacks } = tally;
        self.counts.accesses += input.len() as u64;
        self.counts.misses += misses;
        self.counts.writes += writes;
        self.counts.write_misses += write_misses;
        self.counts.sector_misses += sector_misses;
        self.counts.fills += fills;
        self.counts.writebacks += writebacks;
        tally
    }

    /// Cleans every dirty granule of the copy that `copy` names and appends it to `out`, in order of
    /// addresses.
    pub(crate) fn clean(&mut self, copy: usize, out: &mut Vec<W>) {
        let before = out.len();
        self.copies[copy].clean(out);
        out[before..].sort_unstable_by_key(|word| word.id());
        self.counts.writebacks += (out.len() - before) as u64;
    }

    pub(crate) fn copies(&self) -> usize {
        self.copies.len()
    }

    /// A unit that the copy serves.
    pub(crate) fn unit_of_copy(&self, copy: usize) -> u32 {
        (copy * self.copy_of_unit.len() / self.copies.len()) as u32
    }

    pub(crate) fn counts(&self) -> LevelCounts {
        let classes = self.copies.iter().filter_map(Store::classes).reduce(|a, b| a.plus(b));
        LevelCounts { hits: self.counts.accesses - self.counts.misses, classes, ..self.counts }
    }

    /// The same contents and totals in wider words.
    pub(crate) fn widened(self) -> Level<u64> {
        let Self { below, entry_rule, granule_bytes, fan_out, copies, copy_of_unit, counts } = self;
        let copies = copies.into_iter().map(Store::widened).collect();
        Level { below, entry_rule, granule_bytes, fan_out, copies, copy_of_unit, counts }
    }
}
