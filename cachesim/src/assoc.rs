//! Sets of fixed ways with any replacement policy, with or without sectors.

use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::policy::Replacement;
use crate::sectors::Sectors;
use crate::sets::{Index, SetIndex};
use crate::sink::Sink;
use crate::word::Word;

const EMPTY: u64 = u64::MAX;

/// A set-associative cache with replacement policy `R`.
#[derive(Clone, Debug)]
pub(crate) struct Assoc<R> {
    lines: Vec<u64>,
    states: Vec<SectorState>,
    ways: usize,
    index: SetIndex,
    sectors: Sectors,
    policy: R,
}

/// Which sectors of a line are here, and which of these are dirty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SectorState {
    pub(crate) valid: u32,
    pub(crate) dirty: u32,
}

impl<R: Replacement> Assoc<R> {
    pub(crate) fn new(sets: u64, ways: usize, sectors: Sectors, policy: R) -> Self {
        let lines = sets as usize * ways;
        Self {
            lines: vec![EMPTY; lines],
            states: vec![SectorState::default(); lines],
            ways,
            index: SetIndex::new(sets),
            sectors,
            policy,
        }
    }

    pub(crate) fn run<W: Word>(&mut self, input: &[W], out: Out<'_, W>, rule: WriteRule) -> Tally {
        let mut sink = Sink::new(out);
        for &word in input {
            self.access(word, rule, &mut sink);
        }
        sink.tally
    }

    #[inline]
    fn access<W: Word>(&mut self, word: W, rule: WriteRule, sink: &mut Sink<'_, W>) {
        let (line, sector) = self.sectors.split(word.id());
        let set = self.index.of(line);
        let at = set * self.ways;
        let ways = at..at + self.ways;
        let found = self.lines[ways.clone()].iter().position(|&here| here == line);
        let valid = found.map(|way| self.states[at + way].valid);
        if let Some(way) = found {
            self.policy.touched(set, way);
        }
        let kept = sink.serve(word, valid, sector, rule);
        if kept {
            let way = found.unwrap_or_else(|| {
                let way = match self.lines[ways].iter().position(|&here| here == EMPTY) {
                    Some(way) => way,
                    None => self.policy.victim(set),
                };
                let victim = std::mem::take(&mut self.states[at + way]);
                sink.write_back(self.sectors.dirty(self.lines[at + way], victim));
                self.lines[at + way] = line;
                self.policy.filled(set, way);
                way
            });
            let state = &mut self.states[at + way];
            state.valid |= sector;
            if word.flagged() && !rule.through {
                state.dirty |= sector;
            }
        }
        sink.pass_on(word, kept, rule);
    }

    pub(crate) fn clean<W: Word>(&mut self, out: &mut Vec<W>) {
        for (&line, state) in self.lines.iter().zip(&mut self.states) {
            out.extend(self.sectors.dirty(line, *state).map(|id| W::from_id(id).with_flag(true)));
            state.dirty = 0;
        }
    }
}
