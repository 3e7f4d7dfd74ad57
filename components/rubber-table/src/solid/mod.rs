//! Finite elements of the section at large deformation.

mod assembly;
mod compress;
pub mod contact;
pub mod element;
mod equilibrium;
mod skyline;

pub use assembly::{Axial, Hold, Model, ModelError, State};
pub use compress::{Compression, Frame, Stuck, compress};
pub use equilibrium::Failure;
