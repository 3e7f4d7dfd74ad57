//! Parameters of the fluid that a user chooses.

use crate::lattice::d3q19::CS2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::Problem;
use tremie_messages::units::{Length, Time, Viscosity};

/// Parameters of the lattice-Boltzmann fluid.
///
/// At most one of `time_step` and `relaxation_time` is given. With neither, the relaxation time is
/// 0.8, or less where the scene's expected speed would exceed Mach 0.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Edge of a cell; each edge of the domain is a whole number of cells.
    pub cell: Length,
    /// Time step; the relaxation time follows from the viscosity.
    #[serde(default)]
    pub time_step: Option<Time>,
    /// Relaxation time tau in time steps; the time step follows: `dt = (tau - 1/2) dx^2 / (3 nu)`.
    #[serde(default)]
    pub relaxation_time: Option<f64>,
    /// Collision operator.
    #[serde(default)]
    pub collision: Collision,
    /// `(tau - 1/2)(tau_minus - 1/2)` of the TRT collision; 3/16 puts walls exactly half-way.
    #[serde(default = "defaults::magic")]
    pub magic: f64,
    /// Bulk viscosity, which damps sound and leaves shear alone (default: two thirds of the shear viscosity, what
    /// the collision has of its own; at a small viscosity nothing damps sound then).
    #[serde(default)]
    pub bulk_viscosity: Option<Viscosity>,
    /// The same by the relaxation time of the stress's trace, in time steps: `zeta = 2/9 (tau_b - 1/2) rho
    /// dx^2/dt`. With 1 each step takes the trace to its equilibrium. At most one of the two is given.
    #[serde(default)]
    pub bulk_relaxation_time: Option<f64>,
    /// Smagorinsky's constant `C` of the eddy viscosity `(C dx)^2 |S|`; 0 for none.
    #[serde(default)]
    pub smagorinsky: f64,
    /// Scheme of faces with given velocity or pressure.
    #[serde(default)]
    pub open_faces: OpenFaces,
    /// Walls of parts.
    #[serde(default)]
    pub walls: Walls,
    /// What cells hold that a body uncovered, and whether its motion keeps the mass.
    #[serde(default)]
    pub refill: Refill,
    /// What presses on a body in a gap too narrow to hold a cell.
    #[serde(default)]
    pub gap_pressure: GapPressure,
    /// Lattice viscosity `(tau - 1/2)/3` below which the walls of gaps slip that the scene says
    /// may; above it they hold the fluid as real ones do.
    #[serde(default = "defaults::slip_viscosity")]
    pub slip_viscosity: f64,
    /// How far a part that moves comes before its cells and links are found anew [cells]: the next
    /// power of two below. In between, wall distances follow it to first order; a cell is covered
    /// at most that much, by half along an axis, too early or too late. 0 finds them in each step.
    #[serde(default = "defaults::part_step")]
    pub part_step: f64,
    /// Precision of storage and collision. Loads and balances are f64 in either.
    #[serde(default)]
    pub precision: Precision,
    /// Whether a body receives the mean of the last two steps' forces, which removes the lattice's
    /// two-step oscillation.
    #[serde(default = "defaults::average_force")]
    pub average_force: bool,
    /// How many steps ahead of its state a body's wall moves, by what its velocity changed by in
    /// the last step: 0 for the velocity given. A body that moves under the fluid's force gets the
    /// force of a step after it, half a step later still with `average_force`; that lag feeds sound
    /// between body and walls, at the rate `rho cs^2 A^2 lag / (M V)`, and at a small viscosity
    /// nothing damps it. 1 makes up for both, and is stable with `average_force` alone. With a
    /// lead, a rigid body's velocity is in each interpolated link that of the time at which the
    /// link meets it. Free spheres and polyhedra are taken ahead by no more than the fluid's own
    /// force changes their velocity: what a lead makes of the jolts between grains is noise. They
    /// feed the sound across gaps as narrow as a few of them.
    #[serde(default)]
    pub velocity_lead: f64,
    /// Largest Mach number: of the scene's expected speed at the start, and of the flow while running
    /// unless the manifest's `watch.mach` says otherwise.
    #[serde(default = "defaults::mach_limit")]
    pub mach_limit: f64,
}

/// Values of parameters that a user left out.
mod defaults {
    pub fn magic() -> f64 {
        3.0 / 16.0
    }
    pub fn average_force() -> bool {
        true
    }
    pub fn mach_limit() -> f64 {
        0.17
    }
    pub fn slip_viscosity() -> f64 {
        0.01
    }
    pub fn part_step() -> f64 {
        1.0 / 32.0
    }
}

