//! Misses by cause: cold, capacity, conflict (Hill and Smith 1989).

use crate::address::LineId;
use crate::config::LevelConfig;
use crate::counts::MissClasses;
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::recency::RecencyList;
use crate::sectors::Sectors;
use crate::store::Store;
use crate::word::Word;

/// A cache beside a fully associative LRU cache of as many lines that sees the same accesses.
#[derive(Clone, Debug)]
pub(crate) struct Classified<W: Word> {
    store: Store<W>,
    shadow: RecencyList,
    sectors: Sectors,
    classes: MissClasses,
}

impl<W: Word> Classified<W> {
    pub(crate) fn new(store: Store<W>, config: &LevelConfig) -> Self {
        Self {
            store,
            shadow: RecencyList::new(config.lines()),
            sectors: Sectors::of(config),
            classes: MissClasses::default(),
        }
    }

    pub(crate) fn run(&mut self, input: &[W], mut out: Out<'_, W>, rule: WriteRule) -> Tally {
        let mut total = Tally::default();
        for (position, word) in (0..).zip(input) {
            let (sent, misses) = (total.sent, total.misses as usize);
            let tally = self.store.run(std::slice::from_ref(word), out.after(sent, misses), rule);
            out.causes[sent..sent + tally.sent].fill(position);
            out.missed[misses..misses + tally.misses as usize].fill(position);
            let (line, _) = self.sectors.split(word.id());
            let allocate = rule.allocate || !word.flagged();
            self.observe(LineId::new(line), tally.misses > tally.sector_misses, allocate);
            total.add(tally);
        }
        total
    }

    fn observe(&mut self, line: LineId, missed: bool, allocate: bool) {
        let (id, first) = self.shadow.number(line);
        let shadow_missed = !self.shadow.contains(id);
        if missed {
            let MissClasses { cold, capacity, conflict } = &mut self.classes;
            *match (first, shadow_missed) {
                (true, _) => cold,
                (false, true) => capacity,
                (false, false) => conflict,
            } += 1;
        }
        if !shadow_missed {
            self.shadow.renew(id);
        } else if allocate {
            self.shadow.insert(id);
        }
    }

    pub(crate) fn classes(&self) -> MissClasses {
        self.classes
    }

    pub(crate) fn clean(&mut self, out: &mut Vec<W>) {
        self.store.clean(out);
    }

    pub(crate) fn widened(self) -> Classified<u64> {
        let Self { store, shadow, sectors, classes } = self;
        Classified { store: store.widened(), shadow, sectors, classes }
    }
}
