//! What comes back from bodies, walls and open faces after a collision, and what it adds up to.

use crate::boundary::link_batch::Batch;
use crate::boundary::open_boundary::PostStreaming;
use crate::boundary::post_collision::{self, PostCollision, nearest_wall};
use crate::boundary::wall_mass::Patches;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::error::FluidError;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::solver::lbm_solver::LbmSolver;
use tremie_team::Cut;

impl<T: CollisionKernel> LbmSolver<T> {
    /// Mean density of the fluid in the last collision.
    fn mean_density(&self) -> f64 {
        1.0 + self.survey.excess / (self.owners.fluid_cells as f64).max(1.0)
    }

    /// Reflects the populations that ran into bodies and fixtures. Bodies come first: at a cell
    /// between a body and a curved wall they read what the wall's links change in place.
    pub(crate) fn reflect(&mut self) {
        let after = PostCollision {
            field: &self.field,
            layout: &self.layout,
            owners: &self.owners,
            bricks: &self.bricks,
            parity: self.parity,
            drho: &self.wanted.drho,
            variant: self.variant,
            mean: self.mean_density(),
            keeps_mass: self.keeps_mass,
            nearest_wall: nearest_wall(self.tau),
            walls: self.feels_gaps().then_some(&self.walls),
            gap_of: &self.gap_of,
            slips: self.slips,
            intakes: &self.intakes,
        };
        let bodies = &self.bodies;
        let with_surface = bodies.items_with_surface();
        let cut = &mut self.link_items[with_surface.clone()];
        let any_cut = cut.iter().any(|item| !item.found.cuts().is_empty());
        if any_cut {
            self.team.for_each(cut, |_, item| {
                after.read_cuts(&bodies.living[item.body], item.found.cuts_mut());
            });
        }
        if self.slips {
            self.slip.read(&after, bodies, &mut self.team);
        }
        self.declared.reflect(&after);
        let items = (Cut::every(&mut self.link_items, 1), Cut::every(&mut self.exchanges, 1));
        let reflect = |batch: &mut Batch,
                       (item, exchange): (
            &mut [post_collision::LinkItem],
            &mut [MomentumExchange],
        )| {
            exchange[0] = after.reflect(bodies, &mut item[0], batch);
        };
        if after.walls.is_some() {
            let items = (items.0, items.1, Cut::every(&mut self.seen, 1));
            self.team.for_pieces_with(
                items,
                &mut self.batches,
                |batch, _, (item, exchange, seen)| {
                    reflect(batch, (item, exchange));
                    seen[0].take(item[0].body, &item[0].gaps);
                },
            );
        } else {
            self.team
                .for_pieces_with(items, &mut self.batches, |batch, _, one| reflect(batch, one));
        }
        let step = self.units.time_step;
        let time = self.steps as f64 * step;
        for (law, now) in self.surroundings.laws.iter().zip(&mut self.now) {
            if let Some(prescribed) = law.as_ref().and_then(|law| law.in_step(time, step)) {
                *now = prescribed;
            }
        }
        let (fixed, now, references) = (&self.fixed, &self.now, &self.surroundings.references);
        let sheets = &self.sheets;
        self.team.for_each(&mut self.sheet_items, |_, item| after.read_sheets(sheets, item));
        self.team.for_each(&mut self.fixed_items, |_, item| {
            after.reflect_fixed(fixed, now, references, item);
        });
        self.team.for_each(&mut self.sheet_items, |_, item| {
            after.balance_sheets(sheets, references, item);
        });
        self.brought = Patches::brought(&self.fixed_items);
        if self.slips {
            self.slip.write(&after, references, &mut self.team);
        }
        if any_cut {
            // One after the other: the first of several bodies has a link.
            let items = self.link_items[with_surface.clone()].iter();
            for (item, exchange) in items.zip(&mut self.exchanges[with_surface]) {
                exchange.join(&after.write_cuts(&bodies.living[item.body], item.found.cuts()));
            }
        }
    }

    /// Gives the cells at open faces their populations; those at reservoirs first, because other faces
    /// read the cells inside.
    pub(crate) fn open(&mut self) -> Result<(), FluidError> {
        let next = PostStreaming {
            field: &self.field,
            layout: &self.layout,
            owners: &self.owners,
            parity: self.parity,
            acceleration: self.relaxation.acceleration,
            now: &self.now,
            scheme: self.scheme,
            variant: self.variant,
        };
        for reservoir in &mut self.reservoirs {
            reservoir.apply(&next, &mut self.team, &self.units, &self.brought)?;
        }
        let open = &self.open;
        self.team.for_each(&mut self.open_items, |_, item| next.open(open, item));
        if !self.open_items.is_empty() {
            let density = self.mean_density();
            self.open.steer(&self.open_items, &self.now, density, &self.brought);
        }
        Ok(())
    }

    /// Adds up what the fluid exchanged with each fixture: force and torque on it.
    pub(crate) fn join_fixtures(&mut self) -> [f64; 3] {
        let mut mirrors = [[0.0; 3]; 6];
        self.impulses.fill([0.0; 3]);
        for (number, block) in self.blocks.iter().enumerate() {
            self.tally.share(number, &block.reflected, &mut mirrors, &mut self.impulses);
        }
        for (fixture, impulse) in self.fixtures.iter_mut().zip(&self.impulses) {
            *fixture =
                MomentumExchange { force: impulse.map(|x| -x), ..MomentumExchange::default() };
        }
        let fixed = self.fixed_items.iter().flat_map(|item| &item.exchanges);
        let halfway = self.blocks.iter().flat_map(|block| &block.halfway.exchanges);
        let sheets = self.sheet_items.iter().flat_map(|item| &item.exchanges);
        for (BoundaryId(number), exchange) in fixed.chain(sheets).chain(halfway) {
            self.fixtures[usize::from(*number)].join(exchange);
        }
        if self.slips {
            for (number, fixture) in self.fixtures.iter_mut().enumerate() {
                fixture.join(&self.slip.on_fixture(number));
            }
        }
        self.mirrors = mirrors.map(|impulse| impulse.map(|x| -x));
        std::array::from_fn(|a| mirrors[2 * a][a] + mirrors[2 * a + 1][a])
    }
}
