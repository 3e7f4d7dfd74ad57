//! The balance of momentum and mass of a step, term by term; see [`Ledger`].

use crate::bodies::body::Body;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::ledger::{Ledger, add_scaled};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::lattice_state::LatticeState;
use crate::solver::lost_mass::Lost;
use crate::solver::moving_bodies::MovingBodies;
use crate::solver::open_boundaries::OpenBoundaries;
use crate::solver::static_boundaries::StaticBoundaries;
use tremie_state::{StateError, StateExchange};

/// Account of the last step's momentum and mass.
#[derive(Default)]
pub struct Budget {
    /// In lattice units.
    pub balance: Ledger,
    /// In SI units.
    pub ledger: Ledger,
    /// Mass that the scheme lost since the start.
    pub lost: Lost,
}

impl Budget {
    /// Begins the balance of a step, in which some bodies leave.
    pub fn begin(&mut self, leaving: &[Body]) {
        let Ledger { momentum, mass, .. } = self.balance;
        self.balance = Ledger { momentum, mass, ..Ledger::default() };
        for body in leaving {
            add_scaled(&mut self.balance.dropped, body.carried[0], 1.0);
        }
    }

    /// Keeps the balance and the account of lost mass, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        units: &Units,
    ) -> Result<(), StateError> {
        state.value("balance", &mut self.balance)?;
        state.value("lost", &mut self.lost)?;
        self.ledger = self.balance.scaled(units.impulse(), units.mass());
        Ok(())
    }

    /// Adds what bodies gave, and symmetry planes along their axes.
    pub fn add_bodies(&mut self, total: &MomentumExchange, mirrors: [f64; 3]) {
        let balance = &mut self.balance;
        balance.symmetry = std::array::from_fn(|a| mirrors[a] - total.unmirrored[a]);
        balance.bodies = std::array::from_fn(|a| total.image[a] - total.force[a]);
        balance.swept = std::array::from_fn(|a| total.swept[a] - total.image_swept[a]);
        balance.mass_bodies = total.mass;
    }

    /// Adds what walls and static solids gave.
    pub fn add_walls(&mut self, walls: &StaticBoundaries) {
        let balance = &mut self.balance;
        for (number, exchange) in walls.exchanges.iter().enumerate() {
            if number < usize::from(BoundaryId::FACES) {
                add_scaled(&mut balance.walls, exchange.force, -1.0);
                balance.mass_walls += exchange.mass;
            } else {
                add_scaled(&mut balance.parts, exchange.force, -1.0);
                balance.mass_parts += exchange.mass;
            }
        }
    }

    /// Adds what came through open faces, after walls: what the face replaced came through it, not
    /// from them.
    pub fn add_open_faces<T: Real>(&mut self, faces: &OpenBoundaries<T>, walls: &StaticBoundaries) {
        let balance = &mut self.balance;
        faces.each_gain(|impulse, mass| {
            add_scaled(&mut balance.open, impulse, 1.0);
            balance.mass_open += mass;
        });
        for brought in &walls.brought {
            balance.mass_open += brought.total();
            balance.mass_walls -= brought.by_faces;
            balance.mass_parts -= brought.by_parts;
        }
    }

    /// Adds what the scene's acceleration gave, and what frozen and pinched cells did.
    pub fn add_forces<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        pinched: [f64; 3],
        on_frozen: [f64; 3],
    ) {
        let mass = mass_before(lattice);
        self.balance.body_force = lattice.relaxation.acceleration.map(|a| a * mass);
        self.balance.frozen = std::array::from_fn(|a| pinched[a] - on_frozen[a]);
    }

    /// Completes the balance: momentum and mass at the step's end are those before the collision
    /// and all that was exchanged after it.
    pub fn close<T: Real>(&mut self, lattice: &LatticeState<T>) {
        let balance = &mut self.balance;
        let old = (balance.momentum, balance.mass);
        balance.mass = mass_before(lattice)
            + (balance.mass_walls + balance.mass_parts + balance.mass_open + balance.mass_bodies);
        for a in 0..3 {
            balance.momentum[a] = lattice.statistics.j[a]
                + (balance.body_force[a] + balance.bodies[a] + balance.swept[a])
                + (balance.walls[a] + balance.symmetry[a] + balance.parts[a] + balance.open[a])
                + balance.frozen[a];
            balance.momentum_change[a] = balance.momentum[a] - old.0[a];
        }
        balance.mass_change = balance.mass - old.1;
        self.ledger = balance.scaled(lattice.units.impulse(), lattice.units.mass());
    }

    /// Notes what walls and bodies owe the fluid.
    pub fn note_owed(&mut self, owed: f64, units: &Units) {
        self.balance.mass_owed = owed;
        self.ledger.mass_owed = owed * units.mass();
    }

    /// Adds what a step lost, once its balance is known.
    pub fn count_lost<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        walls: &StaticBoundaries,
        bodies: &MovingBodies,
    ) {
        let took = self.balance.mass_open + walls.through_parts() - self.balance.mass_change;
        let (cells, mean) = (lattice.flags.fluid_cells, self.mean_density(lattice));
        self.balance.mass_lost = self.lost.count(cells, took, bodies.receded(), mean);
        self.ledger.mass_lost = self.balance.mass_lost * lattice.units.mass();
    }

    /// Mean density of the fluid at the end of the step.
    pub fn mean_density<T: Real>(&self, lattice: &LatticeState<T>) -> f64 {
        self.balance.mass / lattice.flags.fluid_cells.max(1) as f64
    }
}

/// Mass of the fluid before the last collision.
fn mass_before<T: Real>(lattice: &LatticeState<T>) -> f64 {
    lattice.flags.fluid_cells as f64 + lattice.statistics.excess
}
