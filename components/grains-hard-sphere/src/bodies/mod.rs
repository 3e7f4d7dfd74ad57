//! Spheres and discs on their free paths, and the walls and parts around them.

pub mod hard_body;
pub mod hard_parts;
pub mod hard_walls;
