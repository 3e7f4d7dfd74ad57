//! Gaps that are modelled: declared gaps, pockets, walls that slip.

pub mod far_fills;
pub mod modelled;
pub mod pockets;
pub mod specular_walls;
