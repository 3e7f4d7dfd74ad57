//! Parameters of the fluid that a user chooses.

use crate::particles::particle_arrays::Transfer;
use crate::solver::free_surface::SurfaceOrder;
use crate::solver::gap_damping::GapDamping;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::Problem;
use tremie_messages::units::{Length, Time};

/// Parameters of the particle-in-cell fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Edge of a cell; each edge of the domain is a whole number of cells.
    pub cell: Length,
    /// Time step (default: `courant` cells at the expected speed; without an expected speed, at
    /// that of a fall from the highest fluid to the lowest point of the domain).
    #[serde(default)]
    pub time_step: Option<Time>,
    /// Cells that the expected speed covers in a time step.
    #[serde(default = "defaults::courant")]
    pub courant: f64,
    /// Way in which velocities travel between particles and grid.
    #[serde(default)]
    pub transfer: TransferName,
    /// Share of PIC in the transfer `flip`, in a time step: 0 is pure FLIP, which damps nothing and
    /// is noisy; 1 is pure PIC, which damps much.
    #[serde(default = "defaults::pic_share")]
    pub pic_share: f64,
    /// Particles along each axis of a cell at the start.
    #[serde(default = "defaults::particles_per_axis")]
    pub particles_per_axis: usize,
    /// Random displacement of particles from their lattice at the start, in half steps of it.
    #[serde(default)]
    pub jitter: f64,
    /// Seed of the random displacements.
    #[serde(default = "defaults::seed")]
    pub seed: u64,
    /// Where the pressure is zero at the free surface.
    #[serde(default)]
    pub surface: SurfaceName,
    /// Whether walls and bodies hold the fluid back (default: where cells resolve the layer in
    /// which they do: the expected speed times the cell over the viscosity is below 20).
    #[serde(default)]
    pub walls: Option<WallName>,
    /// Share of a cell's excess or lack of mass that is mended in a time step in which the fastest
    /// fluid crosses half a cell, in proportion in others: particles are moved apart, without a
    /// change of their velocities.
    #[serde(default = "defaults::relaxation")]
    pub relaxation: f64,
    /// Damping of the fluid in narrow gaps between round bodies, and between them and walls at rest
    /// (default: none).
    #[serde(default)]
    pub gap_damping: Option<GapDampingTable>,
    /// What the pressure is solved with, besides weights, as forces on bodies that move.
    #[serde(default)]
    pub contacts: ContactForces,
    /// Largest imbalance of a cell's volume that the pressure's solution leaves, over the largest
    /// one before it.
    #[serde(default = "defaults::tolerance")]
    pub tolerance: f64,
    /// Most iterations of the pressure in a time step.
    #[serde(default = "defaults::iterations")]
    pub iterations: usize,
}

/// Values of parameters that a user left out.
mod defaults {
    pub fn courant() -> f64 {
        0.5
    }
    pub fn pic_share() -> f64 {
        0.01
    }
    pub fn particles_per_axis() -> usize {
        2
    }
    pub fn seed() -> u64 {
        1
    }
    pub fn beta() -> f64 {
        0.5
    }
    pub fn relaxation() -> f64 {
        0.1
    }
    pub fn tolerance() -> f64 {
        1e-8
    }
    pub fn iterations() -> usize {
        200
    }
}

/// Damping of the fluid in narrow gaps (Chen et al. 2019): what the grid does not resolve there is
/// modelled by slowing particles near contacts. The momentum goes nowhere; it is told as a signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GapDampingTable {
    /// Part of a particle's velocity that is left in a time step at the point of contact; it rises to
    /// 1 two cells beside it. The paper has 0.5; 1 damps nothing.
    #[serde(default = "defaults::beta")]
    pub beta: f64,
    /// Width of a gap from which on there is a contact (default: two cells).
    #[serde(default)]
    pub gap: Option<Length>,
}

/// Ways in which velocities travel between particles and grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TransferName {
    /// Particles gain the grid's change of velocity, but for a share (Brackbill & Ruppel 1986).
    #[default]
    Flip,
    /// Particles take the grid's velocity and its gradients (Jiang et al. 2015).
    Apic,
}

