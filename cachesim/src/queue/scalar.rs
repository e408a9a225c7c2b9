//! The portable loops, and the reference for the vector ones.

use super::{Passes, QueueSets};
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::sets::Index;
use crate::sink::Sink;
use crate::word::Word;

/// How a queue changes when a line is touched.
pub(crate) trait Order {
    /// Touches `word`'s line and makes it dirty if `word` is flagged.
    fn touch<W: Word>(set: &mut [W], word: W) -> Touch<W>;
}

/// The outcome of a touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Touch<W> {
    /// The line was there.
    Hit,
    /// It was not, and has taken the place of this one, or of [`Word::EMPTY`].
    Evicted(W),
}

pub(super) fn passes<W: Word, O: Order>() -> Passes<W> {
    Passes { reads: reads::<W, O>, mixed: mixed::<W, O> }
}

fn reads<W: Word, O: Order>(sets: &mut QueueSets<W>, input: &[W], out: &mut [W]) -> usize {
    let mut sent = 0;
    for &word in input {
        if let Touch::Evicted(_) = O::touch(sets.set_of(word), word) {
            out[sent] = word;
            sent += 1;
        }
    }
    sent
}

fn mixed<W: Word, O: Order>(sets: &mut QueueSets<W>, input: &[W], out: Out<'_, W>, rule: WriteRule) -> Tally {
    let mut sink = Sink::new(out);
    for &word in input {
        let line = word.without_flag();
        let set = sets.set_of(line);
        let around = word.flagged() && !rule.allocate && set.iter().all(|tag| tag.without_flag() != line);
        let touch = (!around).then(|| O::touch(set, line.with_flag(word.flagged() && !rule.through)));
        let kept = sink.serve(word, (touch == Some(Touch::Hit)).then_some(1), 1, rule);
        if let Some(Touch::Evicted(victim)) = touch
            && victim.flagged()
        {
            sink.write_back(std::iter::once(victim.id()));
        }
        sink.pass_on(word, kept, rule);
    }
    sink.tally
}

impl<W: Word> QueueSets<W> {
    #[inline(always)]
    fn set_of(&mut self, line: W) -> &mut [W] {
        let at = self.index.of(line) * self.lanes;
        &mut self.tags.as_mut_slice()[at..at + self.ways]
    }
}
