//! Finite elements of the section at large deformation.

mod assembly;
mod boundary_conditions;
pub mod contact;
pub mod element;
mod load_path;
pub mod material;
mod newton;
mod skyline;

pub use assembly::{Model, State};
pub use boundary_conditions::{Axial, Hold, ModelError};
pub use load_path::{Compression, Frame, Stuck, compress};
pub use newton::Failure;
