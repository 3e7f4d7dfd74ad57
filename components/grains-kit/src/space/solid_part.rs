//! A rigid part as bodies that are placed see it.

use crate::Vec3;

/// A rigid part, of which bodies that are placed keep clear.
pub trait SolidPart: Sync {
    /// Distance of a point of the world from the surface [m], negative in the solid, and the unit
    /// vector along which it grows.
    fn clearance(&self, x: Vec3) -> (f64, Vec3);

    /// True if the space inside the surface is free and the space outside is solid.
    fn is_cavity(&self) -> bool;

    /// True if bodies see the part through an image displaced by `shift`. An endless part needs no
    /// image along its endless axes.
    fn is_seen(&self, shift: Vec3) -> bool;
}
