//! Numbers side by side from scattered places in memory.

use crate::simd::{Portable, SimdVector};

/// Places in memory, of which a vector takes as many as it has lanes.
pub type Places = [i32; 8];

/// A vector of at most 8 lanes that may come from places of their own.
pub trait SimdGather: SimdVector<Scalar = f64> {
    /// Each lane without its fraction.
    fn truncated(self) -> Self;

    /// Each lane without its fraction as a place. A place beyond 2^31, and that of no number, is
    /// any.
    fn places(self) -> Places;

    /// The numbers at places, counted from `from`. They are loaded one by one: many processors'
    /// own instructions for it are no faster, and some are much slower since they were mended.
    ///
    /// # Safety
    /// The processor has the variant's instructions; the number at each of the first `N` places may
    /// be read.
    unsafe fn gathered(places: &Places, from: *const f64) -> Self;
}

impl<const N: usize> SimdGather for Portable<f64, N> {
    #[inline(always)]
    fn truncated(mut self) -> Self {
        let mut k = 0;
        while k < N {
            self.0[k] = self.0[k].trunc();
            k += 1;
        }
        self
    }

    #[inline(always)]
    fn places(self) -> Places {
        let mut places = [0; 8];
        let mut k = 0;
        while k < N {
            places[k] = self.0[k] as i32;
            k += 1;
        }
        places
    }

    #[inline(always)]
    unsafe fn gathered(places: &Places, from: *const f64) -> Self {
        let mut numbers = Self::ZERO;
        let mut k = 0;
        while k < N {
            // SAFETY: by contract.
            numbers.0[k] = unsafe { *from.offset(places[k] as isize) };
            k += 1;
        }
        numbers
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Places, SimdGather};
    use crate::simd::{Avx2F64, Avx512F64};
    use core::arch::x86_64::*;

    impl SimdGather for Avx512F64 {
        #[inline(always)]
        fn truncated(self) -> Self {
            const TO_ZERO: i32 = _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC;
            // SAFETY: the value exists, so the instructions do.
            Self(unsafe { _mm512_roundscale_pd::<TO_ZERO>(self.0) })
        }

        #[inline(always)]
        fn places(self) -> Places {
            let mut places = [0; 8];
            // SAFETY: the value exists, so the instructions do; the array holds 8 places.
            unsafe {
                _mm256_storeu_si256(places.as_mut_ptr().cast(), _mm512_cvttpd_epi32(self.0));
            }
            places
        }

        #[inline(always)]
        unsafe fn gathered(p: &Places, from: *const f64) -> Self {
            // SAFETY: by contract.
            Self(unsafe {
                let at = p.map(|place| *from.offset(place as isize));
                _mm512_setr_pd(at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7])
            })
        }
    }

    impl SimdGather for Avx2F64 {
        #[inline(always)]
        fn truncated(self) -> Self {
            const TO_ZERO: i32 = _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC;
            // SAFETY: the value exists, so the instructions do.
            Self(unsafe { _mm256_round_pd::<TO_ZERO>(self.0) })
        }

        #[inline(always)]
        fn places(self) -> Places {
            let mut places = [0; 8];
            // SAFETY: the value exists, so the instructions do; the array holds 8 places.
            unsafe { _mm_storeu_si128(places.as_mut_ptr().cast(), _mm256_cvttpd_epi32(self.0)) };
            places
        }

        #[inline(always)]
        unsafe fn gathered(p: &Places, from: *const f64) -> Self {
            // SAFETY: by contract.
            Self(unsafe {
                let at = [p[0], p[1], p[2], p[3]].map(|place| *from.offset(place as isize));
                _mm256_setr_pd(at[0], at[1], at[2], at[3])
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gathers what single numbers find, to the bit.
    ///
    /// # Safety
    /// The processor has the instructions.
    unsafe fn agrees_with_single_numbers<V: SimdGather>() {
        let table: Vec<f64> = (0..1000).map(|k| f64::from(k).sqrt()).collect();
        for seed in 0..100 {
            let places: [f64; 8] =
                std::array::from_fn(|k| f64::from((seed * 37 + k as u32 * 131) % 1000));
            let mut found = [0.0; 8];
            // SAFETY: by contract; no place is beyond the table, no vector longer than the array.
            unsafe {
                let at = V::load(places.as_ptr()) + V::splat(0.75);
                let truncated = at.truncated().places();
                assert_eq!(truncated, at.places());
                V::gathered(&truncated, table.as_ptr()).store(found.as_mut_ptr());
            }
            for k in 0..V::N {
                assert_eq!(found[k].to_bits(), table[places[k] as usize].to_bits(), "lane {k}");
            }
        }
    }

    #[test]
    fn every_variant_gathers_what_single_numbers_find() {
        // SAFETY: arrays are everywhere.
        unsafe { agrees_with_single_numbers::<Portable<f64, 4>>() };
        #[cfg(target_arch = "x86_64")]
        {
            use crate::Variant;
            use crate::simd::{Avx2F64, Avx512F64};
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
