//! Sets in AVX2 registers: 4, 8 or 16 tags of 32 bits.

use std::arch::x86_64::*;

use super::vector::{MaskOrder, SetVector, mixed, reads, up_to};
use super::{Passes, QueueSets};
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::policy::{fifo::Fifo, lru::Lru};
use crate::word::Word;

#[target_feature(enable = "avx2,bmi1")]
unsafe fn reads_avx2<V: SetVector, O: MaskOrder>(
    sets: &mut QueueSets<V::Word>,
    input: &[V::Word],
    out: &mut [V::Word],
) -> usize {
    // SAFETY: the features are enabled here, and the caller vouches for the machine.
    unsafe { reads::<V, O>(sets, input, out) }
}

#[target_feature(enable = "avx2,bmi1")]
unsafe fn mixed_avx2<V: SetVector, O: MaskOrder>(
    sets: &mut QueueSets<V::Word>,
    input: &[V::Word],
    out: Out<'_, V::Word>,
    rule: WriteRule,
) -> Tally {
    // SAFETY: the features are enabled here, and the caller vouches for the machine.
    unsafe { mixed::<V, O>(sets, input, out, rule) }
}

fn passes<V: SetVector>(fifo: bool) -> Passes<V::Word> {
    if fifo {
        Passes { reads: reads_avx2::<V, Fifo>, mixed: mixed_avx2::<V, Fifo> }
    } else {
        Passes { reads: reads_avx2::<V, Lru>, mixed: mixed_avx2::<V, Lru> }
    }
}

pub(super) fn passes_u32(lanes: usize, fifo: bool) -> Option<Passes<u32>> {
    match lanes {
        4 => Some(passes::<U32x4>(fifo)),
        8 => Some(passes::<U32x8>(fifo)),
        16 => Some(passes::<U32x16>(fifo)),
        _ => None,
    }
}

/// Four tags.
#[derive(Clone, Copy)]
pub(super) struct U32x4(__m128i);

/// Eight tags.
#[derive(Clone, Copy)]
struct U32x8(__m256i);

/// Sixteen tags in two registers, the front half first.
#[derive(Clone, Copy)]
struct U32x16(U32x8, U32x8);

/// All ones in the lanes of a mask of four.
///
/// # Safety
/// Needs AVX2.
#[inline(always)]
unsafe fn lanes4(mask: u32) -> __m128i {
    // SAFETY: the caller's promise.
    unsafe {
        let bits = _mm_setr_epi32(1, 2, 4, 8);
        _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(mask as i32), bits), bits)
    }
}

/// All ones in the lanes of a mask of eight.
///
/// # Safety
/// Needs AVX2.
#[inline(always)]
unsafe fn lanes8(mask: u32) -> __m256i {
    // SAFETY: the caller's promise.
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), bits), bits)
    }
}

/// Each lane one up, the last in lane 0.
///
/// # Safety
/// Needs AVX2.
#[inline(always)]
unsafe fn rotated8(lanes: __m256i) -> __m256i {
    // SAFETY: the caller's promise.
    unsafe { _mm256_permutevar8x32_epi32(lanes, _mm256_setr_epi32(7, 0, 1, 2, 3, 4, 5, 6)) }
}

