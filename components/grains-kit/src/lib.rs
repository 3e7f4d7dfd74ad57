//! What every kind of grains of Tremie needs, so that a new one is its equations and little else.
//!
//! | room | what grains get |
//! | --- | --- |
//! | [`math`] | random numbers |
//! | [`space`] | the box that wraps around, plane walls, triangles of walls, rigid bodies |
//! | [`motion`] | motions that a scene prescribes, integrated exactly |
//! | [`neighbours`] | linked cells in levels of sizes, pairs near each other |
//! | [`packing`] | bodies placed at random |
//! | [`checks`] | checks of a scene, with a problem for each fault |
//! | [`signals`] | signals of single bodies, and which bodies have them |
//! | [`profiles`] | tables of fraction, velocity, fluctuation, coordination and stress over the bins of a box |
//!
//! Nothing here knows how grains touch, or how messages travel. A profile of two made-up grains, of
//! which one lies in the lower half of a box:
//!
//! ```
//! use tremie_grains_kit::profiles::{GrainSample, ProfileSampler};
//! use tremie_messages::frame::ProfileBin;
//! use tremie_messages::scene::{BinnedAxis, Domain, Face, GrainProfile, ProfileVelocity};
//!
//! let profile = GrainProfile {
//!     name: "height".into(),
//!     axes: vec![BinnedAxis { axis: 2, bins: 2 }],
//!     min: [0.0; 3],
//!     max: [1.0; 3],
//!     from: 0.0,
//!     every: None,
//!     average: None,
//!     velocity: ProfileVelocity::Instantaneous,
//! };
//! let domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
//! let mut sampler = ProfileSampler::new(&profile, &domain, 1e-3, 2);
//! let at = |id, z| GrainSample { position: [0.5, 0.5, z], volume: 0.05, mass: 1.0, ..GrainSample::new(id) };
//! let window = 1;
//! if sampler.wants(window) {
//!     sampler.take(window, [at(0, 0.2), at(1, 0.9)].into_iter());
//! }
//! let mut bins = [ProfileBin::default(); 2];
//! let header = sampler.table(&mut bins);
//! assert_eq!(header.samples, 1);
//! assert_eq!(bins.map(|bin| bin.solid_fraction), [0.1, 0.1]);
//! ```

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod checks;
pub mod math;
pub mod motion;
pub mod neighbours;
pub mod packing;
pub mod profiles;
pub mod signals;
pub mod space;

/// A vector in the world frame.
pub type Vec3 = nalgebra::Vector3<f64>;
