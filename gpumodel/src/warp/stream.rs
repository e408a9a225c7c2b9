//! What a tile's warps ask of the caches, packed into words: for each load or store a header, then its lines.

use crate::counters::{IssueCounters, Pass};
use crate::layout::BufferKind;
use std::ops::Range;
use std::sync::Arc;

/// Which of a warp's streams a turn is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Share {
    /// Reads nodes or uses a stack: variants of a frame can have this stream in common.
    Tree,
    /// All else.
    Own,
}

/// All that a tile's warps ask of the caches.
#[derive(Clone, Debug)]
pub(crate) struct TileStreams {
    /// Empty where the turns on the tree are in `own`.
    pub(crate) tree: Arc<TileStream>,
    pub(crate) own: Arc<TileStream>,
}

impl TileStreams {
    /// With all turns in one stream.
    pub(crate) fn joined(own: TileStream) -> Self {
        Self { tree: Arc::default(), own: Arc::new(own) }
    }

    pub(crate) fn warps(&self) -> usize {
        self.own.warp_ends.len()
    }
}

/// The streams of a tile's warps, and what the warps issued.
#[derive(Debug, Default)]
pub(crate) struct TileStream {
    /// At the end follow [`PADDING`] words that mean nothing, so that lines can be read by fours.
    pub(crate) words: Vec<u32>,
    /// Where each warp's words end.
    pub(crate) warp_ends: Vec<usize>,
    /// What each turn costs, warp after warp; empty unless the program keeps them.
    pub(crate) turns: Vec<Turn>,
    /// Where each warp's turns end.
    pub(crate) turn_ends: Vec<usize>,
    /// By [`Pass`].
    pub(crate) issue: [IssueCounters; Pass::COUNT],
}

/// Words at the end of a stream.
pub(crate) const PADDING: usize = 4;

/// What a warp does between two waits: it computes, then issues loads and stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Turn {
    /// Instructions of the warp on the ALU.
    pub(crate) alu: u32,
    /// Instructions of the warp on the elementary function unit.
    pub(crate) efu: u32,
    /// Cycles of the load/store port.
    pub(crate) port_cycles: u32,
    /// Bytes that the warp sends to DRAM past the caches: its pixels of tile memory.
    pub(crate) output_bytes: u32,
    /// Runs of the stream that belong to it.
    pub(crate) runs: u16,
    /// The next turn needs what was loaded.
    pub(crate) waits: bool,
}

/// One load or store of a warp, or several that touch the same lines in the same order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run(u32);

impl Run {
    const LINES: u32 = 0x7F;
    const REPEAT_SHIFT: u32 = 7;
    const REPEATS: u32 = 0x1F;
    const KEY_SHIFT: u32 = 12;
    /// Kinds that are written: their classes are the last ones, those of reads the numbers of the kinds.
    const WRITTEN: [BufferKind; 3] = [BufferKind::Stack, BufferKind::Image, BufferKind::Record];
    const FIRST_WRITTEN: u32 = BufferKind::ALL.len() as u32;
    /// Classes of each pass.
    const CLASSES: u32 = Self::FIRST_WRITTEN + Self::WRITTEN.len() as u32;
    const LAST: u32 = 1 << 20;
    pub(super) const CROSSES: u32 = 1 << 21;
    pub(super) const BEGINS: u32 = 1 << 22;
    const PORT_SHIFT: u32 = 23;
    const PORT_CYCLES: u32 = 0x1FF;
    /// Values of [`Self::key`] are below this.
    pub(crate) const KEYS: usize = 256;

    /// `lines` is at most the lanes of a warp, `repeats` the loads that touch them.
    #[inline(always)]
    pub(crate) fn new(pass: Pass, kind: BufferKind, write: bool, lines: usize, repeats: u32) -> Self {
        debug_assert!(lines <= Self::LINES as usize && repeats <= Self::REPEATS);
        Self(
            lines as u32
                | repeats << Self::REPEAT_SHIFT
                | (pass as u32 * Self::CLASSES + Self::class(kind, write)) << Self::KEY_SHIFT,
        )
    }

    /// Buffer and direction as one small number.
    #[inline(always)]
    fn class(kind: BufferKind, write: bool) -> u32 {
        match (kind, write) {
            (kind, false) => kind as u32,
            (BufferKind::Stack, true) => Self::FIRST_WRITTEN,
            (BufferKind::Image, true) => Self::FIRST_WRITTEN + 1,
            (BufferKind::Record, true) => Self::FIRST_WRITTEN + 2,
            (_, true) => unreachable!("no warp writes {kind:?}"),
        }
    }

    /// Each of its loads or stores takes the port so many cycles; from 511 on they are not told apart.
    #[inline(always)]
    pub(crate) fn with_port_cycles(self, cycles: u32) -> Self {
        Self(self.0 | cycles.min(Self::PORT_CYCLES) << Self::PORT_SHIFT)
    }

    /// Cycles of the load/store port, or of what takes its place for textures and for a ray unit, repeats included.
    #[inline(always)]
    pub(crate) fn port_cycles(self) -> u32 {
        (self.0 >> Self::PORT_SHIFT) * self.repeats()
    }

    #[inline(always)]
    pub(crate) fn from_word(word: u32) -> Self {
        Self(word)
    }

    /// After this run the warp issues nothing until its turn comes again.
    #[inline(always)]
    pub(crate) fn is_last(self) -> bool {
        self.0 & Self::LAST != 0
    }