/// Places of the free surface between a wet cell and one of air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceName {
    /// At the air cell's centre: first order.
    First,
    /// Where the distance to it passes zero: second order (Gibou et al. 2002).
    #[default]
    Second,
}

/// Walls and bodies, as the fluid's shear feels them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WallName {
    /// They hold the fluid back.
    Stick,
    /// They do not: the fluid slips along them.
    Slip,
}

/// Forces of contacts that the solution of the pressure takes for granted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ContactForces {
    /// Those that lasted: what moved a body in the last two windows besides fluid and weight, as
    /// far as both agree. A body that lies still on the ground is then still for the fluid too.
    #[default]
    Lasting,
    /// None.
    None,
}

impl Parameters {
    /// Parameters with every default and the given cell [m].
    pub fn with_cell(cell: f64) -> Self {
        Self {
            cell: Length(cell),
            time_step: None,
            courant: defaults::courant(),
            transfer: TransferName::default(),
            pic_share: defaults::pic_share(),
            particles_per_axis: defaults::particles_per_axis(),
            jitter: 0.0,
            seed: defaults::seed(),
            surface: SurfaceName::default(),
            walls: None,
            relaxation: defaults::relaxation(),
            gap_damping: None,
            contacts: ContactForces::default(),
            tolerance: defaults::tolerance(),
            iterations: defaults::iterations(),
        }
    }

    /// The transfer.
    pub fn transfer(&self) -> Transfer {
        match self.transfer {
            TransferName::Flip => Transfer::Blend { pic: self.pic_share },
            TransferName::Apic => Transfer::Affine,
        }
    }

    /// The damping in gaps.
    pub fn gap_damping(&self) -> Option<GapDamping> {
        let table = self.gap_damping?;
        let gap = table.gap.map_or(2.0 * self.cell.0, |gap| gap.0);
        Some(GapDamping { beta: table.beta, gap })
    }

    /// The order of the surface.
    pub fn surface_order(&self) -> SurfaceOrder {
        match self.surface {
            SurfaceName::First => SurfaceOrder::First,
            SurfaceName::Second => SurfaceOrder::Second,
        }
    }

    /// Checks that need nothing but the parameters.
    pub(crate) fn check_own(&self, problems: &mut Vec<Problem>) {
        let mut within = |key: &str, value: f64, [low, high]: [f64; 2], help: &str| {
            if !(low <= value && value <= high) {
                let found = format!("must be from {low} to {high}, found {value}");
                problems.push(Problem::of_parameter(key, found).help(help));
            }
        };
        within("courant", self.courant, [0.01, 1.0], "0.5 is the default");
        within("pic_share", self.pic_share, [0.0, 1.0], "0.01 is the default");
        within("jitter", self.jitter, [0.0, 1.0], "0 seeds a lattice");
        within("relaxation", self.relaxation, [0.0, 1.0], "0.1 is the default; 0 switches it off");
        if let Some(table) = &self.gap_damping {
            within(
                "gap_damping.beta",
                table.beta,
                [0.0, 1.0],
                "0.5 is the default; 1 damps nothing",
            );
        }
        within("tolerance", self.tolerance, [1e-12, 0.1], "1e-8 is the default");
        let per_axis = self.particles_per_axis as f64;
        within("particles_per_axis", per_axis, [1.0, 5.0], "2 is the default: 8 in a cell");
        within("iterations", self.iterations as f64, [1.0, 1e6], "200 is the default");
        let mut positive = |key: &str, value: f64, unit: &str| {
            if !(value.is_finite() && value > 0.0) {
                let found = format!("must be positive, found {value} {unit}");
                problems.push(Problem::of_parameter(key, found));
            }
        };
        positive("cell", self.cell.0, "m");
        if let Some(gap) = self.gap_damping.and_then(|table| table.gap) {
            positive("gap_damping.gap", gap.0, "m");
        }
        if let Some(time_step) = self.time_step {
            positive("time_step", time_step.0, "s");
        }
    }
}
