//! The domain: a box, boundary conditions at its faces, and the fluid in it.

use super::course::Course;
use super::fill::Fill;
use super::gas::GasMaterial;
use super::reservoir::Reservoir;
use core::f64::consts::PI;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An axis-aligned box and the boundary conditions of its six faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner [m].
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Faces by axis: `[lower, upper]`. Either both faces of an axis are periodic, or none.
    pub faces: [[Face; 2]; 3],
    /// Heights of the free surface beyond open faces, on the axis along which gravity acts [m]: by
    /// axis, `[lower, upper]`. A fluid with a free surface asks for them.
    #[serde(default, skip_serializing_if = "no_levels")]
    pub levels: [[Option<f64>; 2]; 3],
    /// Material of the faces, for contacts of grains.
    pub material: String,
    /// The axis across a plane scene, along which nothing varies. Round bodies are then cylinders
    /// across the plane, as long as the domain is deep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<usize>,
}

impl Domain {
    /// The default material of faces.
    pub const MATERIAL: &str = "wall";

    /// A box with the given faces, of the usual material.
    pub fn new(min: [f64; 3], max: [f64; 3], faces: [[Face; 2]; 3]) -> Self {
        let levels = [[None; 2]; 3];
        Self { min, max, faces, levels, material: Self::MATERIAL.into(), across: None }
    }

    /// Edge lengths [m].
    pub fn size(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.max[a] - self.min[a])
    }

    /// Depth of a plane scene [m].
    pub fn depth(&self) -> Option<f64> {
        self.across.map(|axis| self.size()[axis])
    }

    /// Volume of a round body of a diameter [m³]: of a sphere, in a plane scene of a cylinder.
    pub fn body_volume(&self, diameter: f64) -> f64 {
        match self.depth() {
            Some(depth) => 0.25 * PI * diameter * diameter * depth,
            None => PI / 6.0 * diameter * diameter * diameter,
        }
    }

    /// True if the axis wraps around.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.faces[axis][0] == Face::Periodic
    }
}

fn no_levels(levels: &[[Option<f64>; 2]; 3]) -> bool {
    levels.iter().flatten().all(Option::is_none)
}

/// A face of the domain.
///
/// Grains meet every face but a periodic one as a plane: of the domain's material, or without
/// friction where the face is a symmetry plane. An open face holds grains back like a sieve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Face {
    /// Joined to the opposite face.
    Periodic,
    /// No slip for the fluid, which moves along with the face.
    Wall {
        /// Velocity of the wall along itself [m/s]; its normal part is zero.
        velocity: [f64; 3],
        /// Factor on the velocity over time.
        #[serde(default, skip_serializing_if = "Course::is_constant")]
        course: Course,
    },
    /// A mirror: no flow through it, no friction along it.
    Symmetry,
    /// The fluid enters, or leaves, with a given velocity.
    Velocity(OpenVelocity),
    /// The fluid comes and goes at a given gauge pressure.
    Pressure {
        /// Gauge pressure, without its hydrostatic part [Pa].
        pressure: f64,
        /// Factor on the pressure over time.
        course: Course,
        /// Way in which what arrives from inside leaves.
        #[serde(default)]
        outflow: Outflow,
    },
    /// The fluid comes from, and goes to, a reservoir with a piston that is not simulated.
    Reservoir(Reservoir),
}

impl Face {
    /// A wall at rest.
    pub const WALL: Self = Self::Wall { velocity: [0.0; 3], course: Course::CONSTANT };
    /// Walls at rest all around.
    pub const WALLS: [[Self; 2]; 3] = [const { [Self::WALL, Self::WALL] }; 3];

    /// A wall that moves along itself with a constant velocity [m/s].
    pub fn moving(velocity: [f64; 3]) -> Self {
        Self::Wall { velocity, course: Course::CONSTANT }
    }

    /// True if fluid may pass.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Velocity(_) | Self::Pressure { .. } | Self::Reservoir(_))
    }
}

/// Ways in which what arrives at a face with a pressure leaves through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Outflow {
    /// The pressure holds all over the face at any time, and throws sound back.
    #[default]
    Fixed,
    /// Sound passes through; the pressure holds on average over the time that sound takes to cross
    /// the domain a few times.
    Absorbing,
    /// What arrives is carried out with the face's mean velocity `U`, as `df/dt + U df/dn = 0`:
    /// vortices and wakes pass; the pressure holds on average, as at an absorbing face.
    Convective,
}

/// A velocity given at a face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenVelocity {
    /// Velocity [m/s]: everywhere, or at the middle of a parabolic profile.
    pub velocity: [f64; 3],
    /// Profile over the face.
    pub profile: Profile,
    /// Factor over time.
    pub course: Course,
}

/// Variation of a velocity over a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Not at all.
    Uniform,
    /// A parabola, zero at the edges, along each edge of the face that does not wrap around: the
    /// factor is the product of `4 s (1 - s)`, `s` running from 0 to 1 along the edge.
    Parabolic,
}

/// A fluid: its material, its driving acceleration, its state at the start, and its extent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidMaterial {
    /// Density [kg/m³].
    pub density: f64,
    /// Dynamic viscosity [Pa·s].
    pub viscosity: f64,
    /// Acceleration that drives the fluid, besides gravity [m/s²] (a mean pressure gradient over
    /// density). Gravity itself is balanced by hydrostatic pressure and enters as buoyancy of the
    /// bodies.
    pub acceleration: [f64; 3],
    /// Velocity at the start [m/s].
    pub velocity: [f64; 3],
    /// Gauge pressure at the start, without its hydrostatic part [Pa].
    pub pressure: f64,
    /// Largest speed that the user expects [m/s]; a fluid checks its Mach number against it.
    pub expected_speed: Option<f64>,
    /// Points in the fluid [m]: there is fluid only where a way leads to one of them. Without any,
    /// everything that is not solid is fluid.
    pub inside: Vec<[f64; 3]>,
    /// Points that no way may lead to [m]: a fluid that reaches one leaks, and is refused.
    pub outside: Vec<[f64; 3]>,
    /// Regions that hold fluid at the start; without any it fills its space and has no surface.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fill: Vec<Fill>,
    /// The law of a gas that is compressed; a fluid that is not leaves it out of account.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gas: Option<GasMaterial>,
}

impl FluidMaterial {
    /// A fluid at rest that nothing drives, wherever there is space.
    pub fn at_rest(density: f64, viscosity: f64) -> Self {
        Self {
            density,
            viscosity,
            acceleration: [0.0; 3],
            velocity: [0.0; 3],
            pressure: 0.0,
            expected_speed: None,
            inside: Vec::new(),
            outside: Vec::new(),
            fill: Vec::new(),
            gas: None,
        }
    }
}

/// A plane wall; bodies are on the side to which the normal points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// A point on the plane [m].
    pub point: [f64; 3],
    /// Unit normal, into the space of the bodies.
    pub normal: [f64; 3],
    /// Its material, for contacts.
    pub material: String,
}
