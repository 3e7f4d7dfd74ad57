//! Bodies move: cells leave the fluid and join it, links are found.

use crate::boundary::mesh_links::LinkSearch;
use crate::boundary::refill::Content;
use crate::lattice::cell_flags::{CellFlags, Vacated};
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::ledger::add_scaled;
use crate::solver::lbm_solver::{LbmSolver, before};
use std::sync::atomic::Ordering::Relaxed;
use tremie_messages::BodyState;

/// A cell to refill, and what it then holds.
#[derive(Clone, Copy, Debug)]
pub struct Filled {
    vacated: Vacated,
    content: Content,
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// Moves the bodies: covers and uncovers cells, refills.
    pub(crate) fn move_bodies(&mut self, states: &[BodyState]) {
        self.owners.begin();
        let moved = self.bodies.take(states, &self.units, &self.layout.grid);
        if !moved && !self.declared.is_fresh() {
            return;
        }
        let all_want = self.wanted.begin();
        let (layout, lines) = (&self.layout, &self.wanted.lines);
        let mut outgrown = false;
        for body in &mut self.bodies.living {
            outgrown |= body.cover_part(layout, &mut self.team);
        }
        self.team.for_each(&mut self.bodies.living, |_, body| {
            let wants_others = body.cover(layout, T::LINE);
            if all_want || wants_others {
                body.want(lines);
            }
        });
        for body in self.bodies.leaving.iter().chain(&self.bodies.living) {
            for &cell in &body.left {
                self.owners.release(cell, body.handle);
            }
        }
        for body in &self.bodies.living {
            for &cell in &body.entered {
                self.owners.claim(cell, body.handle);
            }
        }
        self.bodies.note_sharing(self.owners.sharing());
        self.freeze();
        self.count_losses();
        self.refill();
        self.owners.admit();
        self.find_pinched_anew();
        self.note_changes();
        if !self.declared.is_empty() {
            self.declared.find_mouths(&self.owners, &self.layout);
            self.intakes.look(self.declared.by_cell(), &self.owners, &self.layout);
        }
        if self.slips {
            let (gaps, bodies, owners) = (&self.declared, &self.bodies, &self.owners);
            self.slip.find(gaps, bodies, owners, &self.layout, &mut self.team);
        }
        self.owners.forget_changes();
        self.bodies.forget_leaving();
        if outgrown {
            self.list_items();
        }
        self.find_links(all_want);
    }

    /// Notes where cells joined the fluid or left it.
    fn note_changes(&mut self) {
        let CellFlags { covered, enclosed, vacated, .. } = &self.owners;
        let changed = covered.iter().chain(enclosed).copied();
        let changed = changed.chain(vacated.iter().map(|vacated| vacated.cell));
        self.bricks.begin(&self.layout, changed);
    }

    /// Freezes and thaws cells of gaps, and decides which cells are isolated.
    fn freeze(&mut self) {
        let (layout, bodies, owners) = (&self.layout, &self.bodies, &mut self.owners);
        if self.declared.is_empty() {
            return owners.settle(layout);
        }
        if bodies.parts_moved() || self.declared.is_fresh() {
            self.declared.measure(layout, bodies, &mut self.team);
        }
        self.declared.freeze(owners, bodies, &mut self.team);
        owners.settle(layout);
        self.declared.close_pockets(owners, layout, &mut self.team);
    }

    /// Finds the links of parts and polyhedra that have moved, and wants the densities that they need, if `all_want`
    /// those of all.
    fn find_links(&mut self, all_want: bool) {
        let walls = self.feels_gaps().then_some(&self.walls);
        let layout = &self.layout;
        let gap_between = |part, fixture, at| self.declared.between(part, fixture, at);
        let site = LinkSearch { layout, walls, gap_between: &gap_between, line: T::LINE };
        let (bodies, lines) = (&self.bodies, &self.wanted.lines);
        let items = &mut self.link_items[bodies.items_with_surface()];
        self.team.for_each(items, |_, item| {
            if item.find(&site, bodies) || all_want {
                for &line in item.found.lines() {
                    lines[line as usize].store(1, Relaxed);
                }
            }
        });
    }

    /// Balances what left the fluid with covered and isolated cells.
    fn count_losses(&mut self) {
        for k in 0..self.owners.covered.len() {
            let cell = self.owners.covered[k];
            let content = self.before().content(cell);
            add_scaled(&mut self.balance.covered, content.j, -1.0);
            self.balance.mass_covered -= 1.0 + content.drho;
            self.charge(cell, content.drho);
        }
        for k in 0..self.owners.enclosed.len() {
            let cell = self.owners.enclosed[k];
            let content = self.before().content(cell);
            add_scaled(&mut self.balance.isolated, content.j, -1.0);
            self.balance.mass_isolated -= 1.0 + content.drho;
            self.charge(cell, content.drho);
        }
    }

    /// Fills the cells that joined the fluid.
    fn refill(&mut self) {
        self.refills.clear();
        for &vacated in &self.owners.vacated {
            self.refills.push(Filled { vacated, content: Content::default() });
        }
        let before = before!(self);
        let (owners, bodies, declared) = (&self.owners, &self.bodies, &self.declared);
        self.team.for_each(&mut self.refills, |_, refill| {
            let Vacated { cell, handle } = refill.vacated;
            let body = bodies.any_with_handle(handle);
            refill.content = before.refill(owners, cell, body, declared.drho_at(cell));
        });
        for k in 0..self.refills.len() {
            let Filled { vacated, content } = self.refills[k];
            add_scaled(&mut self.balance.uncovered, content.j, 1.0);
            self.balance.mass_uncovered += 1.0 + content.drho;
            self.credit(vacated.handle, content.drho);
        }
    }
}
