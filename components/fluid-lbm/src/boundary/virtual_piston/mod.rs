//! ZIEB, zoom-in with effective boundaries (Mutabaruka & Kamrin 2018, sec. 2.6): a far piston and
//! its reservoir as a boundary condition. `cylinder` solves for the density of the reservoir (Eqs.
//! 29, 30), `face` gives it to the cells (Eq. 31).

pub mod cylinder;
pub mod face;
