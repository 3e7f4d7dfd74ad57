//! Registers of four numbers, and rows that become columns.

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
pub(crate) use tremie_team::simd::Avx2F64 as Quad;
