//! Work compiled for the vector instructions that the processor has.
//!
//! The compiler neither fuses nor reorders operations on numbers, so that the same work gives the same
//! bits in whichever instructions.

#[cfg(target_arch = "x86_64")]
use crate::linear::Variant;

/// Something to do; `run` is to be inlined, and all that it calls in its loops.
pub(crate) trait Work {
    fn run(self);
}

/// Does it in the widest instructions that there are.
#[inline(always)]
pub(crate) fn in_widest(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    match Variant::widest() {
        // SAFETY: the processor has the instructions.
        Variant::Avx512 => return unsafe { in_avx512(work) },
        // SAFETY: as above.
        Variant::Avx2 => return unsafe { in_avx2(work) },
        Variant::Portable => {}
    }
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
fn in_avx512(work: impl Work) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn in_avx2(work: impl Work) {
    work.run();
}
