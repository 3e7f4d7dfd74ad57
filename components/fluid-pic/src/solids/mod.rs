//! Solids that cut cells: open fractions of faces, and what cells exert on bodies.

pub mod ball_overlap;
pub mod half_spaces;
pub mod open_fractions;
pub mod rigid_body;
pub mod section;
pub mod surface_solid;
