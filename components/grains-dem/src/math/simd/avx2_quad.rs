//! Registers of four numbers, and rows that become columns.
//!
//! # Invariant
//! A [`Quad`] exists only where the processor has AVX2: only functions that demand it make one.
//! Operations on values rely on that.

use crate::math::simd::lanes::lane_of_register;
use core::arch::x86_64::*;

/// Numbers in a register.
pub(crate) const QUAD: usize = 4;

/// Rows to columns.
#[target_feature(enable = "avx2")]
#[inline]
pub(crate) fn transposed(r: [__m256d; QUAD]) -> [__m256d; QUAD] {
    let (even, odd) = (_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpackhi_pd(r[0], r[1]));
    let (even_later, odd_later) = (_mm256_unpacklo_pd(r[2], r[3]), _mm256_unpackhi_pd(r[2], r[3]));
    [
        _mm256_permute2f128_pd::<0x20>(even, even_later),
        _mm256_permute2f128_pd::<0x20>(odd, odd_later),
        _mm256_permute2f128_pd::<0x31>(even, even_later),
        _mm256_permute2f128_pd::<0x31>(odd, odd_later),
    ]
}

/// Four numbers in a register.
#[derive(Clone, Copy)]
pub(crate) struct Quad(pub __m256d);

lane_of_register!(
    Quad,
    _mm256_set1_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd _mm256_max_pd,
    negated(a) _mm256_xor_pd(a, _mm256_set1_pd(-0.0)),
    less(a, b, yes, no) _mm256_blendv_pd(no, yes, _mm256_cmp_pd::<_CMP_LT_OQ>(a, b)),
    at_most(a, b, yes, no) _mm256_blendv_pd(no, yes, _mm256_cmp_pd::<_CMP_LE_OQ>(a, b))
);
