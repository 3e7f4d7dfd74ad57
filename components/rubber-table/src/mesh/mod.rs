//! The section of a seal as quadrilaterals, with names for parts of its outline.

pub(crate) mod bilinear;
mod quadrilaterals;
mod reverse_cuthill_mckee;
mod shapes;

pub use quadrilaterals::{Mesh, MeshError, Point};
pub use shapes::{d_ring, o_ring, rectangle};
