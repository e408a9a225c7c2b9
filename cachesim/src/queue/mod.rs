//! Sets kept as queues: the most recently used (LRU) or newest (FIFO) line first, empty ways last, so that
//! the order of the tags is all the state there is. A dirty line has the flag of its tag set.
//!
//! One loop per instruction set: [`scalar`] moves tags one by one and stops at the hit; [`vector`] holds a
//! set in one or two registers, compares all tags at once and rotates those up to the hit, hit or miss
//! alike, without a branch.

mod aligned;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod scalar;
#[cfg(target_arch = "x86_64")]
mod vector;

pub(crate) use scalar::{Order, Touch};
#[cfg(target_arch = "x86_64")]
pub(crate) use vector::{MaskOrder, SetVector, up_to};

use self::aligned::Aligned;
use crate::config::{LevelConfig, Policy};
use crate::isa::{Isa, Kind};
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::policy::{fifo::Fifo, lru::Lru};
use crate::sets::SetIndex;
use crate::word::Word;

/// The most ways of a queue.
pub(crate) const MAX_QUEUE_WAYS: u64 = 16;

/// The tags: for every set that `index` can name, `lanes` words, of which the first `ways` are used and
/// the others stay empty.
#[derive(Clone, Debug)]
pub(crate) struct QueueSets<W> {
    tags: Aligned<W>,
    lanes: usize,
    ways: usize,
    index: SetIndex,
}

/// The loops over requests for one policy, number of lanes and instruction set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passes<W> {
    /// Serves reads from sets without a dirty line. The lines that missed come first in the output, which
    /// must be as long as the input; their number is returned.
    reads: unsafe fn(&mut QueueSets<W>, &[W], &mut [W]) -> usize,
    /// Serves reads and writes, and says who caused what; counts no [`Tally::writes`]. The output must be twice as long
    /// as the input.
    mixed: unsafe fn(&mut QueueSets<W>, &[W], Out<'_, W>, WriteRule) -> Tally,
}

/// Words for which there may be vector loops.
pub(crate) trait Vectorised: Sized {
    /// The loops for sets of `lanes` words; `None` if `isa` has none better than the scalar ones.
    fn passes(isa: Isa, lanes: usize, fifo: bool) -> Option<Passes<Self>>;
}

#[cfg(target_arch = "x86_64")]
impl Vectorised for u32 {
    fn passes(isa: Isa, lanes: usize, fifo: bool) -> Option<Passes<Self>> {
        match isa.kind() {
            Kind::Scalar => None,
            Kind::Avx2 => avx2::passes_u32(lanes, fifo),
            Kind::Avx512 => avx512::passes_u32(lanes, fifo),
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Vectorised for u64 {
    fn passes(isa: Isa, lanes: usize, fifo: bool) -> Option<Passes<Self>> {
        match isa.kind() {
            Kind::Scalar | Kind::Avx2 => None,
            Kind::Avx512 => avx512::passes_u64(lanes, fifo),
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl<W: Word> Vectorised for W {
    fn passes(_isa: Isa, _lanes: usize, _fifo: bool) -> Option<Passes<Self>> {
        None
    }
}

/// A set-associative cache whose sets are queues.
#[derive(Clone, Debug)]
pub(crate) struct Queue<W> {
    sets: QueueSets<W>,
    passes: Passes<W>,
    isa: Isa,
    fifo: bool,
    /// Some line may be dirty.
    dirty: bool,
}

impl<W: Word> Queue<W> {
    pub(crate) fn new(config: &LevelConfig, isa: Isa) -> Self {
        let ways = config.way_count() as usize;
        let lanes = ways.next_power_of_two().max(4);
        let sets = QueueSets {
            tags: Aligned::new(W::EMPTY, config.sets() as usize * lanes),
            lanes,
            ways,
            index: SetIndex::new(config.sets()),
        };
        Self::from_sets(sets, isa, config.policy == Policy::Fifo, false)
    }

    fn from_sets(sets: QueueSets<W>, isa: Isa, fifo: bool, dirty: bool) -> Self {
        let scalar = if fifo { scalar::passes::<W, Fifo>() } else { scalar::passes::<W, Lru>() };
        let passes = W::passes(isa, sets.lanes, fifo).unwrap_or(scalar);
        Self { sets, passes, isa, fifo, dirty }
    }

    #[inline]
    pub(crate) fn run(&mut self, input: &[W], out: Out<'_, W>, rule: WriteRule) -> Tally {
        let writes = input.iter().filter(|word| word.flagged()).count() as u64;
        if writes > 0 || self.dirty || out.traced {
            self.dirty |= writes > 0 && !rule.through;
            // SAFETY: the loops were chosen for an `Isa`, which exists only where the machine has it.
            let tally = unsafe { (self.passes.mixed)(&mut self.sets, input, out, rule) };
            Tally { writes, ..tally }
        } else {
            // SAFETY: as above.
            let sent = unsafe { (self.passes.reads)(&mut self.sets, input, out.words) };
            Tally { sent, misses: sent as u64, fills: sent as u64, ..Tally::default() }
        }
    }

    pub(crate) fn clean(&mut self, out: &mut Vec<W>) {
        for tag in self.sets.tags.as_mut_slice() {
            if tag.flagged() {
                out.push(*tag);
                *tag = tag.without_flag();
            }
        }
        self.dirty = false;
    }

    pub(crate) fn widened(self) -> Queue<u64> {
        let widen = |tag: W| {
            if tag == W::EMPTY { u64::EMPTY } else { u64::from_id(tag.id()).with_flag(tag.flagged()) }
        };
        let QueueSets { tags, lanes, ways, index } = self.sets;
        let sets = QueueSets { tags: tags.map(widen), lanes, ways, index };
        Queue::from_sets(sets, self.isa, self.fifo, self.dirty)
    }
}
