//! ZIEB, zoom-in with effective boundaries (Mutabaruka & Kamrin 2018, sec. 2.6): a far piston and
//! its reservoir as a boundary condition. `cylinder` solves for the density of the reservoir (Eqs.
//! 29, 30), `face` gives it to the cells at a face of the domain (Eq. 31), `part_surface` to those at a
//! part, which may face any way.

pub mod cylinder;
pub mod face;
pub mod part_surface;
pub mod reservoir_state;
