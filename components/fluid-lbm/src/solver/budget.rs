//! The balance of momentum and mass of a step, term by term; see [`Ledger`].

use crate::bodies::body::Body;
use crate::boundary::refill::Content;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::exact_sum::{ExactSum, add_vector, values};
use crate::lattice::ledger::{Ledger, add_scaled};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::lattice_state::LatticeState;
use crate::solver::lost_mass::Lost;
use crate::solver::moving_bodies::MovingBodies;
use crate::solver::static_boundaries::StaticBoundaries;
use tremie_state::{StateError, StateExchange};

/// Account of the last step's momentum and mass.
#[derive(Default)]
pub struct Budget {
    /// In lattice units.
    pub balance: Ledger,
    /// In SI units.
    pub ledger: Ledger,
    /// Cells that left the fluid and joined it in this step.
    pub changed: Changed,
    /// Mass that the scheme lost since the start.
    pub lost: Lost,
}

/// What cells held that left the fluid, or hold that joined it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contents {
    j: [ExactSum; 3],
    mass: ExactSum,
}

impl Contents {
    /// Adds a cell.
    pub fn add(&mut self, content: &Content) {
        add_vector(&mut self.j, content.j);
        self.mass.add(1.0 + content.drho);
    }
}

/// What cells held that bodies covered or cut off in a step, and what those hold that they uncovered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Changed {
    /// Covered ones.
    pub covered: Contents,
    /// Those cut off.
    pub isolated: Contents,
    /// Uncovered ones.
    pub uncovered: Contents,
}

impl Changed {
    /// All sums.
    pub fn sums(&mut self) -> impl Iterator<Item = &mut ExactSum> {
        let all = [&mut self.covered, &mut self.isolated, &mut self.uncovered];
        all.into_iter().flat_map(|Contents { j, mass }| j.iter_mut().chain([mass]))
    }
}

impl Budget {
    /// Begins the balance of a step, in which some bodies leave.
    pub fn begin(&mut self, leaving: &[Body]) {
        let Ledger { momentum, mass, .. } = self.balance;
        self.balance = Ledger { momentum, mass, ..Ledger::default() };
        self.changed = Changed::default();
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

    /// Adds the momentum and mass that came through open faces, after walls: what the face replaced came through
    /// it, not from them.
    pub fn add_open_faces(&mut self, gained: [f64; 4], walls: &StaticBoundaries) {
        let balance = &mut self.balance;
        let [x, y, z, mass] = gained;
        balance.open = [x, y, z];
        balance.mass_open = mass;
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

    /// Adds what left with cells and came with them, once it is that of all ranks.
    pub fn add_changed(&mut self) {
        let (balance, Changed { covered, isolated, uncovered }) = (&mut self.balance, self.changed);
        let out = |contents: &Contents| values(&contents.j).map(|j| -j);
        (balance.covered, balance.mass_covered) = (out(&covered), -covered.mass.value());
        (balance.isolated, balance.mass_isolated) = (out(&isolated), -isolated.mass.value());
        (balance.uncovered, balance.mass_uncovered) =
            (values(&uncovered.j), uncovered.mass.value());
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
        let (cells, mean) = (lattice.fluid_cells, self.mean_density(lattice));
        self.balance.mass_lost = self.lost.count(cells, took, bodies.receded(), mean);
        self.ledger.mass_lost = self.balance.mass_lost * lattice.units.mass();
    }

    /// Mean density of the fluid at the end of the step.
    pub fn mean_density<T: Real>(&self, lattice: &LatticeState<T>) -> f64 {
        self.balance.mass / lattice.fluid_cells.max(1) as f64
    }
}

/// Mass of the fluid before the last collision.
fn mass_before<T: Real>(lattice: &LatticeState<T>) -> f64 {
    lattice.fluid_cells as f64 + lattice.statistics.excess
}
