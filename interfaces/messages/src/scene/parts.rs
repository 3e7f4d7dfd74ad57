//! Rigid parts with triangulated surfaces.

use super::{Course, Motion, Reservoir};
use serde::{Deserialize, Serialize};

/// A rigid part: a closed surface, put somewhere.
///
/// A fixed part is known to all components from the scene alone. One that moves is a body besides:
/// the component that moves the bodies announces it, and its pose is that of the body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Name, unique among the parts of the scene.
    pub name: String,
    /// Surface, in the part's own frame.
    pub geometry: Geometry,
    /// Pose of that frame at the start.
    pub pose: Pose,
    /// The space inside the surface is free and the space outside is solid; otherwise the inside is
    /// solid.
    pub cavity: bool,
    /// Name of the material, for contacts.
    pub material: String,
    /// Motion, about the origin of the frame.
    pub motion: Motion,
    /// Boundary condition for the fluid.
    pub boundary: PartBoundary,
}

/// A closed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Geometry {
    /// Triangles from a file, STL (binary or text) or OBJ.
    File {
        /// Absolute path; in a recording from the folder of its run.
        path: String,
        /// Length of one unit of the file [m].
        unit: f64,
    },
    /// A box about the origin.
    Box {
        /// Edge lengths [m].
        size: [f64; 3],
    },
    /// A cylinder about the z axis, its middle at the origin.
    Cylinder {
        /// Radius [m].
        radius: f64,
        /// Length along z [m].
        length: f64,
    },
    /// A sphere about the origin.
    Sphere {
        /// Radius [m].
        radius: f64,
    },
    /// Solid of revolution of a profile about the z axis: a nozzle, a valve, a ring.
    Revolved {
        /// Corners `[r, z]` of the profile [m], either way round. A profile that begins and ends on
        /// the axis is closed by it; any other is closed by its last edge, from the last corner to
        /// the first.
        profile: Vec<[f64; 2]>,
    },
    /// A prism along an axis, its middle at the origin there: a wedge, a step, a channel's wall.
    Extruded {
        /// Corners of its section [m], either way round, in the other two axes in their order: in
        /// `[x, y]` along z, in `[x, z]` along y. No edge meets another.
        outline: Vec<[f64; 2]>,
        /// The axis of the part's frame: 0, 1, 2 for x, y, z.
        axis: usize,
        /// Length along the axis [m].
        length: f64,
    },
}

/// Position and orientation of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Its origin [m].
    pub position: [f64; 3],
    /// Unit quaternion `(x, y, z, w)` from it to the world.
    pub orientation: [f64; 4],
}

impl Pose {
    /// The world's frame.
    pub const IDENTITY: Self = Self { position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] };
}

/// Boundary condition that a part sets to the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PartBoundary {
    /// A wall without slip, at the part's velocity.
    Wall,
    /// The fluid leaves the part's surface with a velocity.
    Velocity {
        /// Velocity [m/s].
        velocity: [f64; 3],
        /// Factor on the velocity over time.
        course: Course,
    },
    /// The fluid comes and goes through the part's surface at a gauge pressure.
    Pressure {
        /// Gauge pressure, without its hydrostatic part [Pa].
        pressure: f64,
        /// Factor on the pressure over time.
        course: Course,
    },
    /// The fluid comes from, and goes to, a reservoir with a piston that is not simulated, through the
    /// side of the part that the fluid touches.
    Reservoir(Reservoir),
}
