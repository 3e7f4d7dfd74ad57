//! Contacts with boundaries: planes, parts, and surfaces that deform.

pub mod contact_rows;
pub mod deformable_surfaces;
pub mod part_contacts;
pub mod part_finder;
pub mod part_forces;
pub mod reached_walls;
pub mod rigid_seat_contact;
pub mod surface_contacts;
pub mod wall_contacts;
pub mod wall_forces;
