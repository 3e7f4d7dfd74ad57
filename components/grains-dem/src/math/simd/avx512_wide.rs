//! Registers of eight numbers, and rows that become columns.

use crate::math::simd::lanes::LANES;
use core::arch::x86_64::*;

/// Rows to columns.
#[target_feature(enable = "avx512f")]
#[inline]
pub(crate) fn transposed(r: [__m512d; LANES]) -> [__m512d; LANES] {
    let a = [
        _mm512_unpacklo_pd(r[0], r[1]),
        _mm512_unpackhi_pd(r[0], r[1]),
        _mm512_unpacklo_pd(r[2], r[3]),
        _mm512_unpackhi_pd(r[2], r[3]),
        _mm512_unpacklo_pd(r[4], r[5]),
        _mm512_unpackhi_pd(r[4], r[5]),
        _mm512_unpacklo_pd(r[6], r[7]),
        _mm512_unpackhi_pd(r[6], r[7]),
    ];
    // Quarters 0, 2 and 1, 3 of two registers.
    let even = [
        _mm512_shuffle_f64x2::<0x88>(a[0], a[2]),
        _mm512_shuffle_f64x2::<0x88>(a[1], a[3]),
        _mm512_shuffle_f64x2::<0x88>(a[4], a[6]),
        _mm512_shuffle_f64x2::<0x88>(a[5], a[7]),
    ];
    let odd = [
        _mm512_shuffle_f64x2::<0xdd>(a[0], a[2]),
        _mm512_shuffle_f64x2::<0xdd>(a[1], a[3]),
        _mm512_shuffle_f64x2::<0xdd>(a[4], a[6]),
        _mm512_shuffle_f64x2::<0xdd>(a[5], a[7]),
    ];
    [
        _mm512_shuffle_f64x2::<0x88>(even[0], even[2]),
        _mm512_shuffle_f64x2::<0x88>(even[1], even[3]),
        _mm512_shuffle_f64x2::<0x88>(odd[0], odd[2]),
        _mm512_shuffle_f64x2::<0x88>(odd[1], odd[3]),
        _mm512_shuffle_f64x2::<0xdd>(even[0], even[2]),
        _mm512_shuffle_f64x2::<0xdd>(even[1], even[3]),
        _mm512_shuffle_f64x2::<0xdd>(odd[0], odd[2]),
        _mm512_shuffle_f64x2::<0xdd>(odd[1], odd[3]),
    ]
}

/// The first three columns of rows of four.
#[target_feature(enable = "avx512f")]
#[inline]
pub(crate) fn columns(r: [__m256d; LANES]) -> [__m512d; 3] {
    let two = |a: usize| _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(r[a]), r[a + 4]);
    let (a, b, c, d) = (two(0), two(1), two(2), two(3));
    let (xz, yw) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
    let (xz_later, yw_later) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
    let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    let third = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    [
        _mm512_permutex2var_pd(xz, first, xz_later),
        _mm512_permutex2var_pd(yw, first, yw_later),
        _mm512_permutex2var_pd(xz, third, xz_later),
    ]
}

/// Three columns as rows, whose fourth number means nothing.
#[target_feature(enable = "avx512f")]
#[inline]
pub(crate) fn rows([x, y, z]: [__m512d; 3]) -> [__m256d; LANES] {
    let (even, odd) = (_mm512_unpacklo_pd(x, y), _mm512_unpackhi_pd(x, y));
    let (even_z, odd_z) = (_mm512_unpacklo_pd(z, z), _mm512_unpackhi_pd(z, z));
    let low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
    let high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
    let half = |a: __m512d| [_mm512_castpd512_pd256(a), _mm512_extractf64x4_pd::<1>(a)];
    let [r0, r2] = half(_mm512_permutex2var_pd(even, low, even_z));
    let [r4, r6] = half(_mm512_permutex2var_pd(even, high, even_z));
    let [r1, r3] = half(_mm512_permutex2var_pd(odd, low, odd_z));
    let [r5, r7] = half(_mm512_permutex2var_pd(odd, high, odd_z));
    [r0, r1, r2, r3, r4, r5, r6, r7]
}

/// Eight numbers in a register.
pub(crate) use tremie_team::simd::Avx512F64 as Wide;
