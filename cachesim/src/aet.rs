//! Miss ratios of fully associative LRU caches of all sizes from times between touches: the average
//! eviction time model (Hu et al., "Kinetic Modeling of Data Eviction in Cache", USENIX ATC 2016).
//!
//! Time is counted in accesses. Let P(t) be the share of accesses whose line was not touched in the `t`
//! accesses before; first touches are in every P(t). A line that lies in the cache untouched for `t` moves
//! towards eviction at the speed P(t), so the average eviction time T of a cache of `c` lines is where
//! P(0) + P(1) + ... + P(T - 1) = c, and the cache misses P(T) of its accesses. It is exact for one line,
//! and at any size where all lines leave after the same time; where times of eviction vary with the phase
//! of a stream, it gives the miss ratio of their mean.

use std::collections::HashMap;

use crate::address::LineId;
use crate::line_map::LineMap;
use crate::miss_curve::MissCurve;

/// Bins per power of two of reuse times, as a shift: times below `2 << SUB_BINS` have a bin each. As the
/// eviction time grows no slower than the cache, binning moves a point of the curve sideways by less than
/// 1 in `1 << SUB_BINS` of its size in lines.
const SUB_BINS: u32 = 10;
const BINS: usize = ((u64::BITS - SUB_BINS + 1) as usize) << SUB_BINS;

/// Lines on both sides of the first one, together, whose last touches are found without hashing; memory
/// that is not touched costs nothing.
const NEAR: usize = 1 << 24;
/// Neighbouring lines that share one entry of the hash table.
const PAGE: usize = 64;

/// Times of last touches: of lines not touched yet, of those in `long_ago`, and of the first access.
const NEVER: u32 = LineMap::<PAGE>::UNSET;
const LONG_AGO: u32 = NEVER + 1;
const FIRST: u32 = LONG_AGO + 1;
/// What is taken off all times before they overflow.
const EPOCH: u32 = 1 << 31;

/// The times between touches of the same line, of all accesses of a stream: no sampling.
///
/// Takes lines from anywhere, and about twice as long for those that are not among the 2^24 around the first
/// one. It holds 4 bytes for each line near the first one or near to others, and at most 320.
#[derive(Clone, Debug)]
pub struct Aet {
    /// By distance from `near_from`, and by line: time of the last touch.
    near: Vec<u32>,
    near_from: u64,
    far: LineMap<PAGE>,
    long_ago: HashMap<LineId, u64>,
    /// Time of the next access, and accesses before time 0.
    now: u32,
    start: u64,
    /// By bin of the reuse time: accesses.
    reuses: Vec<u64>,
    distinct_lines: u64,
}

impl Default for Aet {
    fn default() -> Self {
        Self::new()
    }
}

