//! Sets in AVX-512 registers: 4, 8 or 16 tags of 32 or 64 bits.

use std::arch::x86_64::*;

use super::avx2::U32x4;
use super::vector::{MaskOrder, SetVector, mixed, reads};
use super::{Passes, QueueSets};
use crate::level::{Tally, WriteRule};
use crate::out::Out;
use crate::policy::{fifo::Fifo, lru::Lru};
use crate::word::Word;

#[target_feature(enable = "avx512f,avx512dq,avx512vl,bmi1")]
unsafe fn reads_avx512<V: SetVector, O: MaskOrder>(
    sets: &mut QueueSets<V::Word>,
    input: &[V::Word],
    out: &mut [V::Word],
) -> usize {
    // SAFETY: the features are enabled here, and the caller vouches for the machine.
    unsafe { reads::<V, O>(sets, input, out) }
}

#[target_feature(enable = "avx512f,avx512dq,avx512vl,bmi1")]
unsafe fn mixed_avx512<V: SetVector, O: MaskOrder>(
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
        Passes { reads: reads_avx512::<V, Fifo>, mixed: mixed_avx512::<V, Fifo> }
    } else {
        Passes { reads: reads_avx512::<V, Lru>, mixed: mixed_avx512::<V, Lru> }
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

pub(super) fn passes_u64(lanes: usize, fifo: bool) -> Option<Passes<u64>> {
    match lanes {
        4 => Some(passes::<U64x4>(fifo)),
        8 => Some(passes::<U64x8>(fifo)),
        16 => Some(passes::<U64x16>(fifo)),
        _ => None,
    }
}

/// One register of tags. All its functions are one to three instructions.
macro_rules! register {
    ($name:ident, $word:ty, $lanes:literal, $mask:ty, $inner:ty, load $load:ident, store $store:ident,
     splat $splat:ident($signed:ty), equal $equal:ident, and $and:ident, flags $flags:ident,
     align $align:ident/$mask_align:ident, blend $blend:ident, differ $differ:ident, compress $compress:ident) => {
        #[derive(Clone, Copy)]
        struct $name($inner);

        impl SetVector for $name {
            type Word = $word;
            const LANES: usize = $lanes;

            #[inline(always)]
            unsafe fn load(from: *const $word) -> Self {
                // SAFETY: the trait's contract.
                unsafe { Self($load(from.cast())) }
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $word) {
                // SAFETY: the trait's contract.
                unsafe { $store(to.cast(), self.0) }
            }
            #[inline(always)]
            unsafe fn equal(self, word: $word) -> u32 {
                // SAFETY: the trait's contract.
                unsafe { u32::from($equal(self.0, $splat(word as $signed))) }
            }
            #[inline(always)]
            unsafe fn without_flags(self) -> Self {
                // SAFETY: the trait's contract.
                unsafe { Self($and(self.0, $splat(<$word>::EMPTY as $signed))) }
            }
            #[inline(always)]
            unsafe fn flags(self) -> u32 {
                // SAFETY: the trait's contract.
                unsafe { u32::from($flags(self.0)) }
            }
            #[inline(always)]
            unsafe fn pushed(self, word: $word, prefix: u32) -> Self {
                // SAFETY: the trait's contract.
                unsafe {
                    let up = $align::<{ $lanes - 1 }>(self.0, $splat(word as $signed));
                    Self($blend(self.0, prefix as $mask, up))
                }
            }
            #[inline(always)]
            unsafe fn renewed(self, line: $word, last: u32) -> (Self, u32) {
                // SAFETY: the trait's contract.
                unsafe {
                    let front = $splat(line as $signed);
                    let others = $differ(self.0, front);
                    let packed = $compress(others, self.0);
                    let empty = $splat(<$word>::EMPTY as $signed);
                    let ways = (2 * last - 1) as $mask;
                    (
                        Self($mask_align::<{ $lanes - 1 }>(empty, ways, packed, front)),
                        u32::from(!others & ways),
                    )
                }
            }
            #[inline(always)]
            unsafe fn replaced(self, word: $word, mask: u32) -> Self {
                // SAFETY: the trait's contract.
                unsafe { Self($blend(self.0, mask as $mask, $splat(word as $signed))) }
            }
        }
    };
}

register!(U32x8, u32, 8, u8, __m256i, load _mm256_loadu_si256, store _mm256_storeu_si256,
    splat _mm256_set1_epi32(i32), equal _mm256_cmpeq_epi32_mask, and _mm256_and_si256, flags _mm256_movepi32_mask,
    align _mm256_alignr_epi32/_mm256_mask_alignr_epi32, blend _mm256_mask_mov_epi32,
    differ _mm256_cmpneq_epi32_mask, compress _mm256_maskz_compress_epi32);
register!(U32x16, u32, 16, u16, __m512i, load _mm512_loadu_si512, store _mm512_storeu_si512,
    splat _mm512_set1_epi32(i32), equal _mm512_cmpeq_epi32_mask, and _mm512_and_si512, flags _mm512_movepi32_mask,
    align _mm512_alignr_epi32/_mm512_mask_alignr_epi32, blend _mm512_mask_mov_epi32,
    differ _mm512_cmpneq_epi32_mask, compress _mm512_maskz_compress_epi32);
register!(U64x4, u64, 4, u8, __m256i, load _mm256_loadu_si256, store _mm256_storeu_si256,
    splat _mm256_set1_epi64x(i64), equal _mm256_cmpeq_epi64_mask, and _mm256_and_si256, flags _mm256_movepi64_mask,
    align _mm256_alignr_epi64/_mm256_mask_alignr_epi64, blend _mm256_mask_mov_epi64,
    differ _mm256_cmpneq_epi64_mask, compress _mm256_maskz_compress_epi64);
register!(U64x8, u64, 8, u8, __m512i, load _mm512_loadu_si512, store _mm512_storeu_si512,
    splat _mm512_set1_epi64(i64), equal _mm512_cmpeq_epi64_mask, and _mm512_and_si512, flags _mm512_movepi64_mask,
    align _mm512_alignr_epi64/_mm512_mask_alignr_epi64, blend _mm512_mask_mov_epi64,
    differ _mm512_cmpneq_epi64_mask, compress _mm512_maskz_compress_epi64);

/// Sixteen 64-bit tags in two registers, the front half first.
#[derive(Clone, Copy)]
struct U64x16(U64x8, U64x8);

impl SetVector for U64x16 {
    type Word = u64;
    const LANES: usize = 16;

    #[inline(always)]
    unsafe fn load(from: *const u64) -> Self {
        // SAFETY: the trait's contract, which covers both halves.
        unsafe { Self(U64x8::load(from), U64x8::load(from.add(8))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u64) {
        // SAFETY: as in `load`.
        unsafe {
            self.0.store(to);
            self.1.store(to.add(8));
        }
    }
    #[inline(always)]
    unsafe fn equal(self, word: u64) -> u32 {
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
    unsafe fn pushed(self, word: u64, prefix: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe {
            let up = _mm512_alignr_epi64::<7>(self.1.0, self.0.0);
            let back = _mm512_mask_mov_epi64(self.1.0, (prefix >> 8) as u8, up);
            Self(self.0.pushed(word, prefix & 0xFF), U64x8(back))
        }
    }
    #[inline(always)]
    unsafe fn replaced(self, word: u64, mask: u32) -> Self {
        // SAFETY: the trait's contract.
        unsafe { Self(self.0.replaced(word, mask & 0xFF), self.1.replaced(word, mask >> 8)) }
    }
}
