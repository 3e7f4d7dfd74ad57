//! The manifest's tables of bodies: how they move, where they are, how large.

use super::AxisName;
use super::course::MotionCourseEntry;
use super::forms::read_by_form;
use super::polyhedra::{PolyhedronTable, PrismTable};
use super::values::DiameterEntry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{AngularVelocity, Density, Length, Time, Velocity};

/// Bodies of one material and one kind of motion. Exactly one of `spheres`, `cylinders`,
/// `polyhedra`, `prisms`, `lattice` and `packing`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct BodiesTable {
    /// Name, unique in the scene. Required.
    pub name: Option<String>,
    /// Density (default: the material's).
    pub density: Option<Density>,
    /// Their material, one of `[scene.materials]` (default: one of the set's own name).
    pub material: Option<String>,
    /// How they move (default: free).
    pub motion: Option<MotionName>,
    /// The clump that they belong to: all free bodies of sets with the same name here are joined
    /// rigidly (default: each moves by itself).
    pub clump: Option<String>,
    /// How heavy their clump is, and how much fluid it displaces: as its bodies together, also
    /// where these overlap, or as their union (default: together). All sets of a clump that say it
    /// say the same.
    pub mass: Option<ClumpMass>,
    /// Velocities of a prescribed motion over time (default: those that they were placed with); or
    /// a formula for the factor of those: `{ sine = { frequency = "2 Hz" } }`.
    pub course: Option<MotionCourseEntry>,
    /// Whether pose, velocity, spin and the fluid's load of each of its bodies, or of the clump
    /// that they belong to, are signals (default: of a set that lists one body and of a clump they
    /// are, as long as there are no more than 16 of these in all).
    pub follow: Option<bool>,
    /// Each sphere given.
    pub spheres: Option<Vec<SphereTable>>,
    /// Each cylinder given, in a plane scene; its position across the plane does not matter.
    pub cylinders: Option<Vec<SphereTable>>,
    /// Shape of polyhedra or prisms: one of `[[scene.shapes]]`, or tetrahedron, cube, octahedron,
    /// dodecahedron or icosahedron (default: the bodies are spheres).
    pub shape: Option<String>,
    /// Each polyhedron given.
    pub polyhedra: Option<Vec<PolyhedronTable>>,
    /// Each prism given, in a plane scene; the set's shape has an outline.
    pub prisms: Option<Vec<PrismTable>>,
    /// Spheres on a lattice: a rough wall, or a start in order.
    pub lattice: Option<LatticeTable>,
    /// Spheres packed at random, without overlap; or polyhedra in such spheres, turned at random.
    pub packing: Option<PackingTable>,
}

/// Mass of a clump.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum ClumpMass {
    /// That of its bodies together.
    Sum,
    /// That of their union.
    Union,
}

/// How bodies or parts move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum MotionName {
    /// Under forces.
    Free,
    /// Never.
    Fixed,
    /// With given velocities, whatever the forces.
    Prescribed,
}

/// Velocities at a time; linear between points, constant before the first and after the last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct MotionPointTable {
    /// Time. Required.
    pub time: Option<Time>,
    /// Velocity (default: none).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
}

/// A sphere, or a cylinder across a plane scene, at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SphereTable {
    /// Centre. Required.
    pub position: Option<[Length; 3]>,
    /// Diameter. Required.
    pub diameter: Option<Length>,
    /// Velocity (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
}

/// Spheres of one size on a lattice, from the lower corner of a region on: as many as lie in it
/// whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct LatticeTable {
    /// Lower corner of the region. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner of the region. Required.
    pub max: Option<[Length; 3]>,
    /// Diameter. Required.
    pub diameter: Option<Length>,
    /// Distance of neighbours (default: the diameter).
    pub spacing: Option<Length>,
    /// Arrangement (default: hexagonal).
    pub arrangement: Option<Arrangement>,
    /// The axis across the layers (default: z). A region that is one sphere thick along it holds a
    /// single layer.
    pub normal: Option<AxisName>,
}

/// Arrangement of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum Arrangement {
    /// Hexagonal close packing: rows side by side in gaps, and layers in turn above each other's
    /// holes.
    Hexagonal,
    /// Simple cubic.
    Cubic,
}

/// A random packing. Exactly one of `diameter` and `diameters`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PackingTable {
    /// Lower corner of the region; whole spheres lie inside, or across the faces of a periodic
    /// domain that the region spans. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner of the region. Required.
    pub max: Option<[Length; 3]>,
    /// Volume of the bodies over volume of the region. Required.
    pub fraction: Option<f64>,
    /// One diameter for all (of polyhedra that of a sphere of the same volume), or `[smallest,
    /// largest]` of a uniform distribution.
    pub diameter: Option<DiameterEntry>,
    /// Diameters to draw from, each equally likely, or a distribution.
    pub diameters: Option<DiametersEntry>,
    /// Seed of the random numbers (default: the run's).
    pub seed: Option<u64>,
}

/// Diameters: a list to draw from, or a distribution.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum DiametersEntry {
    /// A list to draw from, each equally likely.
    List(Vec<Length>),
    /// A distribution.
    Distribution(DistributionTable),
}

read_by_form!(DiametersEntry: "a list of lengths, or a table with normal, log_normal or sieve", List => List, Table => Distribution);

/// A distribution of diameters. Exactly one of its keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct DistributionTable {
    /// Normal by number, cut at both ends.
    pub normal: Option<NormalTable>,
    /// Log-normal by number, cut at both ends.
    pub log_normal: Option<LogNormalTable>,
    /// A sieve curve by mass: size and the part of the mass that passes, from 0 to 1, as
    /// `[["0.5 mm", 0.0], ["1 mm", 0.4], ["2 mm", 1.0]]`; linear in the logarithm of size.
    pub sieve: Option<Vec<(Length, f64)>>,
}

/// A normal distribution by number, cut at both ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct NormalTable {
    /// Mean of the uncut distribution. Required.
    pub mean: Option<Length>,
    /// Standard deviation of the uncut distribution. Required.
    pub deviation: Option<Length>,
    /// Smallest diameter. Required.
    pub min: Option<Length>,
    /// Largest diameter. Required.
    pub max: Option<Length>,
}

/// A log-normal distribution by number, cut at both ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct LogNormalTable {
    /// Median of the uncut distribution. Required.
    pub median: Option<Length>,
    /// Geometric standard deviation of the uncut distribution, more than 1. Required.
    pub spread: Option<f64>,
    /// Smallest diameter. Required.
    pub min: Option<Length>,
    /// Largest diameter. Required.
    pub max: Option<Length>,
}