impl SetVector for U32x4 {
    type Word = u32;
    const LANES: usize = 4;

    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm_loadu_si128(from.cast())) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u32) {
        // SAFETY: the trait's contract.
        unsafe { _mm_storeu_si128(to.cast(), self.0) }
    }
    #[inline(always)]
    unsafe fn equal(self, word: u32) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm_cmpeq_epi32(self.0, _mm_set1_epi32(word as i32))).flags() }
    }
    #[inline(always)]
    unsafe fn without_flags(self) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm_and_si128(self.0, _mm_set1_epi32(u32::EMPTY as i32))) }
    }
    #[inline(always)]
    unsafe fn flags(self) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { _mm_movemask_ps(_mm_castsi128_ps(self.0)) as u32 }
    }
    #[inline(always)]
    unsafe fn pushed(self, word: u32, prefix: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe {
            let up = _mm_alignr_epi8::<12>(self.0, _mm_set1_epi32(word as i32));
            Self(_mm_blendv_epi8(self.0, up, lanes4(prefix)))
        }
    }
    /// Without leaving the vector unit, which halves the time from one access of a set to the next.
    #[inline(always)]
    unsafe fn renewed(self, line: u32, last: u32) -> (Self, u32) {
        // SAFETY: the trait's contract.
        unsafe {
            let front = _mm_set1_epi32(line as i32);
            let equal = _mm_cmpeq_epi32(self.0, front);
            let after = _mm_or_si128(_mm_slli_si128::<4>(equal), _mm_slli_si128::<8>(equal));
            let after = _mm_or_si128(after, _mm_slli_si128::<12>(equal));
            let stays = _mm_or_si128(after, lanes4(!up_to(0, last)));
            let up = _mm_alignr_epi8::<12>(self.0, front);
            (Self(_mm_blendv_epi8(up, self.0, stays)), Self(equal).flags())
        }
    }
    #[inline(always)]
    unsafe fn replaced(self, word: u32, mask: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm_blendv_epi8(self.0, _mm_set1_epi32(word as i32), lanes4(mask))) }
    }
}

impl SetVector for U32x8 {
    type Word = u32;
    const LANES: usize = 8;

    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm256_loadu_si256(from.cast())) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u32) {
        // SAFETY: the trait's contract.
        unsafe { _mm256_storeu_si256(to.cast(), self.0) }
    }
    #[inline(always)]
    unsafe fn equal(self, word: u32) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm256_cmpeq_epi32(self.0, _mm256_set1_epi32(word as i32))).flags() }
    }
    #[inline(always)]
    unsafe fn without_flags(self) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm256_and_si256(self.0, _mm256_set1_epi32(u32::EMPTY as i32))) }
    }
    #[inline(always)]
    unsafe fn flags(self) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(self.0)) as u32 }
    }
    #[inline(always)]
    unsafe fn pushed(self, word: u32, prefix: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe {
            let up = _mm256_blend_epi32::<1>(rotated8(self.0), _mm256_set1_epi32(word as i32));
            Self(_mm256_blendv_epi8(self.0, up, lanes8(prefix)))
        }
    }
    #[inline(always)]
    unsafe fn replaced(self, word: u32, mask: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(_mm256_blendv_epi8(self.0, _mm256_set1_epi32(word as i32), lanes8(mask))) }
    }
}

impl SetVector for U32x16 {
    type Word = u32;
    const LANES: usize = 16;

    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        // SAFETY: the trait's contract, which covers both halves.
        unsafe { Self(U32x8::load(from), U32x8::load(from.add(8))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u32) {
        // SAFETY: as in `load`.
        unsafe {
            self.0.store(to);
            self.1.store(to.add(8));
        }
    }
    #[inline(always)]
    unsafe fn equal(self, word: u32) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { self.0.equal(word) | self.1.equal(word) << 8 }
    }
    #[inline(always)]
    unsafe fn without_flags(self) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(self.0.without_flags(), self.1.without_flags()) }
    }
    #[inline(always)]
    unsafe fn flags(self) -> u32 {
        // SAFETY: the trait's contract.
        unsafe { self.0.flags() | self.1.flags() << 8 }
    }
    #[inline(always)]
    unsafe fn pushed(self, word: u32, prefix: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe {
            let (front, back) = (rotated8(self.0.0), rotated8(self.1.0));
            let back = _mm256_blend_epi32::<1>(back, front);
            let front = _mm256_blend_epi32::<1>(front, _mm256_set1_epi32(word as i32));
            Self(
                U32x8(_mm256_blendv_epi8(self.0.0, front, lanes8(prefix))),
                U32x8(_mm256_blendv_epi8(self.1.0, back, lanes8(prefix >> 8))),
            )
        }
    }
    #[inline(always)]
    unsafe fn replaced(self, word: u32, mask: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(self.0.replaced(word, mask), self.1.replaced(word, mask >> 8)) }
    }
}
