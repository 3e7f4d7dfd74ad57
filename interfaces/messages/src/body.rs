//! Bodies: rigid things with an id of their own, and the loads on them.

use crate::Message;
use serde::{Deserialize, Serialize};

/// Pose and velocity of a body, world frame, SI units. 112 bytes.
///
/// The `state` channel carries one for each living body, sorted by id.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Id of the body, never reused in a run.
    pub id: u64,
    /// Reference point (a sphere's centre) [m].
    pub position: [f64; 3],
    /// Unit quaternion `(x, y, z, w)` from body frame to world frame.
    pub orientation: [f64; 4],
    /// Velocity of the reference point [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}

/// Force on a body and torque about its reference point, world frame. 56 bytes.
///
/// The `load` channel carries one for each body of the state that it answers, in the same order.
/// Loads of a fluid include buoyancy; grains always apply the full weight.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Id of the body.
    pub id: u64,
    /// Force [N].
    pub force: [f64; 3],
    /// Torque about the reference point [N·m].
    pub torque: [f64; 3],
}

/// A body that appears or disappears at the end of a window. 64 bytes.
///
/// The `events` channel carries the list of each window, even an empty one, before the state of
/// the same window. The initial bodies are the first list (number 0, in the start exchange).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyEvent {
    /// Id of the body.
    pub id: u64,
    /// Kind of event: [`BodyEvent::ADDED`] or [`BodyEvent::REMOVED`].
    pub kind: u32,
    /// Shape of an added body: [`BodyEvent::SPHERE`], [`BodyEvent::PART`],
    /// [`BodyEvent::POLYHEDRON`] or [`BodyEvent::CYLINDER`].
    pub shape: u32,
    /// Motion of an added body: [`BodyEvent::FREE`], [`BodyEvent::FIXED`],
    /// [`BodyEvent::PRESCRIBED`] or [`BodyEvent::SLIDER`].
    pub motion: u32,
    /// Index into the scene's list of body sets that the body came from.
    pub set: u32,
    /// Mass [kg]; 0 for a part whose motion is prescribed.
    pub mass: f64,
    /// Size of the shape [m]: `[radius, 0, 0]` for a sphere; for a part the radius about its
    /// reference point that holds it; for a polyhedron that radius, and the diameter of a sphere of
    /// equal volume; for a cylinder its radius and its length.
    pub size: [f64; 3],
    /// Index into the scene's list of parts, for a part, or of shapes, for a polyhedron; else 0.
    pub table: u64,
}

impl BodyEvent {
    /// The body is there from this window's end on.
    pub const ADDED: u32 = 1;
    /// The body is gone from this window's end on.
    pub const REMOVED: u32 = 2;
    /// A sphere.
    pub const SPHERE: u32 = 1;
    /// A part of the scene, its surface in the body's frame.
    pub const PART: u32 = 2;
    /// A convex polyhedron of a shape of the scene.
    pub const POLYHEDRON: u32 = 3;
    /// A cylinder across the plane of a plane scene.
    pub const CYLINDER: u32 = 4;
    /// Moves under forces.
    pub const FREE: u32 = 0;
    /// Never moves.
    pub const FIXED: u32 = 1;
    /// Moves as the scene says, whatever the forces.
    pub const PRESCRIBED: u32 = 2;
    /// Moves along one axis under forces.
    pub const SLIDER: u32 = 3;
}

// SAFETY: 14 words of 8 bytes, no padding.
unsafe impl Message for BodyState {
    const TYPE_NAME: &'static str = "tremie.BodyState.1";
}
// SAFETY: 7 words of 8 bytes, no padding.
unsafe impl Message for Load {
    const TYPE_NAME: &'static str = "tremie.Load.1";
}
// SAFETY: 8 + 4 x 4 + 8 + 24 + 8 bytes, no padding.
unsafe impl Message for BodyEvent {
    const TYPE_NAME: &'static str = "tremie.BodyEvent.1";
}

impl BodyState {
    /// A body at rest at `position`.
    pub fn at_rest(id: u64, position: [f64; 3]) -> Self {
        Self {
            id,
            position,
            orientation: [0.0, 0.0, 0.0, 1.0],
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        }
    }

    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        let all = |v: &[f64]| v.iter().all(|x| x.is_finite());
        all(&self.position)
            && all(&self.orientation)
            && all(&self.velocity)
            && all(&self.angular_velocity)
    }
}

impl Load {
    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.force.iter().chain(&self.torque).all(|x| x.is_finite())
    }
}
