//! Spheres and rigid parts: state, prescribed motion, loads, the order in messages.

pub mod body_arrays;
pub mod deformable_surface;
pub mod drag_bands;
pub mod events;
pub mod loads;
pub mod mesh_contact;
pub mod message_order;
pub mod mirrors;
pub mod placed_parts;
pub mod prescribed_spheres;
pub mod slider;
pub mod springs;
