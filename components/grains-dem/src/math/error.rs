//! Errors of a run of the grains, as they advance.

use thiserror::Error;
use tremie_grains_kit::checks::loads::LoadError;

/// Why an advance stopped. The state is then that of the failing substep and not to be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GrainsError {
    /// Loads of the fluid do not match the bodies or are not finite.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// Two bodies, or a body and a wall, overlap so much that the contact law means nothing.
    #[error(
        "body {id} overlaps {other} by {percent:.0} % of the smaller radius: reduce the time step, raise \
         the normal stiffness or lower the speeds"
    )]
    Overlap {
        /// Id of the body.
        id: u64,
        /// The other one, in words.
        other: String,
        /// Overlap over the smaller radius [%].
        percent: f64,
    },
    /// The lift of a slider is no number.
    #[error(
        "the slider of scene.parts[{part}] is nowhere: its motion has diverged; reduce the time step, or lower \
         the stiffness of its spring or stops"
    )]
    SliderLost {
        /// Index of the part.
        part: usize,
    },
    /// There are as many shapes as there are surfaces.
    #[error("{found} shapes for {expected} surfaces: give one for each, in their order")]
    SurfaceCount {
        /// Shapes given.
        found: usize,
        /// Surfaces.
        expected: usize,
    },
    /// There is no such surface.
    #[error("there is no surface {surface}: the run has {surfaces}")]
    NoSurface {
        /// Index asked for.
        surface: usize,
        /// Number of surfaces.
        surfaces: usize,
    },
    /// A shape has another number of vertices than its surface.
    #[error(
        "surface {surface} has {expected} vertices, but {found} places or velocities were given"
    )]
    SurfaceVertices {
        /// Index of the surface.
        surface: usize,
        /// Entries given.
        found: usize,
        /// Vertices.
        expected: usize,
    },
    /// A vertex is nowhere.
    #[error(
        "vertex {vertex} of surface {surface} is not finite: who moves the surface has diverged"
    )]
    SurfaceNotFinite {
        /// Index of the surface.
        surface: usize,
        /// Index of the vertex.
        vertex: usize,
    },
    /// Calls of a window come in another order than they must.
    #[error("{call} was called, but {first} comes first")]
    OutOfOrder {
        /// Name of the call that came too early.
        call: &'static str,
        /// Name of the call that must come before it.
        first: &'static str,
    },
    /// More spheres live than there is room for.
    #[error(
        "inlet \"{inlet}\" feeds more spheres than the {capacity} that there is room for: raise `capacity` in \
         settings.grains-dem, let spheres leave through an outlet, or give the inlet an end (`until`)"
    )]
    Capacity {
        /// Name of the inlet.
        inlet: String,
        /// Spheres that there is room for.
        capacity: usize,
    },
    /// The velocity of the fluid at a face is no number.
    #[error(
        "the fluid's velocity at face {side} across axis {axis} is not finite: the fluid has diverged"
    )]
    PortVelocity {
        /// The axis: 0, 1, 2 for x, y, z.
        axis: usize,
        /// 0 for the lower face, 1 for the upper.
        side: usize,
    },
    /// A body cannot be taken out.
    #[error("body {id} cannot be taken out: {why}")]
    NotRemovable {
        /// Id of the body.
        id: u64,
        /// The reason.
        why: &'static str,
    },
    /// A sphere cannot come in.
    #[error("sphere {index} of those that come in cannot be taken: {why}")]
    NotAddable {
        /// Position in the list.
        index: usize,
        /// The reason.
        why: &'static str,
    },
    /// A body is somewhere that is not a place in the domain.
    #[error(
        "body {id} left the domain at ({x:.6e}, {y:.6e}, {z:.6e}) m: reduce the time step, raise \
         the stiffness of walls, or, for a prescribed body, change its velocity"
    )]
    LeftDomain {
        /// Id of the body.
        id: u64,
        /// Coordinate [m]; not finite when the integration has diverged.
        x: f64,
        /// Coordinate [m].
        y: f64,
        /// Coordinate [m].
        z: f64,
    },
}
