//! Loads on the bodies and the balance of a step.

use crate::kernel::{Collides, Survey};
use crate::ledger::{Ledger, add_scaled};
use crate::links::Exchange;
use crate::owners::FLUID;
use crate::solver::{Solver, before};
use tremie_messages::Load;

impl<T: Collides> Solver<T> {
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
        let (force_unit, torque_unit) = (self.units.force(), self.units.force() * self.units.cell);
        let balance = &mut self.balance;
        self.exchange = Exchange::default();
        let mut items = self.link_items.iter().peekable();
        for (place, (body, load)) in self.bodies.living.iter_mut().zip(loads).enumerate() {
            let mut exchange = Exchange::default();
            while let Some(item) = items.next_if(|item| item.body == place) {
                exchange.join(&item.exchange);
            }
            self.exchange.join(&exchange);
            let mut given = [exchange.force, exchange.torque];
            if self.average_force {
                let half = given.map(|v| v.map(|x| 0.5 * x));
                given = std::array::from_fn(|k| {
                    std::array::from_fn(|a| half[k][a] + body.carried[k][a])
                });
                body.carried = half;
                add_scaled(&mut balance.carried, half[0], 1.0);
            }
            let buoyancy = self.lift.map(|lift| lift * body.volume());
            add_scaled(&mut balance.delivered, given[0], 1.0);
            add_scaled(&mut balance.buoyancy, buoyancy, 1.0);
            *load = Load {
                id: body.id,
                force: std::array::from_fn(|a| (given[0][a] + buoyancy[a]) * force_unit),
                torque: given[1].map(|x| x * torque_unit),
            };
        }
    }

    /// Completes the balance of a step from the survey before the collision and what was exchanged
    /// after it.
    pub(crate) fn end_balance(&mut self, collided: bool) {
        let balance = &mut self.balance;
        let old = (balance.momentum, balance.mass);
        let mass = self.owners.fluid_cells as f64 + self.survey.excess;
        if collided {
            balance.body_force = self.relaxation.acceleration.map(|a| a * mass);
            for item in &self.wall_items {
                add_scaled(&mut balance.walls, item.impulse, 1.0);
                balance.mass_walls += item.mass;
            }
            balance.bodies = self.exchange.force.map(|x| -x);
            balance.swept = self.exchange.swept;
            balance.mass_bodies = self.exchange.mass;
        }
        balance.mass = mass + balance.mass_walls + balance.mass_bodies;
        for a in 0..3 {
            balance.momentum[a] = self.survey.j[a]
                + (balance.body_force[a] + balance.walls[a] + balance.bodies[a] + balance.swept[a]);
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
            let mut survey = Survey { min_drho: 0.0, max_drho: 0.0, ..Survey::NONE };
            for row in block.rows.clone() {
                let [y, z] = before.grid.row_at(row);
                for x in 0..before.grid.n[0] {
                    let cell = before.grid.cell([x, y, z]);
                    if owners.of(cell.index) != FLUID {
                        continue;
                    }
                    let content = before.content(cell);
                    let u = content.velocity(acceleration);
                    survey.join(&Survey {
                        excess: content.drho,
                        j: content.j,
                        speed2: crate::lattice::dot(u, u),
                        min_drho: content.drho,
                        max_drho: content.drho,
                    });
                }
            }
            block.survey = survey;
        });
        self.join_surveys();
    }
}
