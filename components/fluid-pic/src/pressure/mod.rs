//! The pressure of a step: a Poisson equation on cut cells, coupled to the velocities of bodies.
//!
//! The unknown is `q = p dt / (rho h)`, a velocity. With open fractions `E` of faces and, of each
//! body, the wrench `J` that a unit of `q` in a cell exerts on it, the equations of Chen, Zhang,
//! Zang & Ning (*J. Fluids Struct.* 91 (2019) 102772, Eqs. 4 to 6) become
//!
//! ```text
//! sum over faces E (q - q_beyond)  +  J^T S J q  =  - sum over faces +-E u*  -  J^T U*
//!        u = u* - (q - q_below),   U = U* + S J q,   S = rho h^D M^-1
//! ```
//!
//! which is symmetric and positive definite as soon as one cell borders on air.

pub mod body_coupling;
pub mod coarsen;
pub mod conjugate_gradients;
pub mod interpolation;
pub mod light_bodies;
pub mod multigrid;
pub mod stencil;
