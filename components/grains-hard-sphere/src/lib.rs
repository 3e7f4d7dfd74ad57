//! Hard spheres of Tremie: spheres, or discs of plane scenes, that collide in no time, with
//! restitution and friction.
//!
//! The solver is plain: a [`Scene`](tremie_messages::scene::Scene) and [`Parameters`] go in,
//! [`HardSpheres::advance`] lets a window pass, [`HardSpheres::write_state`] gives poses and
//! velocities. Nothing here knows how they travel. All quantities are SI, in the world frame.
//!
//! ```
//! use tremie_grains_hard_sphere::{HardSpheres, Parameters};
//! use tremie_messages::body::BodyState;
//! use tremie_messages::scene::*;
//!
//! // A ball falls on a floor: restitution 0.9, friction 0.3.
//! let law = ContactLaw {
//!     spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 8e2 },
//!     friction: 0.3,
//!     rolling_friction: 0.0,
//!     damping: Damping::Restitution(0.9),
//!     tension: false,
//! };
//! let pair = |other: &str| PairLaw { between: ["glass".into(), other.into()], law: law.clone() };
//! let ball = Sphere { position: [0.5, 0.5, 0.51], diameter: 0.02, velocity: [0.0; 3], angular_velocity: [0.0; 3] };
//! let scene = Scene {
//!     gravity: [0.0, 0.0, -9.81],
//!     contacts: vec![pair("glass"), pair("wall")],
//!     bodies: vec![BodySet {
//!         name: "ball".into(),
//!         density: 2500.0,
//!         material: "glass".into(),
//!         motion: Motion::Free,
//!         clump: None,
//!         placement: Placement::Listed(vec![ball]),
//!     }],
//!     ..Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS))
//! };
//! let mut spheres = HardSpheres::new(&scene, &Parameters::default(), 0.4, 1).unwrap();
//! spheres.advance(1, &[]).unwrap();
//! // Half a metre takes 0.319 s: it is on its way up.
//! assert!(spheres.sphere(0).velocity[2] > 0.0);
//! assert_eq!(spheres.diagnostics().wall_collisions, 1);
//! ```
//!
//! Two ways lead from collision to collision. Where nothing but weight acts in between
//! (`solver/event_driver.rs`) each collision comes at its time and none is missed: the paths are
//! parabolas, and the moments of touch roots of polynomials. Where a fluid acts, or something moves
//! as prescribed (`solver/step_driver.rs`), all go through a step, and those that overlap at its end
//! are taken back (Goetsch, thesis, 2015, Sec. 2.3.3). The rule of a collision is the same:
//! `impact/collision.rs`.
//!
//! # Same bits
//!
//! Equal scenes give equal bits on any number of threads: of events at equal times that of the
//! smaller ids comes first, threads look for touches but a single order makes them come true, and no
//! function of the system's mathematics library is used.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod bodies;
mod cells;
mod grains;
mod impact;
mod setup;
mod solver;

#[cfg(feature = "component")]
pub use grains::{benchmark::benchmarks, component};

pub use grains::findings::{findings, limits};
pub use grains::hard_spheres::{HardSphereError, HardSpheres};
pub use impact::approach::Approach;
pub use impact::collision::{Collider, ImpactLaw, Impulse};
pub use setup::hard_resolution::HardResolution;
pub use setup::parameters::{Detection, Parameters};
pub use solver::diagnostics::HardDiagnostics;

/// A vector in the world frame.
type Vec3 = nalgebra::Vector3<f64>;
