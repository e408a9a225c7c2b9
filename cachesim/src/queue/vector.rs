//! The vector loops, generic over the register that holds a set and over the policy.

use super::QueueSets;
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::sets::{Index, SetIndex};
use crate::word::Word;

/// A set in registers, lane 0 the front of the queue. Masks have bit `i` for lane `i`.
///
/// # Safety
/// All functions need the instruction set of the implementing type; [`Self::load`] and [`Self::store`]
/// also `LANES` words at the pointer.
pub(crate) trait SetVector: Copy {
    type Word: Word;
    const LANES: usize;

    unsafe fn load(from: *const Self::Word) -> Self;
    unsafe fn store(self, to: *mut Self::Word);
    /// The lanes equal to `word`, flag and all.
    unsafe fn equal(self, word: Self::Word) -> u32;
    /// The lanes without their flags.
    unsafe fn without_flags(self) -> Self;
    /// The flagged lanes.
    unsafe fn flags(self) -> u32;
    /// Moves the lanes of `prefix`, lanes 0 to n for some n, one up and `word` into lane 0; the content of
    /// lane n is lost. Nothing moves if `prefix` is 0.
    unsafe fn pushed(self, word: Self::Word, prefix: u32) -> Self;
    /// Moves `line` to lane 0, from where it is or from outside, and what is before it, or else everything
    /// up to lane `last`, one up. Answers the lane where it was, as a bit, or 0.
    #[inline(always)]
    unsafe fn renewed(self, line: Self::Word, last: u32) -> (Self, u32) {
        // SAFETY: passed on.
        unsafe {
            let hit = self.equal(line);
            (self.pushed(line, up_to(hit, last)), hit)
        }
    }
    /// Puts `word` into the lanes of `mask`.
    unsafe fn replaced(self, word: Self::Word, mask: u32) -> Self;
}

/// A queue's order in terms of masks. `hit` is the lane of the hit as a bit, or 0; `last` the last way's.
pub(crate) trait MaskOrder {
    /// Touches `line`: the set afterwards, and the lane of the hit.
    ///
    /// # Safety
    /// As all of [`SetVector`].
    #[inline(always)]
    unsafe fn read<V: SetVector>(set: V, line: V::Word, last: u32) -> (V, u32) {
        // SAFETY: passed on.
        unsafe {
            let hit = set.equal(line);
            (set.pushed(line, Self::moved(hit, last)), hit)
        }
    }
    /// The lanes that move up by one.
    fn moved(hit: u32, last: u32) -> u32;
    /// Where the line is afterwards.
    fn place(hit: u32) -> u32;
}

/// All bits up to the lowest of `hit`, or else up to `last`.
#[inline(always)]
pub(crate) fn up_to(hit: u32, last: u32) -> u32 {
    let end = hit | last;
    end ^ (end - 1)
}

/// See [`super::Passes`].
///
/// # Safety
/// The machine must have `V`'s instruction set, and the caller its features enabled.
#[inline(always)]
pub(super) unsafe fn reads<V: SetVector, O: MaskOrder>(
    sets: &mut QueueSets<V::Word>,
    input: &[V::Word],
    out: &mut [V::Word],
) -> usize {
    // SAFETY: passed on.
    unsafe {
        match sets.index {
            SetIndex::Mask(index) => reads_by::<V, O, _>(sets, index, input, out),
            SetIndex::Modulo(index) => reads_by::<V, O, _>(sets, index, input, out),
        }
    }
}

/// # Safety
/// As [`reads`].
#[inline(always)]
unsafe fn reads_by<V: SetVector, O: MaskOrder, I: Index>(
    sets: &mut QueueSets<V::Word>,
    index: I,
    input: &[V::Word],
    out: &mut [V::Word],
) -> usize {
    let tags = sets.tags.as_mut_slice();
    assert!(sets.lanes == V::LANES && tags.len() >= index.sets() * V::LANES && out.len() >= input.len());
    let last = 1_u32 << (sets.ways - 1);
    let (tags, out) = (tags.as_mut_ptr(), out.as_mut_ptr());
    let mut sent = 0;
    for &line in input {
        // SAFETY: `index.of` is below `index.sets()`, so the whole set lies in `tags`; `sent` grows by at
        // most one per input word and so stays below `out.len()`. Features are the caller's promise.
        unsafe {
            let at = tags.add(index.of(line) * V::LANES);
            let set = V::load(at);
            let (set, hit) = O::read(set, line, last);
            set.store(at);
            *out.add(sent) = line;
            sent += usize::from(hit == 0);
        }
    }
    sent
}

