//! Numbers side by side: one interface over AVX-512, AVX2, plain arrays and single numbers.
//!
//! A formula is written once over [`SimdLane`], which single numbers have too; a kernel, which
//! reads and writes memory, over [`SimdVector`]. Either is compiled for each variant inside a
//! function with that variant's `#[target_feature]`. Only additions, subtractions, multiplications,
//! divisions, fused multiply-adds, square roots, comparisons, minima and maxima exist here, each
//! rounded once as IEEE 754 says. The compiler fuses nothing by itself, and nothing is summed
//! across lanes: so every variant yields the same bits. A processor without fused multiply-adds
//! (x86-64 before 2013) has them done in software: the same bits, slowly.
//!
//! # Invariant
//! A value of a vector type exists only where the processor has the instructions: `splat`, `load`
//! and `mask`, and the registers that one may be made of, are unsafe to make and demand it.
//! Operations on values rely on that.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number of a vector: `f32` or `f64`.
pub trait SimdScalar: Copy + Send + Sync + PartialOrd + std::fmt::Debug + 'static {}

impl SimdScalar for f32 {}
impl SimdScalar for f64 {}

/// A number, or several side by side, in a formula.
pub trait SimdLane:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// `value` in each lane, in the manner of `self`.
    fn all(self, value: f64) -> Self;
    /// Square root of each lane.
    fn sqrt(self) -> Self;
    /// The number where it is positive, else 0.
    fn positive(self) -> Self;
    /// `yes` where this is less than `other`, else `no`.
    fn less(self, other: Self, yes: Self, no: Self) -> Self;
    /// `yes` where this is no more than `other`, else `no`.
    fn at_most(self, other: Self, yes: Self, no: Self) -> Self;

    /// True if a formula may skip the terms that only numbers above `other` need. Always false for
    /// several lanes side by side, which do not test.
    #[inline(always)]
    fn none_above(self, _: Self) -> bool {
        false
    }
}

impl SimdLane for f64 {
    #[inline(always)]
    fn all(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn positive(self) -> Self {
        if self > 0.0 { self } else { 0.0 }
    }

    #[inline(always)]
    fn less(self, other: Self, yes: Self, no: Self) -> Self {
        if self < other { yes } else { no }
    }

    #[inline(always)]
    fn at_most(self, other: Self, yes: Self, no: Self) -> Self {
        if self <= other { yes } else { no }
    }

    #[inline(always)]
    fn none_above(self, other: Self) -> bool {
        self <= other
    }
}

/// A vector of `N` numbers.
pub trait SimdVector: SimdLane {
    /// The number.
    type Scalar: SimdScalar;
    /// Selection of lanes.
    type Mask: Copy;
    /// Number of lanes.
    const N: usize;

