//! Vector instructions that a processor has, found at run time: one program for all.
//!
//! The compiler neither fuses nor reorders operations on numbers, so that the same work gives the
//! same bits in whichever instructions it is compiled for.

use crate::gather::SimdGather;
use crate::simd::Portable;
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2F64, Avx512F64};

/// Vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// Whatever the compiler chooses; on every processor.
    Portable,
    /// Registers of 32 bytes, and fused multiply-adds: AVX2 and FMA.
    Avx2,
    /// Registers of 64 bytes: AVX-512 F, VL and BW.
    Avx512,
}

/// Something to do; `run` is to be inlined, and all that it calls in its loops.
pub trait Work {
    /// Does it.
    fn run(self);
}

/// Something to do with numbers side by side; `run` is to be inlined, and all that it calls in its
/// loops.
pub trait VectorWork {
    /// Does it.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn run<V: SimdGather>(self);
}

impl Variant {
    /// All variants, the widest last.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// True if this processor has the instructions.
    #[inline]
    pub fn available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The widest variant that this processor has.
    #[inline]
    pub fn widest() -> Self {
        Self::ALL.into_iter().rev().find(|v| v.available()).unwrap_or(Self::Portable)
    }

    /// Does work in these instructions, or in portable ones if the processor has not got them.
    #[inline(always)]
    pub fn run(self, work: impl Work) {
        #[cfg(target_arch = "x86_64")]
        match self {
            // SAFETY: the processor has the instructions.
            Self::Avx512 if self.available() => return unsafe { in_avx512(work) },
            // SAFETY: as above.
            Self::Avx2 if self.available() => return unsafe { in_avx2(work) },
            _ => {}
        }
        work.run();
    }

    /// Does work in vectors of these instructions, or in portable ones if the processor has not got
    /// them.
    #[inline(always)]
    pub fn run_in_vectors(self, work: impl VectorWork) {
        #[cfg(target_arch = "x86_64")]
        match self {
            // SAFETY: the processor has the instructions.
            Self::Avx512 if self.available() => return unsafe { in_vectors_of_avx512(work) },
            // SAFETY: as above.
            Self::Avx2 if self.available() => return unsafe { in_vectors_of_avx2(work) },
            _ => {}
        }
        // SAFETY: arrays are everywhere.
        unsafe { work.run::<Portable<f64, 4>>() };
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
fn in_vectors_of_avx512(work: impl VectorWork) {
    // SAFETY: the processor has the instructions.
    unsafe { work.run::<Avx512F64>() };
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn in_vectors_of_avx2(work: impl VectorWork) {
    // SAFETY: the processor has the instructions.
    unsafe { work.run::<Avx2F64>() };
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
fn in_avx512(work: impl Work) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn in_avx2(work: impl Work) {
    work.run();
}
