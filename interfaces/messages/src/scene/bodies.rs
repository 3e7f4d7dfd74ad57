//! Sets of bodies: their motion, their sizes, their places at the start.

use super::{Course, Polyhedra, PolyhedronPlacement, Slider};
use core::f64::consts::PI;
use serde::{Deserialize, Serialize};

/// Spheres, or polyhedra of one shape, of one material and one kind of motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySet {
    /// Name, unique in the scene.
    pub name: String,
    /// Density [kg/m³].
    pub density: f64,
    /// Their material, for contacts.
    pub material: String,
    /// Motion of each body.
    pub motion: Motion,
    /// The clump that they belong to: bodies of all sets with this name are joined rigidly, and
    /// move as one. Where they overlap they do not touch. It is as heavy as they are together,
    /// unless [`super::Scene::unions`] names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clump: Option<String>,
    /// Places and sizes at the start.
    pub placement: Placement,
}

/// Kinematic law of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Motion {
    /// Moves under forces.
    Free,
    /// Never moves.
    Fixed,
    /// Moves with velocities that are linear in time between points, constant before the first and
    /// after the last, whatever the forces. Without points it keeps the velocity it was placed
    /// with.
    Prescribed(Vec<MotionPoint>),
    /// Moves with velocities times a factor over time, whatever the forces.
    Timed(Box<TimedMotion>),
    /// Moves along one axis under forces: parts only.
    Slider(Box<Slider>),
}

/// Velocities that go with a factor over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedMotion {
    /// Velocity of a part at the factor 1 [m/s]; of a set of bodies each has the one that it is
    /// placed with, and this is zero.
    pub velocity: [f64; 3],
    /// Angular velocity, likewise [rad/s].
    pub angular_velocity: [f64; 3],
    /// The factor.
    pub course: Course,
}

/// Velocities at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionPoint {
    /// Time [s]; points are in its order.
    pub time: f64,
    /// Velocity [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}

/// Placement of the bodies of a set at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Placement {
    /// Each sphere given.
    Listed(Vec<Sphere>),
    /// Spheres packed at random, without overlap, into a region up to a solid fraction.
    Packed(Packing),
    /// Convex polyhedra of one shape.
    Polyhedra(Polyhedra),
}

impl Placement {
    /// Sizes of the bodies.
    pub fn sizes(&self) -> BodySizes<'_> {
        match self {
            Self::Listed(list) => {
                BodySizes::Listed(list.iter().map(|body| body.diameter).collect())
            }
            Self::Packed(packing) => BodySizes::Packed(packing),
            Self::Polyhedra(polyhedra) => match &polyhedra.placement {
                PolyhedronPlacement::Listed(list) => {
                    BodySizes::Listed(list.iter().map(|body| body.diameter).collect())
                }
                PolyhedronPlacement::Packed(packing) => BodySizes::Packed(packing),
            },
        }
    }
}

/// Sizes of the bodies of a set; a polyhedron counts as the sphere of its volume.
#[derive(Clone, Debug, PartialEq)]
pub enum BodySizes<'a> {
    /// The diameter of each [m].
    Listed(Vec<f64>),
    /// Drawn by a packing.
    Packed(&'a Packing),
}

impl BodySizes<'_> {
    /// The smallest and the largest diameter that there is or may be drawn [m]: infinity and zero
    /// where there is none.
    pub fn extremes(&self) -> [f64; 2] {
        match self {
            Self::Listed(list) => extremes(list.iter().copied()),
            Self::Packed(packing) => packing.diameters.extremes(),
        }
    }

    /// Volume of all bodies together [m³].
    pub fn volume(&self) -> f64 {
        match self {
            Self::Listed(list) => list.iter().map(|d| PI / 6.0 * d * d * d).sum(),
            Self::Packed(packing) => {
                let sides = (0..3).map(|a| packing.max[a] - packing.min[a]);
                packing.fraction * sides.product::<f64>()
            }
        }
    }
}

/// The least and the greatest of some diameters.
fn extremes(diameters: impl Iterator<Item = f64>) -> [f64; 2] {
    diameters.fold([f64::INFINITY, 0.0], |[low, high], d| [d.min(low), d.max(high)])
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
    /// Lower corner of the region [m]; whole spheres lie inside the region and outside all parts.
    /// Along an axis on which the region spans a periodic domain, spheres lie across its faces too.
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
    /// Uniformly distributed between two bounds (equal bounds: all alike), by number.
    Uniform {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A normal distribution by number, cut at two bounds.
    Normal {
        /// Mean of the uncut distribution.
        mean: f64,
        /// Standard deviation of the uncut distribution.
        deviation: f64,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A log-normal distribution by number, cut at two bounds.
    LogNormal {
        /// Median of the uncut distribution.
        median: f64,
        /// Geometric standard deviation of the uncut distribution, more than 1.
        spread: f64,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A sieve curve: mass passing against size, the logarithm of size linear between points. The
    /// first point passes 0, the last 1.
    Sieve(Vec<SievePoint>),
    /// Drawn from a list, each entry equally likely.
    Listed(Vec<f64>),
}

impl Diameters {
    /// The smallest and the largest diameter that may be drawn [m]: infinity and zero where there
    /// is none.
    pub fn extremes(&self) -> [f64; 2] {
        match self {
            Self::Uniform { min, max }
            | Self::Normal { min, max, .. }
            | Self::LogNormal { min, max, .. } => [*min, *max],
            Self::Sieve(points) => extremes(points.iter().map(|point| point.size)),
            Self::Listed(list) => extremes(list.iter().copied()),
        }
    }
}

/// A point of a sieve curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SievePoint {
    /// Width of the mesh [m].
    pub size: f64,
    /// Mass that passes over whole mass.
    pub passing: f64,
}
