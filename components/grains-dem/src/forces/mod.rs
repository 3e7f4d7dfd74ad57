//! Contact forces of all pairs of spheres, with their twins in AVX2 and AVX-512.

pub mod pair_forces;
#[cfg(target_arch = "x86_64")]
pub mod pair_forces_avx2;
#[cfg(target_arch = "x86_64")]
pub mod pair_forces_avx512;
#[cfg(target_arch = "x86_64")]
pub mod register_scan;
pub mod side_by_side;
