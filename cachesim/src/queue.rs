//! Sets kept as queues: the most recently used (LRU) or newest (FIFO) line first, empty ways last, so that
//! the order of the tags is all the state there is. A dirty line has the flag of its tag set.

use crate::config::{LevelConfig, Policy};
use crate::level::{Tally, WriteRule};
use crate::policy::{fifo::Fifo, lru::Lru};
use crate::sets::SetIndex;
use crate::sink::Sink;
use crate::word::Word;

/// The most ways of a queue.
pub(crate) const MAX_QUEUE_WAYS: u64 = 16;

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

/// A set-associative cache whose sets are queues.
#[derive(Clone, Debug)]
pub(crate) struct Queue<W> {
    tags: Vec<W>,
    ways: usize,
    index: SetIndex,
    fifo: bool,
}

impl<W: Word> Queue<W> {
    pub(crate) fn new(config: &LevelConfig) -> Self {
        let ways = config.way_count() as usize;
        Self {
            tags: vec![W::EMPTY; config.lines() as usize],
            ways,
            index: SetIndex::new(config.sets()),
            fifo: config.policy == Policy::Fifo,
        }
    }

    pub(crate) fn run(&mut self, input: &[W], out: &mut [W], rule: WriteRule) -> Tally {
        if self.fifo { self.pass::<Fifo>(input, out, rule) } else { self.pass::<Lru>(input, out, rule) }
    }

    fn pass<O: Order>(&mut self, input: &[W], out: &mut [W], rule: WriteRule) -> Tally {
        let mut sink = Sink::new(out);
        for &word in input {
            let line = word.without_flag();
            let at = self.index.set_of(line.id()) * self.ways;
            let set = &mut self.tags[at..at + self.ways];
            let around = word.flagged() && !rule.allocate && set.iter().all(|tag| tag.without_flag() != line);
            let touch = if around {
                None
            } else {
                Some(O::touch(set, line.with_flag(word.flagged() && !rule.through)))
            };
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

    pub(crate) fn clean(&mut self, out: &mut Vec<W>) {
        for tag in &mut self.tags {
            if tag.flagged() {
                out.push(*tag);
                *tag = tag.without_flag();
            }
        }
    }

    pub(crate) fn widened(self) -> Queue<u64> {
        let widen = |tag: W| {
            if tag == W::EMPTY { u64::EMPTY } else { u64::from_id(tag.id()).with_flag(tag.flagged()) }
        };
        let Self { tags, ways, index, fifo } = self;
        Queue { tags: tags.into_iter().map(widen).collect(), ways, index, fifo }
    }
}
