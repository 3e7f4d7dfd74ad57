//! The scene: geometry, materials, boundaries, bodies. One description, read by all components.
//!
//! All numbers are SI; the manifest's units were resolved before.

use serde::{Deserialize, Serialize};

/// What is simulated, independent of how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Acceleration of gravity [m/s²]. Grains apply it to their mass; a fluid includes buoyancy.
    pub gravity: [f64; 3],
    /// The box in which everything happens.
    pub domain: Domain,
    /// The fluid's material; `None` for a dry run.
    pub fluid: Option<FluidMaterial>,
    /// Walls inside the domain besides its faces, seen by grains; a fluid that cannot honour them refuses.
    pub planes: Vec<Plane>,
    /// The bodies, in sets of one material and motion.
    pub bodies: Vec<BodySet>,
    /// Contact law between bodies, and between a body and a wall.
    pub contacts: Option<Contacts>,
}

/// An axis-aligned box and what its six faces are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner [m].
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Faces by axis: `[lower, upper]`. Either both faces of an axis are periodic, or none.
    pub faces: [[Face; 2]; 3],
}

impl Domain {
    /// Edge lengths [m].
    pub fn size(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.max[a] - self.min[a])
    }

    /// Whether the axis wraps around.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.faces[axis][0] == Face::Periodic
    }
}

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Face {
    /// Joined to the opposite face.
    Periodic,
    /// A wall: no slip for the fluid, a plane for grains.
    Wall,
}

/// A fluid's material and what drives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidMaterial {
    /// Density [kg/m³].
    pub density: f64,
    /// Dynamic viscosity [Pa·s].
    pub viscosity: f64,
    /// Acceleration that drives the fluid, besides gravity [m/s²] (a mean pressure gradient over density).
    /// Gravity itself is balanced by hydrostatic pressure and enters as buoyancy of the bodies.
    pub acceleration: [f64; 3],
    /// Velocity at the start [m/s].
    pub velocity: [f64; 3],
    /// Largest speed that the user expects [m/s]; a fluid checks its Mach number against it.
    pub expected_speed: Option<f64>,
}

/// A plane wall; bodies are on the side to which the normal points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// A point on the plane [m].
    pub point: [f64; 3],
    /// Unit normal, into the space of the bodies.
    pub normal: [f64; 3],
}

/// Bodies of one material and one kind of motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySet {
    /// Name, unique in the scene.
    pub name: String,
    /// Density [kg/m³].
    pub density: f64,
    /// How the bodies move.
    pub motion: Motion,
    /// Where they are at the start.
    pub placement: Placement,
}

/// Kinematic law of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Motion {
    /// Moves under forces.
    Free,
    /// Never moves.
    Fixed,
    /// Keeps the velocity and angular velocity that it was placed with.
    Prescribed,
}

/// Where the bodies of a set are at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Placement {
    /// Each sphere given.
    Listed(Vec<Sphere>),
    /// Spheres packed at random, without overlap, into a region up to a solid fraction.
    Packed(Packing),
}

/// A sphere at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre [m].
    pub position: [f64; 3],
    /// Diameter [m].
    pub diameter: f64,
    /// Velocity [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}

/// A random packing made at start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Packing {
    /// Lower corner of the region [m]; whole spheres lie inside the region.
    pub min: [f64; 3],
    /// Upper corner of the region [m].
    pub max: [f64; 3],
    /// Volume of the spheres over volume of the region.
    pub fraction: f64,
    /// Their diameters.
    pub diameters: Diameters,
    /// Seed of the random numbers; equal seeds give equal packings.
    pub seed: u64,
}

/// Diameters of a packing [m].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Diameters {
    /// Uniformly distributed between two bounds (equal bounds: all alike).
    Uniform {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Drawn from a list, each entry equally likely.
    Listed(Vec<f64>),
}

/// Contact laws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contacts {
    /// Between two bodies.
    pub body_body: ContactLaw,
    /// Between a body and a wall.
    pub body_wall: ContactLaw,
}

/// Linear spring, dashpot and friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactLaw {
    /// Normal stiffness [N/m].
    pub normal_stiffness: f64,
    /// Tangential stiffness [N/m].
    pub tangential_stiffness: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Damping.
    pub damping: Damping,
    /// Whether the dashpot may pull before two bodies separate (the form that most papers print).
    pub tension: bool,
}

/// How damping of a contact is given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Damping {
    /// By the coefficient of restitution; the dashpot then depends on the masses of the pair, and
    /// the tangential one is the normal one times `sqrt(k_t/k_n)`.
    Restitution(f64),
    /// By the dashpots' coefficients [kg/s].
    Coefficients {
        /// Normal.
        normal: f64,
        /// Tangential.
        tangential: f64,
    },
}
