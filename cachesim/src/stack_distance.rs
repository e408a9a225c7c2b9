//! Stack distances, and from them the misses of a fully associative LRU cache of every size at once
//! (Mattson et al. 1970).
//!
//! The distance of an access is the number of distinct other lines touched since its line was last
//! touched; a cache of `n` lines hits exactly the accesses with a distance below `n`. Time is a bitmap
//! with a bit at the last touch of each line (Bennett and Kruskal 1975), so a distance is the number of
//! bits after a point. Counts of bits per 512, 32 Ki and 2 Mi positions make that a few short sums. When
//! the bitmap is full, the bits are moved together at its start.

use crate::address::LineId;
use crate::dense::DenseIds;
use crate::miss_curve::MissCurve;

/// Bits per word, words per group, and counts per group of the next coarser level, as shifts.
const WORD: u32 = 6;
const GROUP: u32 = 9;
const COUNTS: u32 = 6;
const LEVELS: usize = 3;

/// The stack distances of an access stream, exact.
#[derive(Clone, Debug)]
pub struct StackDistances {
    ids: DenseIds,
    /// By line: position of its last touch.
    last: Vec<u32>,
    /// By position: the line touched; meaningful where the bit is set.
    owner: Vec<u32>,
    words: Vec<u64>,
    /// Bits per `1 << (GROUP + level * COUNTS)` positions.
    counts: [Vec<u32>; LEVELS],
    now: usize,
    /// By distance: accesses.
    histogram: Vec<u64>,
}

impl Default for StackDistances {
    fn default() -> Self {
        Self::new()
    }
}

impl StackDistances {
    /// Of no accesses yet.
    #[must_use]
    pub fn new() -> Self {
        let mut new = Self {
            ids: DenseIds::new(),
            last: Vec::new(),
            owner: Vec::new(),
            words: Vec::new(),
            counts: Default::default(),
            now: 0,
            histogram: Vec::new(),
        };
        new.make_room(1 << 16);
        new
    }

    /// Adds one access.
    #[inline]
    pub fn touch(&mut self, line: LineId) {
        if self.now == self.owner.len() {
            self.compact();
        }
        let now = self.now;
        let id = self.ids.number(line);
        if id as usize == self.last.len() {
            self.last.push(now as u32);
            self.histogram.push(0);
            for (level, counts) in self.counts.iter_mut().enumerate() {
                counts[now >> (GROUP + level as u32 * COUNTS)] += 1;
            }
        } else {
            let before = std::mem::replace(&mut self.last[id as usize], now as u32) as usize;
            let distance = self.bits_after(before);
            self.histogram[distance] += 1;
            self.words[before >> WORD] &= !(1 << (before & 63));
            for (level, counts) in self.counts.iter_mut().enumerate() {
                let shift = GROUP + level as u32 * COUNTS;
                let (from, to) = (before >> shift, now >> shift);
                if from == to {
                    break;
                }
                counts[from] -= 1;
                counts[to] += 1;
            }
        }
        self.owner[now] = id;
        self.words[now >> WORD] |= 1 << (now & 63);
        self.now += 1;
    }

    /// Set bits at positions after `position`.
    #[inline(always)]
    fn bits_after(&self, position: usize) -> usize {
        let word = position >> WORD;
        let last_word = (self.now - 1) >> WORD;
        let mut bits = (self.words[word] >> (position & 63) >> 1).count_ones();
        let group_end = (word | ((1 << (GROUP - WORD)) - 1)).min(last_word);
        bits += self.words[word + 1..=group_end].iter().map(|word| word.count_ones()).sum::<u32>();
        let (mut group, mut last_group) = (position >> GROUP, (self.now - 1) >> GROUP);
        for (level, counts) in self.counts.iter().enumerate() {
            let siblings = if level + 1 == LEVELS { last_group } else { group | ((1 << COUNTS) - 1) };
            bits += counts[group + 1..=siblings.min(last_group)].iter().sum::<u32>();
            group >>= COUNTS;
            last_group >>= COUNTS;
            if group == last_group {
                break;
            }
        }
        bits as usize
    }

    /// Moves the bits together at the start, in order, in a bitmap at most half full.
    #[cold]
    fn compact(&mut self) {
        let old = std::mem::take(&mut self.owner);
        let words = std::mem::take(&mut self.words);
        let mut order = Vec::with_capacity(self.last.len());
        for (index, &word) in words.iter().enumerate() {
            let mut word = word;
            while word != 0 {
                order.push(old[index << WORD | word.trailing_zeros() as usize]);
                word &= word - 1;
            }
        }
        self.make_room((order.len() * 2).next_power_of_two().max(old.len()));
        for (position, &id) in order.iter().enumerate() {
            self.last[id as usize] = position as u32;
            self.owner[position] = id;
            self.words[position >> WORD] |= 1 << (position & 63);
            for (level, counts) in self.counts.iter_mut().enumerate() {
                counts[position >> (GROUP + level as u32 * COUNTS)] += 1;
            }
        }
        self.now = order.len();
    }

    fn make_room(&mut self, positions: usize) {
        self.owner = vec![0; positions];
        self.words = vec![0; positions >> WORD];
        for (level, counts) in self.counts.iter_mut().enumerate() {
            *counts = vec![0; (positions >> (GROUP + level as u32 * COUNTS)) + 1];
        }
    }

    /// The misses by cache size, exact.
    #[must_use]
    pub fn curve(&self) -> MissCurve {
        let mut misses = self.last.len() as u64 + self.histogram.iter().sum::<u64>();
        let mut all = vec![misses];
        all.extend(self.histogram.iter().map(|hits| {
            misses -= hits;
            misses
        }));
        MissCurve::new(all)
    }
}
