//! Space: the box that wraps around, plane walls, triangles of walls, rigid bodies and solids in it.

pub mod part_surface;
pub mod periodic;
pub mod plane_walls;
pub mod rigid_body;
pub mod solid_part;
pub mod wall_triangle;
