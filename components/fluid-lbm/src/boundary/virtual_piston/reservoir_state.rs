//! What a reservoir is like at the end of a step, and the reservoirs of a scene.

use crate::lattice::reservoir_place::ReservoirPlace;
use tremie_messages::scene::{Face, PartBoundary, Reservoir, Scene};
use tremie_messages::start::SignalRow;

/// State of a reservoir at the end of a step, SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReservoirState {
    /// Where it is.
    pub place: ReservoirPlace,
    /// Density of the reservoir [kg/m³].
    pub density: f64,
    /// Its gauge pressure [Pa].
    pub pressure: f64,
    /// Volume between piston and face or surface [m³], as the scene counts it.
    pub volume: f64,
    /// Velocity of the piston towards the domain [m/s].
    pub piston: f64,
    /// Mean velocity through the face or surface into the domain [m/s].
    pub velocity: f64,
    /// Mass that has entered the domain [kg], as the balance of the fluid counts it.
    pub entered: f64,
    /// Mass in the reservoir [kg], counted alike.
    pub mass: f64,
}

/// The reservoirs of a scene and where they are: those at faces first, then those of parts.
pub fn reservoirs_of(scene: &Scene) -> impl Iterator<Item = (ReservoirPlace, &Reservoir)> {
    let faces = scene.domain.faces.iter().flatten().enumerate();
    let of_faces = faces.filter_map(|(k, face)| match face {
        Face::Reservoir(reservoir) => {
            Some((ReservoirPlace::Face { axis: k / 2, side: k % 2 }, reservoir))
        }
        _ => None,
    });
    let of_parts =
        scene.parts.iter().enumerate().filter_map(|(index, part)| match &part.boundary {
            PartBoundary::Reservoir(reservoir) => Some((ReservoirPlace::Part(index), reservoir)),
            _ => None,
        });
    of_faces.chain(of_parts)
}

/// Signals of each reservoir, named `reservoir_z_lower.density`, or by the part `reservoir_inlet.density`.
pub const OF_RESERVOIRS: [SignalRow<ReservoirState>; 6] = [
    ("density", "kg/m3", "density of the fluid in the reservoir", |r| r.density),
    ("pressure", "Pa", "gauge pressure there, a mean over the fluid", |r| r.pressure),
    ("volume", "m3", "volume between piston and face or surface", |r| r.volume),
    ("piston_velocity", "m/s", "velocity of the piston towards the domain", |r| r.piston),
    ("velocity", "m/s", "mean velocity through the face or surface into the domain", |r| {
        r.velocity
    }),
    ("mass_entered", "kg", "mass that has entered the domain since the start", |r| r.entered),
];

impl ReservoirState {
    /// The values of the reservoir's signals, in their order.
    pub fn values(&self) -> [f64; 6] {
        OF_RESERVOIRS.map(|(_, _, _, value)| value(self))
    }
}
