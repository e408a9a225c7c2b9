//! One copy of a cache, whatever its policy: the choice is made here once per pass, and the loops behind
//! it are generic.

use crate::config::LevelConfig;
use crate::counts::MissClasses;
use crate::level::{Tally, WriteRule};
use crate::queue::Queue;
use crate::word::Word;

/// The contents of one cache.
#[derive(Clone, Debug)]
pub(crate) enum Store<W: Word> {
    /// Small sets kept in order of recency or age.
    Queue(Queue<W>),
}

impl<W: Word> Store<W> {
    pub(crate) fn new(config: &LevelConfig, _copy: u32) -> Self {
        Self::Queue(Queue::new(config))
    }

    #[inline]
    pub(crate) fn run(&mut self, input: &[W], out: &mut [W], rule: WriteRule) -> Tally {
        match self {
            Self::Queue(queue) => queue.run(input, out, rule),
        }
    }

    pub(crate) fn clean(&mut self, out: &mut Vec<W>) {
        match self {
            Self::Queue(queue) => queue.clean(out),
        }
    }

    pub(crate) fn classes(&self) -> Option<MissClasses> {
        None
    }

    pub(crate) fn widened(self) -> Store<u64> {
        match self {
            Self::Queue(queue) => Store::Queue(queue.widened()),
        }
    }
}