    /// The last of its turn, and the next turn is in the warp's other stream.
    #[inline(always)]
    pub(crate) fn crosses(self) -> bool {
        self.0 & Self::CROSSES != 0
    }

    /// The warp begins with it, though there is another stream.
    #[inline(always)]
    pub(crate) fn begins(self) -> bool {
        self.0 & Self::BEGINS != 0
    }

    #[inline(always)]
    pub(crate) fn lines(self) -> usize {
        (self.0 & Self::LINES) as usize
    }

    #[inline(always)]
    pub(crate) fn repeats(self) -> u32 {
        self.0 >> Self::REPEAT_SHIFT & Self::REPEATS
    }

    /// Buffer, pass and direction as one small number.
    #[inline(always)]
    pub(crate) fn key(self) -> usize {
        (self.0 >> Self::KEY_SHIFT) as usize % Self::KEYS
    }

    /// What a key stands for; `None` for a number that no run has.
    pub(crate) fn of_key(key: usize) -> Option<(Pass, BufferKind, bool)> {
        let classes = Self::CLASSES as usize;
        let class = key % classes;
        let pass = Pass::ALL.get(key / classes)?;
        let written = class.checked_sub(Self::FIRST_WRITTEN as usize);
        let kind = match written {
            Some(place) => Self::WRITTEN.get(place)?,
            None => BufferKind::ALL.get(class)?,
        };
        Some((*pass, *kind, written.is_some()))
    }
}

impl TileStream {
    /// The words of warp `index`; none in an empty stream.
    pub(crate) fn warp(&self, index: usize) -> Range<usize> {
        let start = if index == 0 { 0 } else { self.warp_ends.get(index - 1).copied().unwrap_or(0) };
        start..self.warp_ends.get(index).copied().unwrap_or(start)
    }

    /// The turns of warp `index`.
    pub(crate) fn turns(&self, index: usize) -> Range<usize> {
        let start = if index == 0 { 0 } else { self.turn_ends[index - 1] };
        start..self.turn_ends[index]
    }

    /// All loads and stores, with their lines.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (Run, &[u32])> {
        let mut words = &self.words[..self.words.len().saturating_sub(PADDING)];
        std::iter::from_fn(move || {
            let (&word, rest) = words.split_first()?;
            let run = Run::from_word(word);
            let (lines, rest) = rest.split_at(run.lines());
            words = rest;
            Some((run, lines))
        })
    }

    /// The words of a warp, with padding behind them.
    pub(crate) fn padded(&self, warp: Range<usize>) -> &[u32] {
        &self.words[warp.start..warp.end + PADDING]
    }
}

/// Writes the words of a tile; its memory is kept for the next.
pub(crate) struct StreamWriter {
    /// Beyond `used` there is always room for one more run.
    words: Vec<u32>,
    used: usize,
    last_run: usize,
}

impl Default for StreamWriter {
    fn default() -> Self {
        Self { words: vec![0; Self::RUN_WORDS], used: 0, last_run: 0 }
    }
}

impl StreamWriter {
    const RUN_WORDS: usize = 1 + 64;

    /// Words written since [`Self::take`].
    pub(crate) fn len(&self) -> usize {
        self.used
    }

    /// Room for the lines of the next run.
    #[inline(always)]
    pub(crate) fn lines(&mut self) -> &mut [u32; 64] {
        self.words[self.used + 1..].first_chunk_mut().expect("there is room for one more run")
    }

    /// Ends the run whose lines have been put into [`Self::lines`].
    #[inline(always)]
    pub(crate) fn push(&mut self, run: Run) {
        self.last_run = self.used;
        self.words[self.used] = run.0;
        self.used += 1 + run.lines();
        if self.words.len() - self.used < Self::RUN_WORDS {
            self.words.resize(2 * self.words.len() + Self::RUN_WORDS, 0);
        }
    }

    /// Ends a turn with the latest run.
    #[inline(always)]
    pub(crate) fn end_turn(&mut self) {
        self.words[self.last_run] |= Run::LAST;
    }

    /// The turn after the latest run is in the warp's other stream.
    pub(crate) fn cross(&mut self) {
        self.words[self.last_run] |= Run::CROSSES;
    }

    /// The warp whose words begin at `start` begins with these.
    pub(crate) fn begin(&mut self, start: usize) {
        self.words[start] |= Run::BEGINS;
    }

    /// What has been written; the next tile begins.
    pub(crate) fn take(&mut self) -> Vec<u32> {
        let words = self.words[..self.used + PADDING].to_vec();
        self.used = 0;
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_tells_pass_buffer_and_direction_and_leaves_the_rest_of_the_word_alone() {
        assert!(BufferKind::ALL.len() <= Run::FIRST_WRITTEN as usize);
        let mut keys = Vec::new();
        for pass in Pass::ALL {
            let reads = BufferKind::ALL.map(|kind| (kind, false));
            for (kind, write) in reads.into_iter().chain(Run::WRITTEN.map(|kind| (kind, true))) {
                let run = Run::new(pass, kind, write, 64, 31).with_port_cycles(511);
                assert_eq!(Run::of_key(run.key()), Some((pass, kind, write)));
                assert_eq!((run.lines(), run.repeats(), run.port_cycles()), (64, 31, 31 * 511));
                assert!(!run.is_last() && !run.crosses() && !run.begins());
                keys.push(run.key());
            }
        }
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
        let known = (0..Run::KEYS).filter(|&key| Run::of_key(key).is_some()).count();
        assert_eq!(known, count, "numbers of no run stand for nothing");
    }
}
