//! Finite elements of the section at large deformation.

mod assembly;
mod compress;
pub mod contact;
pub mod element;
mod equilibrium;
mod hold;
mod skyline;

pub use assembly::{Model, State};
pub use compress::{Compression, Frame, Stuck, compress};
pub use equilibrium::Failure;
pub use hold::{Axial, Hold, ModelError};
