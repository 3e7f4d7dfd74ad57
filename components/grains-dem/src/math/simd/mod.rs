//! One formula over several numbers side by side.

#[cfg(target_arch = "x86_64")]
pub mod avx2_quad;
#[cfg(target_arch = "x86_64")]
pub mod avx512_wide;
pub mod lanes;
pub mod prefetch;
pub mod vec4;
