//! Loads on the bodies and the balance of a step.

use crate::bodies::body::Body;
use crate::boundary::virtual_piston::face::ReservoirFace;
use crate::domain::mirrors::{mirrors_of_part, near_mirrors, with_image};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::grid::Grid;
use crate::lattice::ledger::{Ledger, add_scaled};
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::reductions::CellStatistics;
use crate::solver::lbm_solver::{LbmSolver, before};
use tremie_messages::Load;

impl<T: CollisionKernel> LbmSolver<T> {
    /// Begins the balance of a step.
    pub(crate) fn begin_balance(&mut self) {
        let old = self.balance;
        self.balance = Ledger { momentum: old.momentum, mass: old.mass, ..Ledger::default() };
        for body in &self.bodies.leaving {
            add_scaled(&mut self.balance.dropped, body.carried[0], 1.0);
        }
    }

    /// Gives the bodies their loads, from what their links exchanged, and balances them.
    pub(crate) fn give_loads(&mut self, loads: &mut [Load]) {
        self.press();
        self.exchange = MomentumExchange::default();
        self.load_facets();
        let (force_unit, torque_unit) = (self.units.force(), self.units.force() * self.units.cell);
        let (balance, grid) = (&mut self.balance, &self.layout.grid);
        for (body, load) in self.bodies.living.iter_mut().zip(loads) {
            let mut exchange: MomentumExchange = self.exchanges[body.items.clone()].iter().sum();
            if self.slips && body.is_part() {
                exchange.join(&self.slip.on_body(body.handle));
            }
            self.exchange.join(&exchange);
            let mut own = [exchange.force, exchange.torque];
            for k in 0..2 {
                add_scaled(&mut own[k], body.pressed[k], 1.0);
            }
            let mirrors = mirrors_of(grid, body);
            let mut given = with_image(mirrors, own);
            add_scaled(&mut balance.gaps, body.pressed[0], 1.0);
            add_scaled(&mut balance.images, given[0], 1.0);
            add_scaled(&mut balance.images, own[0], -1.0);
            add_scaled(&mut balance.images, exchange.image, 1.0);
            if self.average_force {
                let half = given.map(|v| v.map(|x| 0.5 * x));
                given = std::array::from_fn(|k| {
                    std::array::from_fn(|a| half[k][a] + body.carried[k][a])
                });
                body.carried = half;
                add_scaled(&mut balance.carried, half[0], 1.0);
            }
            let [buoyancy, turn] = match self.lift {
                [0.0, 0.0, 0.0] => [[0.0; 3]; 2],
                _ => body.displaced(grid, mirrors).load(self.lift),
            };
            add_scaled(&mut balance.delivered, given[0], 1.0);
            add_scaled(&mut balance.buoyancy, buoyancy, 1.0);
            let force = std::array::from_fn(|a| given[0][a] + buoyancy[a]);
            body.urge(force);
            *load = Load {
                id: body.id,
                force: force.map(|f| f * force_unit),
                torque: std::array::from_fn(|a| (given[1][a] + turn[a]) * torque_unit),
            };
        }
    }

    /// Completes the balance of a step from the survey before the collision and what was exchanged
    /// after it.
    pub(crate) fn end_balance(&mut self, collided: bool) {
        let mirrors = self.join_fixtures();
        let balance = &mut self.balance;
        let old = (balance.momentum, balance.mass);
        let mass = self.owners.fluid_cells as f64 + self.survey.excess;
        if collided {
            balance.body_force = self.relaxation.acceleration.map(|a| a * mass);
            let unmirrored = self.exchange.unmirrored;
            balance.symmetry = std::array::from_fn(|a| mirrors[a] - unmirrored[a]);
            for (number, exchange) in self.fixtures.iter().enumerate() {
                if number < usize::from(BoundaryId::FACES) {
                    add_scaled(&mut balance.walls, exchange.force, -1.0);
                    balance.mass_walls += exchange.mass;
                } else {
                    add_scaled(&mut balance.parts, exchange.force, -1.0);
                    balance.mass_parts += exchange.mass;
                }
            }
            for item in &self.open_items {
                add_scaled(&mut balance.open, item.impulse, 1.0);
                balance.mass_open += item.mass;
            }
            for (impulse, mass) in self.reservoirs.iter().flat_map(ReservoirFace::gained) {
                add_scaled(&mut balance.open, impulse, 1.0);
                balance.mass_open += mass;
            }
            // What the face replaced came through it.
            for brought in &self.brought {
                balance.mass_open += brought.total();
                balance.mass_walls -= brought.by_faces;
                balance.mass_parts -= brought.by_parts;
            }
            let image = self.exchange.image;
            balance.bodies = std::array::from_fn(|a| image[a] - self.exchange.force[a]);
            let image = self.exchange.image_swept;
            balance.swept = std::array::from_fn(|a| self.exchange.swept[a] - image[a]);
            balance.mass_bodies = self.exchange.mass;
            let pinched = self.pinched.impulse;
            balance.frozen = std::array::from_fn(|a| pinched[a] - self.declared.impulse[a]);
        }
        for (fixture, pressed) in self.fixtures.iter_mut().zip(&self.pressed) {
            fixture.join(pressed);
        }
        balance.mass = mass
            + (balance.mass_walls + balance.mass_parts + balance.mass_open + balance.mass_bodies);
        for a in 0..3 {
            balance.momentum[a] = self.survey.j[a]
                + (balance.body_force[a] + balance.bodies[a] + balance.swept[a])
                + (balance.walls[a] + balance.symmetry[a] + balance.parts[a] + balance.open[a])
                + balance.frozen[a];
            balance.momentum_change[a] = balance.momentum[a] - old.0[a];
        }
        balance.mass_change = balance.mass - old.1;
        self.ledger = balance.scaled(self.units.impulse(), self.units.mass());
    }

    /// Surveys the fluid as it stands, without a collision.
    pub(crate) fn measure(&mut self) {
        let (before, owners) = (before!(self), &self.owners);
        let acceleration = self.relaxation.acceleration;
        self.team.for_each(&mut self.blocks, |_, block| {
            let mut survey =
                CellStatistics { min_drho: 0.0, max_drho: 0.0, ..CellStatistics::NONE };
            let first = block.lines.start * T::LINE;
            let end = (block.lines.end * T::LINE).min(before.layout.cells.len());
            for cell in first as u32..end as u32 {
                if owners.is_fluid(cell) {
                    let content = before.content(cell);
                    let u = content.velocity(acceleration);
                    survey.join(&CellStatistics {
                        excess: content.drho,
                        j: content.j,
                        speed2: crate::lattice::d3q19::dot(u, u),
                        min_drho: content.drho,
                        max_drho: content.drho,
                        max_tau: 0.0,
                    });
                }
            }
            block.survey = survey;
        });
        self.join_surveys();
    }
}

/// Axes across which a symmetry plane cuts a body.
fn mirrors_of(grid: &Grid, body: &Body) -> [bool; 3] {
    match body.part {
        Some(_) => mirrors_of_part(grid, body.position),
        None => near_mirrors(grid, body.position, body.radius),
    }
}
