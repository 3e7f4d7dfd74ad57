//! The law of one contact: spring, dashpot, friction, rolling, lubrication, and the history of a
//! contact.

pub mod contact_force;
pub mod contact_history;
pub mod contact_law;
pub mod friction;
pub mod linear_contact;
pub mod lubrication;
pub mod material_laws;
pub mod plane_walls;
pub mod region_shares;
pub mod springs;
pub mod stability;