    /// `value` in each lane.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    unsafe fn splat(value: f64) -> Self;
    /// `N` numbers from `from` on, at any alignment.
    ///
    /// # Safety
    /// The processor has the variant's instructions; `N` numbers may be read.
    unsafe fn load(from: *const Self::Scalar) -> Self;
    /// Writes `N` numbers from `to` on, at any alignment.
    ///
    /// # Safety
    /// `N` numbers may be written.
    unsafe fn store(self, to: *mut Self::Scalar);
    /// Replaces the lanes of the mask by the numbers from `from` on, of which only these are read.
    ///
    /// # Safety
    /// The numbers of the mask's lanes may be read.
    unsafe fn load_lanes(self, from: *const Self::Scalar, mask: Self::Mask) -> Self;
    /// Writes the lanes whose bits are set to the numbers from `to` on, and leaves the others
    /// alone.
    ///
    /// # Safety
    /// The numbers of these lanes may be written.
    unsafe fn store_lanes(self, to: *mut Self::Scalar, lanes: u32);
    /// `self * factor + addend`, rounded once.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// `self * factor - subtrahend`, rounded once.
    fn mul_sub(self, factor: Self, subtrahend: Self) -> Self;
    /// `minuend - self * factor`, rounded once.
    fn mul_from(self, factor: Self, minuend: Self) -> Self;
    /// Mask of the lanes whose bit is set; bit 0 is the first lane.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    unsafe fn mask(bits: u32) -> Self::Mask;
    /// The lanes of the mask; zero in the others.
    fn keep(self, mask: Self::Mask) -> Self;
    /// The smaller in each lane; `other` where either is not a number.
    fn min(self, other: Self) -> Self;
    /// The larger in each lane; `other` where either is not a number.
    fn max(self, other: Self) -> Self;
    /// Adds each lane to one of `N` sums.
    ///
    /// # Safety
    /// `N` numbers may be read and written.
    unsafe fn add_to(self, sums: *mut f64);
}

/// Writes the numbers whose bits are set to where they would stand from `to` on: halves of `H`
/// numbers at once where all of these are set, else one by one.
///
/// # Safety
/// These may be written.
#[inline(always)]
unsafe fn write_lanes<T: Copy, const H: usize>(halves: &[[T; H]; 2], to: *mut T, lanes: u32) {
    let whole = u32::MAX >> (32 - H);
    let mut k = 0;
    while k < 2 {
        let (half, to) = (&halves[k], to.wrapping_add(k * H));
        let mut left = lanes >> (k * H) & whole;
        if left == whole {
            // SAFETY: by contract.
            unsafe { to.cast::<[T; H]>().write_unaligned(*half) };
            left = 0;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % H;
            // SAFETY: by contract.
            unsafe { *to.wrapping_add(lane) = half[lane] };
            left &= left - 1;
        }
        k += 1;
    }
}

/// Implements one arithmetic operator.
macro_rules! operator {
    ([$($generics:tt)*] $type:ty, $trait:ident :: $method:ident ($a:ident, $b:ident) => $value:expr) => {
        impl<$($generics)*> $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
    };
}

/// An array as a vector, for any processor.
#[derive(Clone, Copy, Debug)]
pub struct Portable<T, const N: usize>(pub [T; N]);

impl<const N: usize> Portable<f64, N> {
    /// All lanes 0.
    pub const ZERO: Self = Self([0.0; N]);
}

/// Implements an operation on arrays lane by lane, without a closure (which would not inherit the
/// features of its surroundings).
macro_rules! by_lane {
    ($a:ident, $b:ident, $x:ident, $y:ident => $value:expr) => {
        by_lane!($a, $b, $b, $x, $y, _z => $value)
    };
    ($a:ident, $b:ident, $c:ident, $x:ident, $y:ident, $z:pat => $value:expr) => {{
        let mut out = $a;
        let mut k = 0;
        while k < N {
            let ($x, $y, $z) = ($a.0[k], $b.0[k], $c.0[k]);
            out.0[k] = $value;
            k += 1;
        }
        out
    }};
}

macro_rules! portable {
    ($real:ty) => {
        operator!([const N: usize] Portable<$real, N>, Add::add(a, b) => by_lane!(a, b, x, y => x + y));
        operator!([const N: usize] Portable<$real, N>, Sub::sub(a, b) => by_lane!(a, b, x, y => x - y));
        operator!([const N: usize] Portable<$real, N>, Mul::mul(a, b) => by_lane!(a, b, x, y => x * y));
        operator!([const N: usize] Portable<$real, N>, Div::div(a, b) => by_lane!(a, b, x, y => x / y));

        impl<const N: usize> Neg for Portable<$real, N> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                by_lane!(self, self, x, _y => -x)
            }
        }

        impl<const N: usize> SimdLane for Portable<$real, N> {
            #[inline(always)]
            fn all(self, value: f64) -> Self {
                Self([value as $real; N])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                by_lane!(self, self, x, _y => x.sqrt())
            }
            #[inline(always)]
            fn positive(self) -> Self {
                by_lane!(self, self, x, _y => if x > 0.0 { x } else { 0.0 })
            }
            #[inline(always)]
            fn less(self, other: Self, yes: Self, no: Self) -> Self {
                let mut out = no;
                let mut k = 0;
                while k < N {
                    out.0[k] = if self.0[k] < other.0[k] { yes.0[k] } else { no.0[k] };
                    k += 1;
                }
                out
            }
            #[inline(always)]
            fn at_most(self, other: Self, yes: Self, no: Self) -> Self {
                let mut out = no;
                let mut k = 0;
                while k < N {
                    out.0[k] = if self.0[k] <= other.0[k] { yes.0[k] } else { no.0[k] };
                    k += 1;
                }
                out
            }
        }

