//! One copy of a cache, whatever its policy: the choice is made here once per pass, and the loops behind
//! it are generic.

use crate::assoc::Assoc;
use crate::classes::Classified;
use crate::config::{LevelConfig, Policy, Ways};
use crate::counts::MissClasses;
use crate::full::FullyAssociative;
use crate::isa::Isa;
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::policy::{fifo::FifoTurn, lru::LruStamps, plru::TreePlru, random::Random, srrip::Srrip};
use crate::queue::{MAX_QUEUE_WAYS, Queue};
use crate::sectors::Sectors;
use crate::word::Word;

/// The contents of one cache.
#[derive(Clone, Debug)]
pub(crate) enum Store<W: Word> {
    /// Small LRU or FIFO sets without sectors, the fast case.
    Queue(Queue<W>),
    Lru(Assoc<LruStamps>),
    Fifo(Assoc<FifoTurn>),
    Plru(Assoc<TreePlru>),
    Srrip(Assoc<Srrip>),
    Random(Assoc<Random>),
    Full(FullyAssociative),
    Classified(Box<Classified<W>>),
}

/// Evaluates `$body` with the variant's contents as `$inner`.
macro_rules! each {
    ($store:expr, $inner:ident => $body:expr) => {
        match $store {
            Store::Queue($inner) => $body,
            Store::Lru($inner) => $body,
            Store::Fifo($inner) => $body,
            Store::Plru($inner) => $body,
            Store::Srrip($inner) => $body,
            Store::Random($inner) => $body,
            Store::Full($inner) => $body,
            Store::Classified($inner) => $body,
        }
    };
}

impl<W: Word> Store<W> {
    /// `copy`: which of the level's copies this is.
    pub(crate) fn new(config: &LevelConfig, copy: u32, isa: Isa) -> Self {
        let store = Self::unclassified(config, copy, isa);
        if config.miss_classes { Self::Classified(Box::new(Classified::new(store, config))) } else { store }
    }

    fn unclassified(config: &LevelConfig, copy: u32, isa: Isa) -> Self {
        let (sets, ways, sectors) = (config.sets(), config.way_count(), Sectors::of(config));
        let in_order = matches!(config.policy, Policy::Lru | Policy::Fifo);
        if in_order && config.sector.is_none() && ways <= MAX_QUEUE_WAYS {
            return Self::Queue(Queue::new(config, isa));
        }
        if in_order && (config.ways == Ways::Full || sets == 1) {
            let fifo = config.policy == Policy::Fifo;
            return Self::Full(FullyAssociative::new(config.lines(), sectors, fifo));
        }
        let (set_count, ways) = (sets as usize, ways as usize);
        match config.policy {
            Policy::Lru => Self::Lru(Assoc::new(sets, ways, sectors, LruStamps::new(set_count, ways))),
            Policy::Fifo => Self::Fifo(Assoc::new(sets, ways, sectors, FifoTurn::new(set_count, ways))),
            Policy::Plru => Self::Plru(Assoc::new(sets, ways, sectors, TreePlru::new(set_count, ways))),
            Policy::Srrip => Self::Srrip(Assoc::new(sets, ways, sectors, Srrip::new(set_count, ways))),
            Policy::Random { seed } => {
                let policy = Random::new(ways, seed.wrapping_add(u64::from(copy)));
                Self::Random(Assoc::new(sets, ways, sectors, policy))
            }
        }
    }

    /// Serves `input` in order; see [`crate::level::Level::run`].
    #[inline]
    pub(crate) fn run(&mut self, input: &[W], out: Out<'_, W>, rule: WriteRule) -> Tally {
        each!(self, store => store.run(input, out, rule))
    }

    /// Makes everything clean and appends what was dirty to `out`, flagged.
    pub(crate) fn clean(&mut self, out: &mut Vec<W>) {
        each!(self, store => store.clean(out));
    }

    pub(crate) fn classes(&self) -> Option<MissClasses> {
        match self {
            Self::Classified(classified) => Some(classified.classes()),
            _ => None,
        }
    }

    pub(crate) fn widened(self) -> Store<u64> {
        match self {
            Self::Queue(queue) => Store::Queue(queue.widened()),
            Self::Lru(assoc) => Store::Lru(assoc),
            Self::Fifo(assoc) => Store::Fifo(assoc),
            Self::Plru(assoc) => Store::Plru(assoc),
            Self::Srrip(assoc) => Store::Srrip(assoc),
            Self::Random(assoc) => Store::Random(assoc),
            Self::Full(full) => Store::Full(full),
            Self::Classified(classified) => Store::Classified(Box::new(classified.widened())),
        }
    }
}
