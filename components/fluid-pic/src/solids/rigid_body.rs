//! Rigid bodies in the fluid.

/// A disc (two dimensions) or sphere (three) in the fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody<const D: usize> {
    /// Centre [m].
    pub centre: [f64; D],
    /// Radius [m].
    pub radius: f64,
    /// Velocity of the centre [m/s].
    pub velocity: [f64; D],
    /// Mass [kg], in two dimensions per metre of depth [kg/m]; `None` for a body that moves as
    /// prescribed.
    pub mass: Option<f64>,
    /// Forces besides the fluid's, without weight [N], in two dimensions [N/m].
    pub force: [f64; D],
}
