//! The balance of momentum and mass of the fluid, term by term.

use serde::{Deserialize, Serialize};

/// Balance of the fluid in the last step, SI units.
///
/// Impulses [kg m/s] and masses [kg] that entered the fluid (positive) during the step. They add
/// up: `momentum_change = body_force + walls + symmetry + parts + open + bodies + swept + covered +
/// uncovered + isolated + frozen`, and alike for mass. `momentum` is measured over all fluid cells
/// inside the collision and carried to the end of the step by what the step exchanged afterwards;
/// an exchange that were not listed would therefore show as a gap between `momentum_change` and the
/// sum of the terms, one step later.
///
/// The form of the force follows Wen et al. 2014: a body feels
/// `g_i (c_i - u_w) - f_i' (c_i' - u_w)` on each link, so that a sphere that moves with the fluid
/// feels nothing. The momentum that the links moved besides, `(f_i' - g_i) u_w`, is that of the
/// mass that the wall pushed aside; it is `swept`, and balances `covered` and `uncovered` over the
/// time in which a body crosses a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Momentum of the fluid at the end of the step [kg m/s].
    pub momentum: [f64; 3],
    /// Its change in the step.
    pub momentum_change: [f64; 3],
    /// Given by the scene's acceleration.
    pub body_force: [f64; 3],
    /// Given by the domain's walls.
    pub walls: [f64; 3],
    /// Given by symmetry planes.
    pub symmetry: [f64; 3],
    /// Given by parts and planes that stand still.
    pub parts: [f64; 3],
    /// Carried through open faces by the fluid that enters and leaves.
    pub open: [f64; 3],
    /// Given by the bodies: minus the impulse that the links gave to them in this step.
    pub bodies: [f64; 3],
    /// Carried by the mass that moving walls of bodies pushed aside.
    pub swept: [f64; 3],
    /// Lost with cells that bodies covered.
    pub covered: [f64; 3],
    /// Gained with cells that bodies uncovered, and those that thawed.
    pub uncovered: [f64; 3],
    /// Lost with cells that were left without any fluid neighbour, and those that froze.
    pub isolated: [f64; 3],
    /// Given by frozen cells of gaps and pockets, and to cells that nothing flows through.
    pub frozen: [f64; 3],

    /// Impulse given out to the bodies as loads, but for buoyancy.
    pub delivered: [f64; 3],
    /// Impulse that averaging holds back for the next step, at the end of this one:
    /// `images + gaps - bodies = delivered + carried - (carried one step before) + dropped`.
    pub carried: [f64; 3],
    /// Impulse that the fluid behind symmetry planes, which is not simulated, gives to bodies.
    pub images: [f64; 3],
    /// Impulse that bodies get from gaps too narrow to hold a cell; the fluid does not lose it.
    pub gaps: [f64; 3],
    /// Impulse that was held back for bodies that were removed.
    pub dropped: [f64; 3],
    /// Impulse of buoyancy and of the mean pressure gradient in the loads given out; the lattice
    /// carries neither pressure.
    pub buoyancy: [f64; 3],

    /// Mass of the fluid at the end of the step [kg].
    pub mass: f64,
    /// Its change in the step.
    pub mass_change: f64,
    /// Gained at walls (none, for walls at rest).
    pub mass_walls: f64,
    /// Gained at parts and planes that stand still. Interpolation does not keep the mass in each
    /// step, but with what is owed.
    pub mass_parts: f64,
    /// Gained through open faces.
    pub mass_open: f64,
    /// Gained on links to bodies.
    pub mass_bodies: f64,
    /// Lost with covered cells.
    pub mass_covered: f64,
    /// Gained with uncovered cells.
    pub mass_uncovered: f64,
    /// Lost with isolated cells.
    pub mass_isolated: f64,
    /// Mass that interpolated walls took and have not paid back, and with `refill = "mass"` mass
    /// that moving bodies took beyond their volume, at the end of the step [kg]; part of no sum
    /// here.
    pub mass_owed: f64,
    /// Mass that the scheme lost since the start (negative: gained), beyond mass that came and went
    /// through open faces and parts that let fluid through, and mass that moving walls displaced,
    /// at the end of the step [kg]; part of no sum here. With `refill = "mass"`, the mass owed.
    pub mass_lost: f64,
}

impl Ledger {
    /// Sum of the terms that change the fluid's momentum.
    pub fn momentum_terms(&self) -> [f64; 3] {
        std::array::from_fn(|a| {
            self.body_force[a]
                + self.walls[a]
                + self.symmetry[a]
                + self.parts[a]
                + self.open[a]
                + self.bodies[a]
                + self.swept[a]
                + self.covered[a]
                + self.uncovered[a]
                + self.isolated[a]
                + self.frozen[a]
        })
    }

    /// Sum of the terms that change the fluid's mass.
    pub fn mass_terms(&self) -> f64 {
        self.mass_walls
            + self.mass_parts
            + self.mass_open
            + self.mass_bodies
            + self.mass_covered
            + self.mass_uncovered
            + self.mass_isolated
    }

    /// Size of what was lost since the start, over the mass of the fluid; 0 where there is no
    /// fluid.
    pub fn lost_share(&self) -> f64 {
        if self.mass > 0.0 { self.mass_lost.abs() / self.mass } else { 0.0 }
    }

    /// Every quantity times its unit: impulses times `impulse`, masses times `mass`.
    pub(crate) fn scaled(&self, impulse: f64, mass: f64) -> Self {
        self.with(|v| v.map(|x| x * impulse), mass)
    }

    /// With what is made of each impulse, and masses times `mass`.
    pub(crate) fn with(&self, v: impl Fn([f64; 3]) -> [f64; 3], mass: f64) -> Self {
        Self {
            momentum: v(self.momentum),
            momentum_change: v(self.momentum_change),
            body_force: v(self.body_force),
            walls: v(self.walls),
            symmetry: v(self.symmetry),
            parts: v(self.parts),
            open: v(self.open),
            bodies: v(self.bodies),
            swept: v(self.swept),
            covered: v(self.covered),
            uncovered: v(self.uncovered),
            isolated: v(self.isolated),
            frozen: v(self.frozen),
            delivered: v(self.delivered),
            carried: v(self.carried),
            images: v(self.images),
            gaps: v(self.gaps),
            dropped: v(self.dropped),
            buoyancy: v(self.buoyancy),
            mass: self.mass * mass,
            mass_change: self.mass_change * mass,
            mass_walls: self.mass_walls * mass,
            mass_parts: self.mass_parts * mass,
            mass_open: self.mass_open * mass,
            mass_bodies: self.mass_bodies * mass,
            mass_covered: self.mass_covered * mass,
            mass_uncovered: self.mass_uncovered * mass,
            mass_isolated: self.mass_isolated * mass,
            mass_owed: self.mass_owed * mass,
            mass_lost: self.mass_lost * mass,
        }
    }
}

/// Adds `b` times `scale` to `a`.
#[inline]
pub(crate) fn add_scaled(a: &mut [f64; 3], b: [f64; 3], scale: f64) {
    for k in 0..3 {
        a[k] += b[k] * scale;
    }
}