/// Collision operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Collision {
    /// One relaxation time (Bhatnagar, Gross, Krook).
    Bgk,
    /// Two relaxation times, the second by `magic` (Ginzburg, Verhaeghe, d'Humieres 2008).
    #[default]
    Trt,
    /// Central moments, of which those beyond the stress relax in one step (De Rosis & Coreixas 2020). A wall's
    /// place depends on the viscosity.
    CentralMoments,
}

/// Scheme of faces with given velocity or pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OpenFaces {
    /// Non-equilibrium extrapolation from the next cell inside (Guo, Zheng & Shi 2002): robust.
    #[default]
    Nee,
    /// Non-equilibrium bounce-back (Zou & He 1997; Hecht & Harting 2010).
    Nebb,
}

/// Walls of parts that stand still.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Walls {
    /// Interpolated at the surface (Bouzidi, Firdaouss & Lallemand 2001): second order.
    #[default]
    Bouzidi,
    /// Half-way between cells: first order, and keeps the mass exactly.
    Halfway,
}

/// What cells hold that a body uncovered: the mean density around, the body's velocity, and the
/// stress of the neighbour away from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Refill {
    /// No more than that; the mass drifts while bodies move, in a settling bed by per cents.
    Eqneq,
    /// And what a body took from the fluid beyond its volume is paid back along its surface, so
    /// that a closed box keeps its mean density.
    #[default]
    Mass,
}

/// What presses on a body where another surface is so near that no cell is between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum GapPressure {
    /// The mean gauge pressure of the fluid cells next to the gap; nothing where surfaces touch.
    #[default]
    Nearest,
    /// Nothing: gauge pressure zero.
    Zero,
}

/// Precision of storage and collision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// 64 bits.
    #[default]
    F64,
    /// 32 bits: half the memory, about twice the speed.
    F32,
}

/// The smallest step of moving parts besides 0 [cells].
const SMALLEST_PART_STEP: f64 = 1.0 / 1_048_576.0;

impl Parameters {
    /// Relaxation time when neither it nor the time step is given: accurate and far from the
    /// stability limit.
    pub const DEFAULT_TAU: f64 = 0.8;
    /// Mach number of the expected speed that the default time step keeps to.
    pub const DEFAULT_MACH: f64 = 0.1;
    /// Memory beyond which a lattice is refused [bytes].
    pub const MEMORY_LIMIT: u64 = 1 << 40;

    /// Parameters with every default and the given cell [m].
    pub fn with_cell(cell: f64) -> Self {
        Self {
            cell: Length(cell),
            time_step: None,
            relaxation_time: None,
            collision: Collision::default(),
            magic: defaults::magic(),
            bulk_viscosity: None,
            bulk_relaxation_time: None,
            smagorinsky: 0.0,
            open_faces: OpenFaces::default(),
            walls: Walls::default(),
            refill: Refill::default(),
            gap_pressure: GapPressure::default(),
            slip_viscosity: defaults::slip_viscosity(),
            part_step: defaults::part_step(),
            precision: Precision::default(),
            average_force: defaults::average_force(),
            velocity_lead: 0.0,
            mach_limit: defaults::mach_limit(),
        }
    }

    /// Smallest relaxation time that is accepted; below it the collision amplifies rounding errors.
    /// A closure for turbulence damps them, so that the limit is then what the numbers resolve.
    pub fn smallest_tau(&self) -> f64 {
        match (self.smagorinsky > 0.0, self.precision) {
            (true, _) => 0.500001,
            (false, _) => self.trusted_tau(),
        }
    }

    /// Smallest relaxation time that is trusted without a turbulence model; below it the collision
    /// damps neither rounding nor waves.
    pub fn trusted_tau(&self) -> f64 {
        match self.precision {
            Precision::F64 => 0.5005,
            Precision::F32 => 0.502,
        }
    }

    /// Relaxation time of a time step [s] with kinematic viscosity `nu` [m²/s]: `1/2 + 3 nu
    /// dt/dx^2`.
    pub fn tau_of(&self, time_step: f64, nu: f64) -> f64 {
        0.5 + nu * time_step / (CS2 * self.cell.0 * self.cell.0)
    }

    /// Time step [s] of a relaxation time with kinematic viscosity `nu` [m²/s].
    pub(crate) fn time_step_of(&self, tau: f64, nu: f64) -> f64 {
        (tau - 0.5) * CS2 * self.cell.0 * self.cell.0 / nu
    }

    /// Relaxation time of the trace of the stress at a time step [s], in a fluid of some density [kg/m³]; `None`
    /// where it is that of all of the stress.
    pub(crate) fn bulk_tau(&self, time_step: f64, density: f64) -> Option<f64> {
        let of_viscosity =
            |Viscosity(zeta)| 0.5 + 4.5 * zeta * time_step / (density * self.cell.0 * self.cell.0);
        self.bulk_relaxation_time.or_else(|| self.bulk_viscosity.map(of_viscosity))
    }

