//! The cylinder behind a face or a part: a uniform fluid between there and a piston, in lattice units.
//!
//! ```text
//! M = rho N (L - H)        dM/dt = - (mass that enters the domain)         dH/dt = v_p
//! ```
//!
//! `N` cells lie at the face, or are the area of the part's side. `L` is the cylinder's volume over the
//! piston's area, `H` the piston's way. That the area is `N` cells whatever the piston's is keeps `L`, and with it the physics,
//! where cells follow a round bore only roughly, and in models that symmetry planes cut.
//!
//! Kept is the excess `M - N (L - H)`, so that rounding is relative to the flow.

use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::lattice::d3q19::CS2;
use crate::lattice::error::FluidError;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::lattice::units::Units;
use tremie_messages::scene::{Reservoir, ReservoirMode};
use tremie_state::{StateError, StateExchange};

/// Part of the cylinder's length at which a piston has come too close to the face.
pub const LEAST: f64 = 0.05;

/// Largest velocity at a face [cells a step]; the lattice fails soon beyond it.
pub const FASTEST: f64 = 0.1;

/// A piston that has come too close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// Part of the volume that is left.
    left: f64,
    /// Volume at time zero [m³].
    volume: f64,
    /// Time [s].
    time: f64,
}

impl Spent {
    /// The error, of the reservoir at a place.
    pub fn at(self, place: ReservoirPlace) -> FluidError {
        let Self { left, volume, time } = self;
        FluidError::ReservoirSpent { place, left: 100.0 * left, volume, time }
    }
}

/// The cylinder and what is in it.
#[derive(Clone, Debug)]
pub struct Cylinder {
    reservoir: Reservoir,
    /// Cells at the face, or area of the side [cells].
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
    pub fn new(reservoir: &Reservoir, count: f64, units: &Units) -> Self {
        Self {
            count,
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
    /// step's begin.
    ///
    /// # Errors
    /// A piston that is not clear of the face; nothing has changed then.
    pub fn advance(&mut self, time: f64, face: f64, units: &Units) -> Result<(), Spent> {
        let middle = time + 0.5 * units.time_step;
        let piston = self.reservoir.piston_at(middle) / units.velocity();
        if self.left() - piston < LEAST * self.length {
            return Err(Spent { left: self.part_left(), volume: self.reservoir.volume, time });
        }
        // Mutabaruka & Kamrin, Eq. 30: times exp(x). As a fraction, x^5/720 off.
        let x = (piston - face) / self.left();
        self.literal += (1.0 + self.literal) * x / (1.0 - 0.5 * x + x * x / 12.0);
        self.travel += piston;
        self.excess += self.count * piston;
        self.piston = piston;
        Ok(())
    }

    /// Lets a mass enter the domain.
    pub fn drain(&mut self, mass: f64) {
        self.excess -= mass;
        self.entered += mass;
    }

    /// Whether the lattice bears the flow with these mean and largest velocities.
    ///
    /// # Errors
    /// A flow that is too fast for the lattice, or not finite.
    pub fn passes(
        &self,
        [mean, fastest]: [f64; 2],
        place: ReservoirPlace,
        units: &Units,
    ) -> Result<(), FluidError> {
        if fastest <= FASTEST && mean.is_finite() {
            return Ok(());
        }
        Err(FluidError::ReservoirFlow {
            place,
            speed: fastest * units.velocity(),
            limit: FASTEST * units.velocity(),
            pressure: CS2 * self.drho() * units.pressure(),
        })
    }

    /// State, SI units, of the reservoir at a place with this mean velocity into the domain.
    pub fn state(&self, place: ReservoirPlace, velocity: f64, units: &Units) -> ReservoirState {
        ReservoirState {
            place,
            density: (1.0 + self.drho()) * units.density,
            pressure: CS2 * self.drho() * units.pressure(),
            volume: self.reservoir.volume * self.part_left(),
            piston: self.piston * units.velocity(),
            velocity: velocity * units.velocity(),
            entered: self.entered * units.mass(),
            mass: self.mass() * units.mass(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNITS: Units = Units { cell: 0.5, time_step: 2.0, density: 1.0, min: [0.0; 3] };

    /// A closed cylinder compressed by a third holds its mass.
    #[test]
    fn a_closed_cylinder_keeps_its_mass() {
        let mut cylinder = Cylinder::new(&Reservoir::new(1.0, 30.0, 0.025), 7.0, &UNITS);
        cylinder.fill(0.01);
        let mass = cylinder.mass();
        assert!((mass - 7.0 * 60.0 * 1.01).abs() < 1e-12);
        for step in 0..200 {
            cylinder.advance(2.0 * f64::from(step), 0.0, &UNITS).unwrap();
        }
        assert!((cylinder.mass() - mass).abs() < 1e-10);
        assert!((cylinder.drho() - (1.01 * 1.5 - 1.0)).abs() < 1e-12, "{}", cylinder.drho());
        assert!((cylinder.part_left() - 2.0 / 3.0).abs() < 1e-12);
        cylinder.drain(7.0);
        assert!((cylinder.mass() - mass + 7.0).abs() < 1e-10);
    }

    #[test]
    fn a_piston_stops_before_the_face() {
        let mut cylinder = Cylinder::new(&Reservoir::new(1.0, 5.0, 0.25), 1.0, &UNITS);
        let steps = (0..100).take_while(|_| cylinder.advance(0.0, 0.0, &UNITS).is_ok()).count();
        // Ten cells, one a step: the last half cell is left.
        assert_eq!(steps, 9);
        assert!((cylinder.part_left() - 0.1).abs() < 1e-12);
    }
}