        impl<const N: usize> SimdVector for Portable<$real, N> {
            type Scalar = $real;
            type Mask = u32;
            const N: usize = N;

            #[inline(always)]
            unsafe fn splat(value: f64) -> Self {
                Self([value as $real; N])
            }
            #[inline(always)]
            unsafe fn load(from: *const $real) -> Self {
                // SAFETY: by contract.
                Self(unsafe { from.cast::<[$real; N]>().read_unaligned() })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $real) {
                // SAFETY: by contract.
                unsafe { to.cast::<[$real; N]>().write_unaligned(self.0) }
            }
            #[inline(always)]
            unsafe fn load_lanes(self, from: *const $real, mask: u32) -> Self {
                let mut out = self;
                let mut k = 0;
                while k < N {
                    if mask >> k & 1 == 1 {
                        // SAFETY: by contract.
                        out.0[k] = unsafe { *from.wrapping_add(k) };
                    }
                    k += 1;
                }
                out
            }
            #[inline(always)]
            unsafe fn store_lanes(self, to: *mut $real, lanes: u32) {
                let mut k = 0;
                while k < N {
                    if lanes >> k & 1 == 1 {
                        // SAFETY: by contract.
                        unsafe { *to.wrapping_add(k) = self.0[k] };
                    }
                    k += 1;
                }
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, addend: Self) -> Self {
                by_lane!(self, factor, addend, x, y, z => x.mul_add(y, z))
            }
            #[inline(always)]
            fn mul_sub(self, factor: Self, subtrahend: Self) -> Self {
                by_lane!(self, factor, subtrahend, x, y, z => x.mul_add(y, -z))
            }
            #[inline(always)]
            fn mul_from(self, factor: Self, minuend: Self) -> Self {
                by_lane!(self, factor, minuend, x, y, z => (-x).mul_add(y, z))
            }
            #[inline(always)]
            unsafe fn mask(bits: u32) -> u32 {
                bits
            }
            #[inline(always)]
            fn keep(self, mask: u32) -> Self {
                let mut out = self;
                let mut k = 0;
                while k < N {
                    if mask >> k & 1 == 0 {
                        out.0[k] = 0.0;
                    }
                    k += 1;
                }
                out
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                by_lane!(self, other, x, y => if x < y { x } else { y })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                by_lane!(self, other, x, y => if x > y { x } else { y })
            }
            #[inline(always)]
            unsafe fn add_to(self, sums: *mut f64) {
                let mut k = 0;
                while k < N {
                    // SAFETY: by contract.
                    unsafe { *sums.add(k) += f64::from(self.0[k]) };
                    k += 1;
                }
            }
        }
    };
}
portable!(f64);
portable!(f32);

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2F32, Avx2F64, Avx512F32, Avx512F64};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::*;
    use core::arch::x86_64::*;

    /// Implements [`SimdVector`] for a wrapped register by one intrinsic for each operation.
    macro_rules! register {
        ($(#[$doc:meta])* $name:ident($register:ty), $real:ty, $n:literal, $mask:ty,
         $splat:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident $min:ident $max:ident $sqrt:ident
         $mul_add:ident $mul_sub:ident $mul_from:ident,
         load_lanes($old:ident, $from:ident, $read:ident) $load_lanes:expr,
         store_lanes($new:ident, $to:ident, $written:ident) $store_lanes:expr,
         mask($bits:ident) $make_mask:expr,
         keep($value:ident, $lanes:ident) $keep:expr,
         add_to($sum_value:ident, $sums:ident) $add_to:expr,
         negated($negative:ident) $negated:expr,
         choose($chosen:ident, $over:ident, $yes:ident, $no:ident) less $less:expr, at_most $at_most:expr
        ) => {
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            pub struct $name(pub $register);

            operator!([] $name, Add::add(a, b) => {
                // SAFETY: the values exist, so the instructions do.
                Self(unsafe { $add(a.0, b.0) })
            });
            operator!([] $name, Sub::sub(a, b) => {
                // SAFETY: the values exist, so the instructions do.
                Self(unsafe { $sub(a.0, b.0) })
            });
            operator!([] $name, Mul::mul(a, b) => {
                // SAFETY: the values exist, so the instructions do.
                Self(unsafe { $mul(a.0, b.0) })
            });
            operator!([] $name, Div::div(a, b) => {
                // SAFETY: the values exist, so the instructions do.
                Self(unsafe { $div(a.0, b.0) })
            });

            impl Neg for $name {
                type Output = Self;
                #[inline(always)]
                fn neg(self) -> Self {
                    let $negative = self.0;
                    // SAFETY: the value exists, so the instructions do.
                    Self(unsafe { $negated })
                }
            }

            impl SimdLane for $name {
                #[inline(always)]
                fn all(self, value: f64) -> Self {
                    // SAFETY: `self` exists, so the instructions do.
                    Self(unsafe { $splat(value as $real) })
                }
                #[inline(always)]
                fn sqrt(self) -> Self {
                    // SAFETY: the value exists, so the instructions do.
                    Self(unsafe { $sqrt(self.0) })
                }
                #[inline(always)]
                fn positive(self) -> Self {
                    // The second operand where the first is not larger.
                    // SAFETY: the value exists, so the instructions do.
                    Self(unsafe { $max(self.0, $splat(0.0)) })
                }
                #[inline(always)]
                fn less(self, other: Self, yes: Self, no: Self) -> Self {
                    let ($chosen, $over, $yes, $no) = (self.0, other.0, yes.0, no.0);
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $less })
                }
                #[inline(always)]
                fn at_most(self, other: Self, yes: Self, no: Self) -> Self {
                    let ($chosen, $over, $yes, $no) = (self.0, other.0, yes.0, no.0);
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $at_most })
                }
            }

            impl SimdVector for $name {
                type Scalar = $real;
                type Mask = $mask;
                const N: usize = $n;

                #[inline(always)]
                unsafe fn splat(value: f64) -> Self {
                    // SAFETY: by contract.
                    Self(unsafe { $splat(value as $real) })
                }
                #[inline(always)]
                unsafe fn load(from: *const $real) -> Self {
                    // SAFETY: by contract.
                    Self(unsafe { $load(from) })
                }
                #[inline(always)]
                unsafe fn store(self, to: *mut $real) {
                    // SAFETY: by contract.
                    unsafe { $store(to, self.0) }
                }
                #[inline(always)]
                unsafe fn load_lanes(self, $from: *const $real, $read: $mask) -> Self {
                    let $old = self.0;
                    // SAFETY: by contract, and the value exists, so the instructions do.
                    Self(unsafe { $load_lanes })
                }
                #[inline(always)]
                unsafe fn store_lanes(self, $to: *mut $real, $written: u32) {
                    let $new = self.0;
                    // SAFETY: by contract, and the value exists, so the instructions do.
                    unsafe { $store_lanes }
                }
                #[inline(always)]
                fn mul_add(self, factor: Self, addend: Self) -> Self {
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $mul_add(self.0, factor.0, addend.0) })
                }
                #[inline(always)]
                fn mul_sub(self, factor: Self, subtrahend: Self) -> Self {
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $mul_sub(self.0, factor.0, subtrahend.0) })
                }
                #[inline(always)]
                fn mul_from(self, factor: Self, minuend: Self) -> Self {
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $mul_from(self.0, factor.0, minuend.0) })
                }
                #[inline(always)]
                unsafe fn mask($bits: u32) -> $mask {
                    $make_mask
                }
                #[inline(always)]
                fn keep(self, $lanes: $mask) -> Self {
                    let $value = self.0;
                    // SAFETY: the value exists, so the instructions do.
                    Self(unsafe { $keep })
                }
                #[inline(always)]
                fn min(self, other: Self) -> Self {
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $min(self.0, other.0) })
                }
                #[inline(always)]
                fn max(self, other: Self) -> Self {
                    // SAFETY: the values exist, so the instructions do.
                    Self(unsafe { $max(self.0, other.0) })
                }
                #[inline(always)]
                unsafe fn add_to(self, $sums: *mut f64) {
                    let $sum_value = self.0;
                    // SAFETY: by contract, and the value exists, so the instructions do.
                    unsafe { $add_to }
                }
            }
        };
    }

    register! {
        /// 8 numbers of 64 bits.
        Avx512F64(__m512d), f64, 8, __mmask8,
        _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd
        _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_min_pd _mm512_max_pd _mm512_sqrt_pd
        _mm512_fmadd_pd _mm512_fmsub_pd _mm512_fnmadd_pd,
        load_lanes(old, from, lanes) _mm512_mask_loadu_pd(old, lanes, from),
        store_lanes(v, to, lanes) _mm512_mask_storeu_pd(to, lanes as __mmask8, v),
        mask(bits) bits as __mmask8,
        keep(v, lanes) _mm512_maskz_mov_pd(lanes, v),
        add_to(v, sums) _mm512_storeu_pd(sums, _mm512_add_pd(_mm512_loadu_pd(sums), v)),
        negated(a) _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(a), _mm512_set1_epi64(i64::MIN))),
        choose(a, b, yes, no)
            less _mm512_mask_mov_pd(no, _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), yes),
            at_most _mm512_mask_mov_pd(no, _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b), yes)
    }

    register! {
        /// 16 numbers of 32 bits.
        Avx512F32(__m512), f32, 16, __mmask16,
        _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps
        _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_min_ps _mm512_max_ps _mm512_sqrt_ps
        _mm512_fmadd_ps _mm512_fmsub_ps _mm512_fnmadd_ps,
        load_lanes(old, from, lanes) _mm512_mask_loadu_ps(old, lanes, from),
        store_lanes(v, to, lanes) _mm512_mask_storeu_ps(to, lanes as __mmask16, v),
        mask(bits) bits as __mmask16,
        keep(v, lanes) _mm512_maskz_mov_ps(lanes, v),
        add_to(v, sums) {
            let low = _mm512_cvtps_pd(_mm512_castps512_ps256(v));
            let high = _mm512_extractf64x4_pd::<1>(_mm512_castps_pd(v));
            let high = _mm512_cvtps_pd(_mm256_castpd_ps(high));
            _mm512_storeu_pd(sums, _mm512_add_pd(_mm512_loadu_pd(sums), low));
            let sums = sums.add(8);
            _mm512_storeu_pd(sums, _mm512_add_pd(_mm512_loadu_pd(sums), high))
        },
        negated(a) _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(a), _mm512_set1_epi32(i32::MIN))),
        choose(a, b, yes, no)
            less _mm512_mask_mov_ps(no, _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b), yes),
            at_most _mm512_mask_mov_ps(no, _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b), yes)
    }

    register! {
        /// 4 numbers of 64 bits.
        Avx2F64(__m256d), f64, 4, __m256d,
        _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd
        _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_min_pd _mm256_max_pd _mm256_sqrt_pd
        _mm256_fmadd_pd _mm256_fmsub_pd _mm256_fnmadd_pd,
        load_lanes(old, from, lanes) _mm256_blendv_pd(old, _mm256_maskload_pd(from, _mm256_castpd_si256(lanes)), lanes),
        store_lanes(v, to, lanes) if lanes == 0xf {
            _mm256_storeu_pd(to, v)
        } else {
            // Some processors take longer for a store with a mask than for all lanes one by one.
            let mut halves = [[0.0; 2]; 2];
            _mm256_storeu_pd(halves.as_mut_ptr().cast(), v);
            write_lanes(&halves, to, lanes)
        },
        mask(bits) unsafe {
            // SAFETY: by contract.
            let lane = _mm256_setr_epi64x(1, 2, 4, 8);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), lane);
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, lane))
        },
        keep(v, lanes) _mm256_and_pd(v, lanes),
        add_to(v, sums) _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), v)),
        negated(a) _mm256_xor_pd(a, _mm256_set1_pd(-0.0)),
        choose(a, b, yes, no)
            less _mm256_blendv_pd(no, yes, _mm256_cmp_pd::<_CMP_LT_OQ>(a, b)),
            at_most _mm256_blendv_pd(no, yes, _mm256_cmp_pd::<_CMP_LE_OQ>(a, b))
    }

    register! {
        /// 8 numbers of 32 bits.
        Avx2F32(__m256), f32, 8, __m256,
        _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps
        _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_min_ps _mm256_max_ps _mm256_sqrt_ps
        _mm256_fmadd_ps _mm256_fmsub_ps _mm256_fnmadd_ps,
        load_lanes(old, from, lanes) _mm256_blendv_ps(old, _mm256_maskload_ps(from, _mm256_castps_si256(lanes)), lanes),
        store_lanes(v, to, lanes) if lanes == 0xff {
            _mm256_storeu_ps(to, v)
        } else {
            // Some processors take longer for a store with a mask than for all lanes one by one.
            let mut halves = [[0.0; 4]; 2];
            _mm256_storeu_ps(halves.as_mut_ptr().cast(), v);
            write_lanes(&halves, to, lanes)
        },
        mask(bits) unsafe {
            // SAFETY: by contract.
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane))
        },
        keep(v, lanes) _mm256_and_ps(v, lanes),
        add_to(v, sums) {
            let low = _mm256_cvtps_pd(_mm256_castps256_ps128(v));
            let high = _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(v));
            _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), low));
            let sums = sums.add(4);
            _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), high))
        },
        negated(a) _mm256_xor_ps(a, _mm256_set1_ps(-0.0)),
        choose(a, b, yes, no)
            less _mm256_blendv_ps(no, yes, _mm256_cmp_ps::<_CMP_LT_OQ>(a, b)),
            at_most _mm256_blendv_ps(no, yes, _mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of both signs and many sizes, some of them equal.
    fn numbers(seed: u64) -> [f64; 16] {
        let mut state = seed;
        std::array::from_fn(|k| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let value = (state >> 40) as f64 / 65_536.0 - 128.0;
            if k % 5 == 0 { 1.5 } else { value }
        })
    }

    /// What a vector does to all lanes is what single numbers do, to the bit.
    ///
    /// # Safety
    /// The processor has the instructions.
    unsafe fn agrees_with_single_numbers<V: SimdVector<Scalar = f64>>() {
        for seed in 0..50 {
            let (a, b, c) = (numbers(seed), numbers(seed + 1000), numbers(seed + 2000));
            // SAFETY: by contract; the arrays are longer than any vector.
            let [x, y, z] = [&a, &b, &c].map(|v| unsafe { V::load(v.as_ptr()) });
            let same = |found: V, of: &dyn Fn(f64, f64, f64) -> f64| {
                let mut lanes = [0.0; 16];
                // SAFETY: as above.
                unsafe { found.store(lanes.as_mut_ptr()) };
                for k in 0..V::N {
                    let wanted = of(a[k], b[k], c[k]);
                    assert_eq!(lanes[k].to_bits(), wanted.to_bits(), "lane {k}");
                }
            };
            same(x + y, &|x, y, _| x + y);
            same(x - y, &|x, y, _| x - y);
            same(x * y, &|x, y, _| x * y);
            same(x / y, &|x, y, _| x / y);
            same(-x, &|x, _, _| -x);
            same((x * x).sqrt(), &|x, _, _| (x * x).sqrt());
            same(x.positive(), &|x, _, _| SimdLane::positive(x));
            same(x.less(y, z, x), &|x, y, z| SimdLane::less(x, y, z, x));
            same(x.at_most(y, z, x), &|x, y, z| SimdLane::at_most(x, y, z, x));
            same(x.all(0.1), &|_, _, _| 0.1);
            same(x.mul_add(y, z), &|x, y, z| x.mul_add(y, z));
            same(x.mul_sub(y, z), &|x, y, z| x.mul_add(y, -z));
            same(x.mul_from(y, z), &|x, y, z| (-x).mul_add(y, z));
            same(x.min(y), &|x, y, _| if x < y { x } else { y });
            same(x.max(y), &|x, y, _| if x > y { x } else { y });
        }
    }

    #[test]
    fn every_variant_gives_the_bits_of_single_numbers() {
        // SAFETY: arrays are everywhere.
        unsafe { agrees_with_single_numbers::<Portable<f64, 8>>() };
        #[cfg(target_arch = "x86_64")]
        {
            use crate::Variant;
            if Variant::Avx2.available() {
                // SAFETY: the processor has the instructions.
                unsafe { agrees_with_single_numbers::<Avx2F64>() };
            }
            if Variant::Avx512.available() {
                // SAFETY: the processor has the instructions.
                unsafe { agrees_with_single_numbers::<Avx512F64>() };
            }
        }
    }
}
