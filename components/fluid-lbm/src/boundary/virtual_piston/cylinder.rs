//! The cylinder behind a face: a uniform fluid between the face and a piston, in lattice units.
//!
//! ```text
//! M = rho N (L - H)        dM/dt = - (mass that enters the domain)         dH/dt = v_p
//! ```
//!
//! `N` cells lie at the face, `L` is the cylinder's volume over the piston's area, `H` the piston's
//! way. That the area is `N` cells whatever the piston's is keeps `L`, and with it the physics,
//! where cells follow a round bore only roughly, and in models that symmetry planes cut.
//!
//! Kept is the excess `M - N (L - H)`, so that rounding is relative to the flow.

use crate::lattice::units::Units;
use tremie_messages::scene::{Reservoir, ReservoirMode};
use tremie_state::{StateError, StateExchange};

/// Part of the cylinder's length at which a piston has come too close to the face.
pub const LEAST: f64 = 0.05;

/// The cylinder and what is in it.
#[derive(Clone, Debug)]
pub struct Cylinder {
    reservoir: Reservoir,
    /// Cells at the face.
    count: f64,
    /// Length at time zero [cells].
    length: f64,
    /// Way of the piston [cells].
    travel: f64,
    /// Velocity of the piston in the last step.
    pub piston: f64,
    /// Mass beyond that at density 1.
    excess: f64,
    /// Mass that has entered the domain.
    pub entered: f64,
    /// Density minus 1 of `mk`, which keeps no mass.
    literal: f64,
}

impl Cylinder {
    /// Behind a face of `count` cells, at density 1.
    pub fn new(reservoir: &Reservoir, count: usize, units: &Units) -> Self {
        Self {
            count: count as f64,
            length: reservoir.length() / units.cell,
            travel: 0.0,
            piston: 0.0,
            excess: 0.0,
            entered: 0.0,
            literal: 0.0,
            reservoir: reservoir.clone(),
        }
    }

    /// Keeps piston and fluid, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("travel", &mut self.travel)?;
        state.value("piston", &mut self.piston)?;
        state.value("excess", &mut self.excess)?;
        state.value("entered", &mut self.entered)?;
        state.value("literal", &mut self.literal)
    }

    /// Length that is left [cells].
    fn left(&self) -> f64 {
        self.length - self.travel
    }

    /// Volume that is left, as a part of that at time zero.
    pub fn part_left(&self) -> f64 {
        self.left() / self.length
    }

    /// Density minus 1.
    pub fn drho(&self) -> f64 {
        match self.reservoir.mode {
            ReservoirMode::Conservative => self.excess / (self.count * self.left()),
            ReservoirMode::Mk => self.literal,
        }
    }

    /// Mass.
    pub fn mass(&self) -> f64 {
        (1.0 + self.drho()) * self.count * self.left()
    }

    /// Gives the fluid a density, less 1.
    pub fn fill(&mut self, drho: f64) {
        (self.excess, self.literal) = (drho * self.count * self.left(), drho);
    }

    /// Moves the piston through the step that begins at a time [s]; the midpoint's velocity makes
    /// its way exact where the course is linear. `face` is the mean velocity into the domain at the
    /// step's begin. Returns whether the piston is clear of the face; if not, nothing has changed.
    #[must_use]
    pub fn advance(&mut self, time: f64, face: f64, units: &Units) -> bool {
        let middle = time + 0.5 * units.time_step;
        let piston = self.reservoir.piston_at(middle) / units.velocity();
        if self.left() - piston < LEAST * self.length {
            return false;
        }
        // Mutabaruka & Kamrin, Eq. 30: times exp(x). As a fraction, x^5/720 off.
        let x = (piston - face) / self.left();
        self.literal += (1.0 + self.literal) * x / (1.0 - 0.5 * x + x * x / 12.0);
        self.travel += piston;
        self.excess += self.count * piston;
        self.piston = piston;
        true
    }

    /// Lets a mass enter the domain.
    pub fn drain(&mut self, mass: f64) {
        self.excess -= mass;
        self.entered += mass;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNITS: Units = Units { cell: 0.5, time_step: 2.0, density: 1.0, min: [0.0; 3] };

    /// A closed cylinder compressed by a third holds its mass.
    #[test]
    fn a_closed_cylinder_keeps_its_mass() {
        let mut cylinder = Cylinder::new(&Reservoir::new(1.0, 30.0, 0.025), 7, &UNITS);
        cylinder.fill(0.01);
        let mass = cylinder.mass();
        assert!((mass - 7.0 * 60.0 * 1.01).abs() < 1e-12);
        for step in 0..200 {
            assert!(cylinder.advance(2.0 * f64::from(step), 0.0, &UNITS));
        }
        assert!((cylinder.mass() - mass).abs() < 1e-10);
        assert!((cylinder.drho() - (1.01 * 1.5 - 1.0)).abs() < 1e-12, "{}", cylinder.drho());
        assert!((cylinder.part_left() - 2.0 / 3.0).abs() < 1e-12);
        cylinder.drain(7.0);
        assert!((cylinder.mass() - mass + 7.0).abs() < 1e-10);
    }

    #[test]
    fn a_piston_stops_before_the_face() {
        let mut cylinder = Cylinder::new(&Reservoir::new(1.0, 5.0, 0.25), 1, &UNITS);
        let steps = (0..100).take_while(|_| cylinder.advance(0.0, 0.0, &UNITS)).count();
        // Ten cells, one a step: the last half cell is left.
        assert_eq!(steps, 9);
        assert!((cylinder.part_left() - 0.1).abs() < 1e-12);
    }
}
