//! Errors of the fluid at run time.

use crate::lattice::reservoir_place::ReservoirPlace;
use tremie_messages::finding::short;

/// A fault of a running fluid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FluidError {
    /// The states are not those of the living bodies, sorted by id.
    #[error(
        "the fluid expected the state of body {expected} in place {place} of {count}, found {found}; \
         states must be those of the living bodies, sorted by id"
    )]
    Bodies {
        /// Place in the list.
        place: usize,
        /// Number of living bodies.
        count: usize,
        /// Id that belongs there, as text (or "the end of the list").
        expected: String,
        /// Id that stood there, as text (or "the end of the list").
        found: String,
    },
    /// The list of loads does not have one place for each state.
    #[error("the fluid was given room for {room} loads, but {bodies} bodies")]
    Room {
        /// Length of the list of loads.
        room: usize,
        /// Number of states.
        bodies: usize,
    },
    /// A body's state holds a number that is not finite.
    #[error("the state of body {id} holds a number that is not finite")]
    NonFiniteBody {
        /// Id of the body.
        id: u64,
    },
    /// A body that is added is already there.
    #[error("body {id} was added twice")]
    AddedTwice {
        /// Id of the body.
        id: u64,
    },
    /// A body that is removed is not there.
    #[error("body {id} was removed, but it is not there")]
    NotThere {
        /// Id of the body.
        id: u64,
    },
    /// An event of a kind or shape that this fluid does not know.
    #[error(
        "event of kind {kind} with shape {shape} for body {id}: this fluid knows added and removed spheres, parts and polyhedra"
    )]
    UnknownEvent {
        /// Id of the body.
        id: u64,
        /// Kind of the event.
        kind: u32,
        /// Shape of the body.
        shape: u32,
    },
    /// A body that is a part which the scene does not have, or which stands still.
    #[error(
        "body {id} is part {part} of the scene, which has no moving part of that number among its {parts}"
    )]
    UnknownPart {
        /// Id of the body.
        id: u64,
        /// Index of the part.
        part: u64,
        /// Parts of the scene.
        parts: usize,
    },
    /// A polyhedron of a shape that the scene does not have, or of which no surface can be made at
    /// its size.
    #[error(
        "body {id} is a polyhedron of shape {shape} of the scene, of which there is none to be made among its {shapes}"
    )]
    UnknownShape {
        /// Id of the body.
        id: u64,
        /// Index of the shape.
        shape: u64,
        /// Shapes of the scene.
        shapes: usize,
    },
    /// A sphere with a radius that is not positive and finite.
    #[error("body {id} has the radius {radius} m; it must be positive")]
    Radius {
        /// Id of the body.
        id: u64,
        /// Radius [m].
        radius: f64,
    },
    /// A sphere that would meet itself through periodic faces, or is larger than the whole domain.
    #[error("body {id} has the diameter {diameter} m, more than the edge {edge} m of the domain")]
    TooWide {
        /// Id of the body.
        id: u64,
        /// Diameter [m].
        diameter: f64,
        /// Edge of the domain [m].
        edge: f64,
    },
    /// Not as many vertices of deformable surfaces as the scene has.
    #[error(
        "the fluid expected {expected} vertices of deformable surfaces, found {found}; \
         all surfaces of the scene must be given before the start, in their order"
    )]
    Vertices {
        /// Number of vertices of the scene's deformable surfaces.
        expected: usize,
        /// Number of vertices given.
        found: usize,
    },
    /// A vertex holds a number that is not finite.
    #[error("vertex {vertex} of the deformable surfaces holds a number that is not finite")]
    NonFiniteVertex {
        /// Its number.
        vertex: usize,
    },
    /// The first vertices of a surface make no solid.
    #[error("the deformable surface {name} is no closed surface where it begins: {reason}")]
    Surface {
        /// Its name.
        name: String,
        /// Why.
        reason: String,
    },
    /// The fluid is no longer finite.
    #[error(
        "the fluid is not finite in cell {cell:?} at ({}, {}, {}) m: {value}; \
         a larger relaxation time, a smaller time step or a finer cell makes the run stable",
        short(position[0]), short(position[1]), short(position[2])
    )]
    NonFinite {
        /// Cell.
        cell: [usize; 3],
        /// Its centre [m].
        position: [f64; 3],
        /// Value found there.
        value: String,
    },
    /// The piston of a reservoir has come to the face.
    #[error(
        "the reservoir at {} is spent at {time} s: {left:.1} % of its {volume} m³ is left, and the piston may leave no \
         less than 5 %; a larger volume lasts longer, a stop before that time ends the stroke",
        place
    )]
    ReservoirSpent {
        /// Where the reservoir is.
        place: ReservoirPlace,
        /// Volume that is left [%].
        left: f64,
        /// Volume at time zero [m³].
        volume: f64,
        /// Time [s].
        time: f64,
    },
    /// The fluid passes the face of a reservoir too fast for the lattice.
    #[error(
        "the fluid passes the reservoir at {} with {speed:.4} m/s (limit {limit:.4} m/s, a tenth of a cell a step) \
         while the gauge pressure there is {pressure:.4e} Pa; a smaller time step raises the limit, a slower ramp of the \
         piston lowers the speed",
        place
    )]
    ReservoirFlow {
        /// Where the reservoir is.
        place: ReservoirPlace,
        /// Largest speed through the face or surface [m/s].
        speed: f64,
        /// Limit [m/s].
        limit: f64,
        /// Gauge pressure of the reservoir [Pa].
        pressure: f64,
    },
    /// The fluid moves too fast for a nearly incompressible flow.
    #[error(
        "the fluid moves at {speed:.4} m/s (Mach {mach:.3}, limit {limit}) in cell {cell:?} at ({}, {}, {}) m; \
         a time step of at most {remedy:.3e} s would keep the limit; so does a larger expected_speed of the \
         scene's fluid, where that sets the step",
        short(position[0]), short(position[1]), short(position[2])
    )]
    Mach {
        /// Cell.
        cell: [usize; 3],
        /// Its centre [m].
        position: [f64; 3],
        /// Speed [m/s].
        speed: f64,
        /// Speed over the lattice's speed of sound.
        mach: f64,
        /// Largest Mach number allowed.
        limit: f64,
        /// A time step that would keep the limit [s].
        remedy: f64,
    },
}
