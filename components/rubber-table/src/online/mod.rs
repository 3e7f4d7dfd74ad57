//! What a run does with the table: one number for the ring, its compression, found anew in each step.
//!
//! The loads on the ring's surface become one force ([`effective_force`]), and the compression follows
//! from it implicitly ([`Step`]).

mod force;
mod step;

pub use force::{EffectiveForce, Form, effective_force};
pub use step::{Eta, Impedance, Law, Outcome, Settled, Start, Step, StepError, relax};
