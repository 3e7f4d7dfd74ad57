//! Numerical parameters of the solver, as a user may set them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Length, Time, Velocity};

/// Numerical parameters of the grains; everything physical stands in the scene.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Time step; unset: as `steps_per_contact` and stability demand.
    pub time_step: Option<Time>,
    /// Steps during the shortest collision of two bodies, or a body and a wall. 15 give an error
    /// of a few per cent in flows, 50 are for validation.
    pub steps_per_contact: f64,
    /// Largest relative speed of two bodies that the user expects; under Hertz's law the duration
    /// of a collision and the stiffness depend on it, and so does the time step. Unset: twice the
    /// fastest speed at the start and what a fall through the domain adds.
    pub expected_speed: Option<Velocity>,
    /// How far beyond touching neighbours are listed, as a fraction of the diameter: of the largest
    /// body of each class of sizes, which holds bodies within a factor of two. More makes the list
    /// longer, less makes it due more often. Results depend on it only by rounding.
    pub skin: Option<f64>,
    /// Most spheres that may live at once, where inlets feed any. Unset: as many as fit into what
    /// parts leave of the domain, packed densely, and a twentieth more; but no more than half a
    /// million.
    pub capacity: Option<u64>,
    /// Lubrication between bodies, and between bodies and walls or parts, at gaps that the fluid
    /// does not resolve. Unset: none. A lattice fluid gives what it resolves of this force itself:
    /// the cut-off must not be larger than the gap below which it stops to do so, about one cell.
    pub lubrication: Option<Lubrication>,
    /// How bodies move through a time step.
    pub integrator: Integrator,
}

/// Integrator of the motion of bodies. Loads of a fluid and weight are constant over the steps that
/// the grains make within one of the fluid, a window.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Integrator {
    /// Velocity Verlet with predicted velocities: second order, one evaluation of forces in a step.
    #[default]
    Verlet,
    /// Heun's method: second order, two evaluations in a step, positions by the mean of velocities
    /// before and after it. What the subcycles of Chen et al. would be without their flaw. For
    /// spheres and cylinders, with parts that stand still or move as given.
    Heun,
    /// The subcycles as Chen et al. (2019) print them: loads and weight act at the start of the
    /// window, contacts by Euler's method, and the mean of each velocity and that at the start of
    /// the window moves a body. A rebound within a window gains energy, the more the more steps are
    /// in the window: it is there to reproduce theirs. For the same bodies as Heun's.
    Chen,
}

impl Integrator {
    /// Name as in the settings.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Verlet => "verlet",
            Self::Heun => "heun",
            Self::Chen => "chen",
        }
    }
}

/// Forces of the fluid squeezed out of narrow gaps.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Lubrication {
    /// Gap from which on there is no such force.
    pub cutoff: Length,
    /// Height of asperities: at smaller gaps the force grows no more, and in contact there is none.
    pub roughness: Length,
}

impl Parameters {
    /// Skin where none is set. A bed that flows is a tenth faster at twice as much, where lists are
    /// made less often; a valve of triangles that takes part is slower, because spheres near
    /// triangles are looked at in every step.
    pub const DEFAULT_SKIN: f64 = 0.1;

    /// The skin as a fraction of the largest diameter of a class of sizes.
    pub fn skin_fraction(&self) -> f64 {
        self.skin.unwrap_or(Self::DEFAULT_SKIN)
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            time_step: None,
            steps_per_contact: 20.0,
            expected_speed: None,
            skin: None,
            capacity: None,
            lubrication: None,
            integrator: Integrator::Verlet,
        }
    }
}
