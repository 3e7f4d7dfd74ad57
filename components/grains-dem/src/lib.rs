//! Discrete elements of Tremie: spheres and convex polyhedra, walls, parts with triangulated
//! surfaces, contacts with friction.
//!
//! The solver is plain: a [`Scene`](tremie_messages::scene::Scene) and [`Parameters`] go in,
//! [`GrainsDem::advance`] integrates a number of substeps under constant fluid loads, and
//! [`GrainsDem::write_state`] gives poses and velocities. Nothing here knows how they travel.
//!
//! Each pair of materials has its law: linear springs, or those of Hertz and Mindlin, dashpots,
//! Coulomb friction and rolling friction with springs that remember the path (Cundall & Strack,
//! *Géotechnique* 29, 1979; Luding, *Granular Matter* 10, 2008; with the parameters of Mutabaruka &
//! Kamrin, *Comput. Part. Mech.* 5, 2018). Narrow gaps may be lubricated. Time is integrated by
//! velocity Verlet with predicted velocities. All quantities are SI, in the world frame.
//!
//! A convex polyhedron is the hull of at most 60 corners, of any size and orientation. It touches
//! polyhedra, spheres, walls and parts under the linear laws; `polyhedra/overlap_integrals.rs` has
//! the forces, which are derivatives of an energy, so that contacts without dashpots keep it to
//! second order in the step. The normal stiffness of a law is reached where a polyhedron's largest
//! face (of two, the smaller one) is touched all over; smaller contacts are softer in proportion,
//! and edges and corners sink in deeper. Rolling friction acts on spheres alone. A body of several
//! convex pieces is a clump. Polyhedra and clumps do not come and go.
//!
//! Spheres may come and go between windows ([`GrainsDem::exchange`]): those that stay go on as if
//! nothing had happened, and ids are never used again.
//!
//! Parts stand still, move as prescribed, or slide on an axis under forces. A slider may carry a
//! [`DeformableSurface`], a seal of rubber say, whose vertices somebody else moves: within a
//! substep shapes are tried ([`GrainsDem::contact_on_surface`]) and one is accepted
//! ([`GrainsDem::finish_substep`]).
//!
//! # What a substep costs
//!
//! Bytes moved to and from memory for each sphere of a bed too large for the caches, with 1.9
//! contacts and 5 listed pairs a sphere, of which a step looks at 2.3 (`neighbour_list.rs` says
//! which):
//!
//! | pass | reads | writes |
//! | --- | --- | --- |
//! | forces: entries and states of pairs | 21 | 2 |
//! | forces: positions, radii, predicted velocities | 80 | |
//! | forces: masses, histories | 76 | 46 |
//! | forces: records (normal, tangential force, force, overlap) | 122 | 122 |
//! | motion: contacts that act, records | 146 | |
//! | motion: positions, velocities, orientations, inertia, references | 152 | 112 |
//! | motion: predicted velocities (fetched before they are overwritten) | 48 | 48 |
//! | sum | 645 | 330 |
//!
//! About 500 floating-point operations go with these thousand bytes, so that memory is what counts.
//! Blocks of spheres follow Morton's curve; every array is walked from its beginning to its end,
//! and what is reached through an index is asked for some contacts ahead; so are the lists, because
//! no processor follows as many arrays by itself. Contacts of one linear law are computed eight at
//! once.
//!
//! Bodies of very different sizes are listed in classes of sizes (`size_classes.rs`), each with a
//! skin and cells of its own: what a list takes grows with the number of bodies alone.
//!
//! # Same bits
//!
//! Equal scenes and parameters give equal bits, on any number of threads: a body sums its forces in
//! the order of the others' ids, random numbers are keyed by seed and index, and no function of the
//! system's mathematics library is used. When neighbours are listed, and where bodies stand in
//! memory, enters no result of spheres among themselves; beside parts that they move, another skin
//! was seen to change last bits. A body far away changes no bit of the others.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod bodies;
mod contact;
mod forces;
mod grains;
mod math;
mod neighbours;
mod polyhedra;
mod setup;
mod solver;
mod walls;

#[cfg(feature = "component")]
pub use grains::{benchmark::benchmarks, component};

pub use bodies::deformable_surface::{DeformableSurface, FacetLoad, SurfaceState};
pub use bodies::drag_bands::DragBandState;
pub use bodies::slider::SliderState;
pub use grains::findings::{findings, limits};
pub use math::damping::{damping_ratio, restitution};
pub use math::debris;
pub use math::error::GrainsError;
pub use math::parameters::{Integrator, Lubrication, Parameters};
pub use setup::check_clumps::ClumpOverlap;
pub use setup::resolution::{PairDamping, Resolution};
pub use setup::slider_times::SliderTimes;
pub use setup::softness::{Overlap, Softness};
pub use solver::dem_solver::GrainsDem;
pub use solver::diagnostics::Diagnostics;
pub use solver::exchange::AddedSphere;
pub use solver::ports::{InletState, OutletState, Room};
pub use solver::probes::probe_signals;

/// A vector in the world frame.
type Vec3 = nalgebra::Vector3<f64>;
