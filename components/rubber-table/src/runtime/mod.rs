//! A seal in a run: one number for the ring, its compression, found anew in each step.
//!
//! The loads on the ring's surface become one force ([`effective_force`]), and the compression
//! follows from it implicitly ([`Step`]). A [`Seal`] does both for a surface of a scene, trial by
//! trial.

mod facets;
mod force;
mod placed;
mod seal;
mod search;
mod step;

pub use force::{EffectiveForce, Form, Sums, effective_force};
pub use seal::{Readings, Seal, SealError, Water};
pub use step::{Eta, Impedance, Law, Outcome, Settled, Start, Step, StepError, relax};
