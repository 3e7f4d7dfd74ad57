//! A rigid body as the search for neighbours and a contact see it: bounding sphere, velocities,
//! mobility.

use crate::Vec3;
use serde::{Deserialize, Serialize};

/// Marks a body that is in no clump.
pub const ALONE: u32 = u32::MAX;

/// A sphere in space, or that around a polyhedron: what the search for contacts reads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct BoundingSphere {
    /// Centre [m].
    pub x: Vec3,
    /// Radius [m].
    pub radius: f64,
}

/// Velocity and angular velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Twist {
    /// Velocity of the centre [m/s].
    pub v: Vec3,
    /// Angular velocity [rad/s].
    pub w: Vec3,
}

impl Twist {
    /// At rest.
    pub fn zero() -> Self {
        Self { v: Vec3::zeros(), w: Vec3::zeros() }
    }

    /// Adds what accelerations, of the velocity and the angular velocity, give in a time [s].
    #[inline(always)]
    pub fn kick(&mut self, acceleration: &Twist, time: f64) {
        self.v += acceleration.v * time;
        self.w += acceleration.w * time;
    }
}

/// Inverse mass and inverse inertia; both 0 for a body whose motion is given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mobility {
    /// `1/m` [1/kg]; of a body in a clump that of the clump.
    pub inverse_mass: f64,
    /// `1/(2/5 m R²)` [1/(kg·m²)]; 0 for a polyhedron, which turns by itself, and in a clump.
    pub inverse_inertia: f64,
    /// The clump that the body belongs to, or [`ALONE`].
    pub clump: u32,
}

impl Mobility {
    /// Mobility of a wall, or of a body whose motion is given.
    pub const NONE: Self = Self { inverse_mass: 0.0, inverse_inertia: 0.0, clump: ALONE };

    /// `sqrt(m*)` of a pair, where a body of given motion counts as infinitely heavy [kg^(1/2)].
    pub fn root_reduced_mass(self, other: Self) -> f64 {
        (1.0 / (self.inverse_mass + other.inverse_mass)).sqrt()
    }

    /// Mean of the masses of a pair, of those that forces move [kg].
    pub fn mean_mass(self, other: Self) -> f64 {
        match (self.is_free(), other.is_free()) {
            (true, true) => 0.5 * (1.0 / self.inverse_mass + 1.0 / other.inverse_mass),
            (false, true) => 1.0 / other.inverse_mass,
            _ => 1.0 / self.inverse_mass,
        }
    }

    /// True if forces move the body.
    pub fn is_free(self) -> bool {
        self.inverse_mass > 0.0
    }

    /// True if the body is part of a clump.
    pub fn is_joined(self) -> bool {
        self.clump != ALONE
    }

    /// True if two bodies can touch: forces move at least one, and they are not of the same clump.
    #[inline(always)]
    pub fn meets(self, other: Self) -> bool {
        (self.is_free() || other.is_free()) && (self.clump != other.clump || !self.is_joined())
    }
}
