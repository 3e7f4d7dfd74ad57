//! Discrete elements of Tremie: spheres, walls, contacts with friction.
//!
//! The solver is plain: a [`Scene`](tremie_messages::scene::Scene) and [`Parameters`] go in,
//! [`GrainsDem::advance`] integrates a number of substeps under constant fluid loads, and
//! [`GrainsDem::write_state`] gives poses and velocities. Nothing here knows how they travel.
//!
//! Contacts are linear springs and dashpots with Coulomb friction and a tangential spring that
//! remembers the sliding path (Cundall & Strack, *Géotechnique* 29, 1979; Luding, *Granular
//! Matter* 10, 2008; with the parameters of Mutabaruka & Kamrin, *Comput. Part.
//! Mech.* 5, 2018). Time is
//! integrated by velocity Verlet with predicted velocities. All quantities are SI, in the world
//! frame.
//!
//! Equal scenes and parameters give equal bits: sums run in the order of body ids, random numbers
//! are keyed by seed and index, and no function of the system's mathematics library is used.

mod bodies;
mod cells;
mod check;
#[cfg(feature = "component")]
pub mod component;
mod contact;
mod contact_list;
mod damping;
mod diagnostics;
mod error;
mod findings;
mod forces;
mod integrate;
mod law;
mod overlaps;
mod packing;
mod parameters;
mod periodic;
mod placement;
mod random;
mod resolve;
mod search;
mod solver;
mod stability;
mod walls;

pub use damping::{damping_ratio, restitution};
pub use diagnostics::Diagnostics;
pub use error::GrainsError;
pub use findings::findings;
pub use parameters::Parameters;
pub use resolve::{PairDamping, Resolution};
pub use solver::GrainsDem;

/// A vector in the world frame.
type Vec3 = nalgebra::Vector3<f64>;