    /// Mach number of a speed [m/s] at a time step [s].
    pub(crate) fn mach_of(&self, speed: f64, time_step: f64) -> f64 {
        speed * time_step / self.cell.0 / CS2.sqrt()
    }

    /// Edge of the grid of positions at which moving parts are found [cells]: a power of two, so
    /// that a part keeps its place among the cells when it moves by whole ones.
    pub(crate) fn spacing_of_poses(&self) -> f64 {
        let mut spacing = 0.25;
        while spacing > self.part_step && spacing > SMALLEST_PART_STEP {
            spacing *= 0.5;
        }
        if self.part_step > 0.0 { spacing } else { 0.0 }
    }

    /// Checks that need nothing but the parameters.
    pub(crate) fn check_own(&self, problems: &mut Vec<Problem>) {
        let mut positive = |key: &str, value: f64, unit: &str| {
            if !(value.is_finite() && value > 0.0) {
                problems.push(Problem::of_parameter(
                    key,
                    format!("must be positive, found {value}{unit}"),
                ));
            }
        };
        positive("cell", self.cell.0, " m");
        if let Some(time_step) = self.time_step {
            positive("time_step", time_step.0, " s");
        }
        if let Some(Viscosity(zeta)) = self.bulk_viscosity {
            positive("bulk_viscosity", zeta, " Pa s");
        }
        positive("magic", self.magic, "");
        positive("mach_limit", self.mach_limit, "");
        if !(0.0..=1.0).contains(&self.smagorinsky) {
            problems.push(
                Problem::of_parameter(
                    "smagorinsky",
                    format!("must be from 0 to 1, found {}", self.smagorinsky),
                )
                .help("0.1 to 0.2 is customary; 0 turns the closure off"),
            );
        }
        if !(self.slip_viscosity.is_finite() && self.slip_viscosity >= 0.0) {
            let found = format!("must not be negative, found {}", self.slip_viscosity);
            problems
                .push(Problem::of_parameter("slip_viscosity", found).help("0.01 is the default"));
        }
        if !(0.0..=2.0).contains(&self.velocity_lead) {
            let found = format!("must be from 0 to 2 steps, found {}", self.velocity_lead);
            problems.push(
                Problem::of_parameter("velocity_lead", found)
                    .help("0 takes the velocity as it is; 1 makes up for the lag of the force"),
            );
        }
        if self.velocity_lead > 0.0 && !self.average_force {
            problems.push(
                Problem::of_parameter(
                    "velocity_lead",
                    "is more than 0, but `average_force` is off",
                )
                .help("leave average_force on: else the lattice's two-step oscillation is fed"),
            );
        }
        let is_fine = self.part_step == 0.0 || self.part_step >= SMALLEST_PART_STEP;
        if !(self.part_step <= 0.25 && is_fine) {
            problems.push(
                Problem::of_parameter(
                    "part_step",
                    format!("must be 0, or from 2^-20 to 0.25, found {}", self.part_step),
                )
                .help("0.03125, a 32nd of a cell, is hardly to be told from 0 and much faster"),
            );
        }
        self.check_bulk(problems);
        self.check_time(problems);
    }

    /// Checks the bulk viscosity.
    fn check_bulk(&self, problems: &mut Vec<Problem>) {
        let Some(tau) = self.bulk_relaxation_time else { return };
        let key = "bulk_relaxation_time";
        if !(tau.is_finite() && tau > 0.5) {
            let found = format!("must be more than 1/2, found {tau}");
            problems.push(Problem::of_parameter(key, found).help("1 damps sound most evenly"));
        }
        if self.bulk_viscosity.is_some() {
            problems.push(
                Problem::of_parameter(key, "is given together with bulk_viscosity")
                    .help("each follows from the other: leave one out"),
            );
        }
    }

    /// Checks what the time step follows from.
    fn check_time(&self, problems: &mut Vec<Problem>) {
        if self.mach_limit > 0.5 {
            problems.push(
                Problem::of_parameter(
                    "mach_limit",
                    format!("must be at most 0.5, found {}", self.mach_limit),
                )
                .help(
                    "the lattice is second order in the Mach number; 0.17 keeps its error near 3 %",
                ),
            );
        }
        if let Some(tau) = self.relaxation_time {
            if !(tau.is_finite() && tau > 0.5) {
                problems.push(
                    Problem::of_parameter(
                        "relaxation_time",
                        format!("must be more than 1/2, found {tau}"),
                    )
                    .help("0.6 to 1 suits most flows"),
                );
            }
            if self.time_step.is_some() {
                problems.push(
                    Problem::of_parameter("relaxation_time", "is given together with time_step")
                        .help("each follows from the other: leave one out"),
                );
            }
        }
    }
}