impl Aet {
    /// Of no accesses yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            near: Vec::new(),
            near_from: 0,
            far: LineMap::default(),
            long_ago: HashMap::new(),
            now: FIRST,
            start: 0,
            reuses: vec![0; BINS],
            distinct_lines: 0,
        }
    }

    /// Adds one access; [`Extend`] adds many, somewhat faster.
    #[inline]
    pub fn touch(&mut self, line: LineId) {
        self.now = self.touch_at(line, self.now);
    }

    /// Adds an access at the time `now`, and returns that of the next one.
    #[inline(always)]
    fn touch_at(&mut self, line: LineId, now: u32) -> u32 {
        let place = usize::try_from(line.get().wrapping_sub(self.near_from)).unwrap_or(usize::MAX);
        let last = match self.near.get_mut(place) {
            Some(last) => std::mem::replace(last, now),
            None => self.touch_far(line, now),
        };
        if last >= FIRST {
            self.reuses[bin(u64::from(now - last))] += 1;
        } else {
            self.touch_after_long(line, last, now);
        }
        if now == u32::MAX - 1 {
            self.begin_epoch();
            return u32::MAX - EPOCH;
        }
        now + 1
    }

    #[inline(never)]
    fn touch_far(&mut self, line: LineId, now: u32) -> u32 {
        if self.near.is_empty() {
            self.near = vec![NEVER; NEAR];
            self.near_from = line.get().wrapping_sub(NEAR as u64 / 2);
            self.near[NEAR / 2] = now;
            return NEVER;
        }
        std::mem::replace(self.far.of(line), now)
    }

    #[cold]
    fn touch_after_long(&mut self, line: LineId, last: u32, now: u32) {
        if last == NEVER {
            self.distinct_lines += 1;
        } else if let Some(last) = self.long_ago.remove(&line) {
            self.reuses[bin(self.start + u64::from(now) - last)] += 1;
        }
    }

    #[cold]
    fn begin_epoch(&mut self) {
        let near = (0..).map(|place| LineId::new(self.near_from.wrapping_add(place))).zip(&mut self.near);
        for (line, time) in near.chain(self.far.iter_mut()).filter(|(_, time)| **time >= FIRST) {
            if *time < EPOCH + FIRST {
                self.long_ago.insert(line, self.start + u64::from(*time));
                *time = LONG_AGO;
            } else {
                *time -= EPOCH;
            }
        }
        self.start += u64::from(EPOCH);
    }

    fn accesses(&self) -> u64 {
        self.start + u64::from(self.now - FIRST)
    }

    /// The misses by cache size, rounded to whole ones. A cache that holds all distinct lines has cold misses only.
    #[must_use]
    pub fn curve(&self) -> MissCurve {
        let mut misses = vec![self.accesses()];
        let accesses = self.accesses() as f64;
        let (mut lines, mut above) = (0.0, accesses);
        let used = self.reuses.iter().rposition(|&count| count != 0).map_or(0, |last| last + 1);
        'sizes: for (index, &count) in self.reuses[..used].iter().enumerate().skip(1) {
            // The times of a bin are taken as spread evenly over it.
            let (width, count) = (width(index) as f64, count as f64);
            let next = (lines + (width * above - count * (width - 1.0) / 2.0) / accesses, above - count);
            while misses.len() as f64 <= next.0 {
                if misses.len() as u64 >= self.distinct_lines {
                    break 'sizes;
                }
                let part = (misses.len() as f64 - lines) / (next.0 - lines);
                misses.push((above + part * (next.1 - above)).round() as u64);
            }
            (lines, above) = next;
        }
        misses.resize(self.distinct_lines as usize + 1, self.distinct_lines);
        MissCurve::new(misses)
    }
}

impl Extend<LineId> for Aet {
    fn extend<I: IntoIterator<Item = LineId>>(&mut self, lines: I) {
        let mut now = self.now;
        for line in lines {
            now = self.touch_at(line, now);
        }
        self.now = now;
    }
}

/// The bin of a reuse time.
#[inline(always)]
fn bin(time: u64) -> usize {
    let shift = (time >> SUB_BINS | 1).ilog2();
    ((shift as usize) << SUB_BINS) + (time >> shift) as usize
}

/// How many reuse times share a bin.
fn width(bin: usize) -> u64 {
    1 << (bin >> SUB_BINS).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_follow_each_other_without_gaps() {
        let mut time = 0;
        for expected in 0..BINS {
            assert_eq!(bin(time), expected);
            assert_eq!(bin(time + (width(expected) - 1)), expected);
            time = time.wrapping_add(width(expected));
        }
        assert_eq!(time, 0, "all 64-bit times have a bin");
    }

    #[test]
    fn times_are_right_however_many_accesses_lie_between() {
        let mut aet = Aet::new();
        let (mut time, mut touched, mut reuses) = (0, HashMap::new(), vec![0; BINS]);
        for step in 0..60_u64 {
            // Lines around the first one and far from it, back after 1 to 9 ends of epochs or never.
            let line = LineId::new((step % [3, 7, 19][step as usize % 3]) << [0, 30][step as usize % 2]);
            if let Some(last) = touched.insert(line, time) {
                reuses[bin(time - last)] += 1;
            }
            aet.touch(line);
            time += 1;
            if step % 2 == 0 {
                time += u64::from(u32::MAX - 1 - aet.now);
                aet.now = u32::MAX - 1;
            }
        }
        assert!(time > 20 << 31);
        assert_eq!(aet.accesses(), time);
        assert_eq!(aet.reuses, reuses);
        assert_eq!(aet.distinct_lines, touched.len() as u64);
    }
}
