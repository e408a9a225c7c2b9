//! Fully associative caches of any size, LRU or FIFO, in constant time per access.

use crate::address::LineId;
use crate::assoc::SectorState;
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::recency::RecencyList;
use crate::sectors::Sectors;
use crate::sink::Sink;
use crate::word::Word;

/// One set of all lines.
#[derive(Clone, Debug)]
pub(crate) struct FullyAssociative {
    list: RecencyList,
    /// By dense number.
    lines: Vec<u64>,
    states: Vec<SectorState>,
    sectors: Sectors,
    fifo: bool,
}

impl FullyAssociative {
    pub(crate) fn new(lines: u64, sectors: Sectors, fifo: bool) -> Self {
        Self { list: RecencyList::new(lines), lines: Vec::new(), states: Vec::new(), sectors, fifo }
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
        let (id, first) = self.list.number(LineId::new(line));
        if first {
            self.lines.push(line);
            self.states.push(SectorState::default());
        }
        let here = self.list.contains(id);
        if here && !self.fifo {
            self.list.renew(id);
        }
        let kept = sink.serve(word, here.then(|| self.states[id as usize].valid), sector, rule);
        if kept {
            if !here && let Some(evicted) = self.list.insert(id) {
                let victim = std::mem::take(&mut self.states[evicted as usize]);
                sink.write_back(self.sectors.dirty(self.lines[evicted as usize], victim));
            }
            let state = &mut self.states[id as usize];
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
