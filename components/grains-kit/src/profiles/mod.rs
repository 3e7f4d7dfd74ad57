//! Profiles: grains by the bins of a box, with means over the samples of a table.
//!
//! Sums go in the order in which the samples come, one after the other: equal samples in equal
//! order give equal bits. Variances are those of Welford's method with weights (West, *Commun. ACM*
//! 22, 1979), which loses nothing where a mean is large beside its fluctuation.

mod bins;
mod displacement;
mod grain_sample;
mod moments;
mod sampler;
mod sums;

pub use grain_sample::{GrainSample, add_virial};
pub use sampler::ProfileSampler;