/// See [`super::Passes`].
///
/// # Safety
/// As [`reads`].
#[inline(always)]
pub(super) unsafe fn mixed<V: SetVector, O: MaskOrder>(
    sets: &mut QueueSets<V::Word>,
    input: &[V::Word],
    out: Out<'_, V::Word>,
    rule: WriteRule,
) -> Tally {
    // SAFETY: passed on.
    unsafe {
        match sets.index {
            SetIndex::Mask(index) => mixed_by::<V, O, _>(sets, index, input, out, rule),
            SetIndex::Modulo(index) => mixed_by::<V, O, _>(sets, index, input, out, rule),
        }
    }
}

/// # Safety
/// As [`reads`].
#[inline(always)]
unsafe fn mixed_by<V: SetVector, O: MaskOrder, I: Index>(
    sets: &mut QueueSets<V::Word>,
    index: I,
    input: &[V::Word],
    out: Out<'_, V::Word>,
    rule: WriteRule,
) -> Tally {
    let tags = sets.tags.as_mut_slice();
    let (most, ways) = (2 * input.len(), index.sets() * V::LANES);
    let Out { words, causes, missed, traced: _ } = out;
    let room = words.len() >= most && causes.len() >= most && missed.len() >= input.len();
    assert!(sets.lanes == V::LANES && tags.len() >= ways && room);
    let last = 1_u32 << (sets.ways - 1);
    let tags = tags.as_mut_ptr();
    let mut tally = Tally::default();
    let mut sent = 0;
    for (position, &word) in (0_u32..).zip(input) {
        let (line, write) = (word.without_flag(), word.flagged());
        // SAFETY: as in `reads_by`; features are the caller's promise.
        let (at, set) = unsafe {
            let at = tags.add(index.of(line) * V::LANES);
            (at, V::load(at))
        };
        // SAFETY: features, and `at` has a whole set.
        let (flags, hit) = unsafe { (set.flags(), set.without_flags().equal(line)) };
        let front = line.with_flag((flags & hit != 0) | (write & !rule.through));
        // Most accesses hit: a branch that is nearly always foretold costs less than doing both.
        if hit != 0 {
            // SAFETY: as above.
            unsafe {
                set.pushed(front, O::moved(hit, last)).replaced(front, O::place(hit)).store(at);
            }
            if write & rule.through {
                words[sent] = word;
                causes[sent] = position;
                sent += 1;
            }
            continue;
        }
        let kept = !write | rule.allocate;
        let fetches = kept & (!write | rule.fetch);
        let evicts_dirty = kept & (flags & last != 0);
        let passes_on = write & (rule.through | !kept);
        missed[tally.misses as usize] = position;
        tally.misses += 1;
        tally.write_misses += u64::from(write);
        tally.fills += u64::from(fetches);
        tally.writebacks += u64::from(evicts_dirty);
        // A level that writes through has no dirty victim, and a write that goes around has none and fetches nothing:
        // two words at most.
        if fetches {
            words[sent] = line;
            causes[sent] = position;
            sent += 1;
        }
        if evicts_dirty | passes_on {
            // SAFETY: the last way lies in the set at `at`.
            let victim = unsafe { *at.add(sets.ways - 1) };
            words[sent] = if evicts_dirty { victim } else { word };
            causes[sent] = position;
            sent += 1;
        }
        if kept {
            // SAFETY: as above.
            unsafe {
                set.pushed(front, O::moved(0, last)).replaced(front, O::place(0)).store(at);
            }
        }
    }
    tally.sent = sent;
    tally
}
