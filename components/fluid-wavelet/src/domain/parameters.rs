//! Parameters of the gas that a user chooses.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::Problem;
use tremie_messages::units::{Length, Time};

/// Most levels of refinement.
pub const MOST_LEVELS: u8 = 16;

/// Parameters of the compressible gas on adaptive wavelets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Spacing of the finest points. Those around surfaces have it.
    pub cell: Length,
    /// How many times the coarsest points lie twice as far apart as the next finer ones (default: as
    /// often as the domain's edges allow).
    #[serde(default)]
    pub levels: Option<u8>,
    /// Points of a block along each axis, an even number (default: 16 in a plane, 8 in space).
    #[serde(default)]
    pub block: Option<usize>,
    /// Detail that is significant, as a share of the largest value of density, momentum, energy:
    /// points that carry less are left out.
    #[serde(default = "defaults::tolerance")]
    pub tolerance: f64,
    /// Detail from which on a place is rough, as a share of the largest density and pressure: there
    /// fluxes are those that capture shocks, elsewhere those that damp nothing.
    #[serde(default = "defaults::roughness")]
    pub roughness: f64,
    /// Steps of the gas from one adaptation of the grid to the next.
    #[serde(default = "defaults::adapt_every")]
    pub adapt_every: usize,
    /// Points that the fastest signal passes in a step of the gas.
    #[serde(default = "defaults::courant")]
    pub courant: f64,
    /// Time step that the windows of a run are made of (default: the gas's step at the start, at the
    /// expected speed). The gas takes shorter ones inside wherever it has to.
    #[serde(default)]
    pub time_step: Option<Time>,
    /// True for a gas without friction and conduction of heat, which slips along all surfaces.
    #[serde(default)]
    pub inviscid: bool,
    /// A layer at the open faces in which the gas relaxes to that at the start (default: none).
    #[serde(default)]
    pub sponge: Option<SpongeTable>,
    /// What of the two estimates of the force the bodies feel.
    #[serde(default)]
    pub loads: LoadName,
}

/// Values of parameters that a user left out.
mod defaults {
    pub fn tolerance() -> f64 {
        1e-3
    }
    pub fn roughness() -> f64 {
        5e-3
    }
    pub fn adapt_every() -> usize {
        4
    }
    pub fn courant() -> f64 {
        0.5
    }
    pub fn strength() -> f64 {
        5.0
    }
}

/// A layer along all open faces in which the gas relaxes to that at the start, so that neither it nor
/// the face throws waves back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpongeTable {
    /// Its width.
    pub width: Length,
    /// Rate of relaxation at the face in units of the speed of sound over the width; inwards it falls
    /// by the square of the way.
    #[serde(default = "defaults::strength")]
    pub strength: f64,
}

/// Estimates of the force of the gas on a body; both are signals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LoadName {
    /// Stress at the surface.
    #[default]
    Stress,
    /// Momentum that goes from points in the gas to points in the body.
    Momentum,
}

impl Parameters {
    /// Parameters with every default and the given spacing [m].
    pub fn with_cell(cell: f64) -> Self {
        Self {
            cell: Length(cell),
            levels: None,
            block: None,
            tolerance: defaults::tolerance(),
            roughness: defaults::roughness(),
            adapt_every: defaults::adapt_every(),
            courant: defaults::courant(),
            time_step: None,
            inviscid: false,
            sponge: None,
            loads: LoadName::default(),
        }
    }

    /// Points of a block along each axis.
    pub fn block_edge(&self, dims: usize) -> usize {
        self.block.unwrap_or(if dims < 3 { 16 } else { 8 })
    }

    /// Checks that need nothing but the parameters.
    pub(crate) fn check_own(&self, problems: &mut Vec<Problem>) {
        let mut within = |key: &str, value: f64, [low, high]: [f64; 2], help: &str| {
            if !(low <= value && value <= high) {
                let found = format!("found {value}, expected a number from {low} to {high}");
                problems.push(Problem::of_parameter(key, found).help(help));
            }
        };
        within("tolerance", self.tolerance, [0.0, 0.1], "1e-3 is the default; 0 keeps all points");
        within("roughness", self.roughness, [0.0, 1.0], "5e-3 is the default; 1 captures no shock");
        within("courant", self.courant, [0.01, 1.0], "0.5 is the default");
        within("adapt_every", self.adapt_every as f64, [1.0, 64.0], "4 is the default");
        let most = f64::from(MOST_LEVELS);
        within("levels", f64::from(self.levels.unwrap_or(0)), [0.0, most], "6 is a usual number");
        if let Some(sponge) = &self.sponge {
            within("sponge.strength", sponge.strength, [0.1, 100.0], "5 is the default");
        }
        if let Some(block) = self.block
            && !(block.is_multiple_of(2) && (4..=64).contains(&block))
        {
            let found = format!("found {block}, expected an even number from 4 to 64");
            problems.push(Problem::of_parameter("block", found));
        }
        let mut positive = |key: &str, value: f64, unit: &str| {
            if !(value.is_finite() && value > 0.0) {
                let found = format!("found {value} {unit}, expected more than zero");
                problems.push(Problem::of_parameter(key, found));
            }
        };
        positive("cell", self.cell.0, "m");
        if let Some(sponge) = &self.sponge {
            positive("sponge.width", sponge.width.0, "m");
        }
        if let Some(time_step) = self.time_step {
            positive("time_step", time_step.0, "s");
        }
    }
}
