//! Bodies move: cells leave the fluid and join it, links are found.

use crate::boundary::mesh_links::LinkSearch;
use crate::boundary::refill::Content;
use crate::lattice::cell_flags::{CellFlags, Vacated};
use crate::lattice::collision_kernel::DensityRequests;
use crate::lattice::populations::Real;
use crate::solver::budget::{Budget, Changed};
use crate::solver::execution::Execution;
use crate::solver::far_means::{FarCell, far_means};
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::mass_correction::{charge, credit};
use crate::solver::moving_bodies::MovingBodies;
use std::sync::atomic::Ordering::Relaxed;

/// A cell to refill, and what it then holds.
#[derive(Clone, Copy, Debug)]
pub struct Filled {
    vacated: Vacated,
    /// Density minus 1 of the fluid near it, if there is some.
    near: Option<f64>,
    content: Content,
}

impl MovingBodies {
    /// Finds the cells that bodies hold now, and asks for the densities near them, if `all_want`
    /// for those of all. True if links need other items.
    pub fn rasterise<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        requests: &DensityRequests<T>,
        all_want: bool,
        exec: &mut Execution,
    ) -> bool {
        let (layout, lines) = (&lattice.layout, &requests.lines);
        let mut outgrown = false;
        for body in &mut self.list.living {
            outgrown |= body.cover_part(layout, &mut exec.team);
        }
        exec.team.for_each(&mut self.list.living, |_, body| {
            let wants_others = body.cover(layout, T::LINE);
            if all_want || wants_others {
                body.want(lines);
            }
        });
        outgrown
    }

    /// Gives the cells that bodies left back, and claims those that they entered.
    pub fn claim_cells(&mut self, flags: &mut CellFlags) {
        for body in self.list.leaving.iter().chain(&self.list.living) {
            for &cell in &body.left {
                flags.release(cell, body.handle);
            }
        }
        for body in &self.list.living {
            for &cell in &body.entered {
                flags.claim(cell, body.handle);
            }
        }
        self.list.note_sharing(flags.sharing());
    }

    /// Finds the links of parts and polyhedra that have moved, and asks for the densities that they
    /// need, if `all_want` for those of all.
    pub fn find_links<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        gaps: &GapModel,
        requests: &DensityRequests<T>,
        all_want: bool,
        exec: &mut Execution,
    ) {
        let layout = &lattice.layout;
        let gap_between = |part, fixture, at| gaps.modelled.between(part, fixture, at);
        let walls = gaps.tables.walls.as_ref();
        let site = LinkSearch { layout, walls, gap_between: &gap_between, line: T::LINE };
        let (bodies, lines) = (&self.list, &requests.lines);
        let items = &mut self.links[bodies.items_with_surface()];
        exec.team.for_each(items, |_, item| {
            if item.find(&site, bodies) || all_want {
                for &line in item.found.lines() {
                    lines[line as usize].store(1, Relaxed);
                }
            }
        });
    }
}

/// Balances what left the fluid with covered and isolated cells.
pub fn count_losses<T: Real>(
    lattice: &LatticeState<T>,
    bodies: &mut MovingBodies,
    gaps: &GapModel,
    budget: &mut Budget,
) {
    let Changed { covered, isolated, .. } = &mut budget.changed;
    let own = |cell: &&u32| lattice.layout.is_own(**cell);
    for &cell in lattice.flags.covered.iter().filter(own) {
        let content = lattice.before().content(cell);
        covered.add(&content);
        charge(bodies, gaps, lattice, cell, content.drho);
    }
    for &cell in lattice.flags.enclosed.iter().filter(own) {
        let content = lattice.before().content(cell);
        isolated.add(&content);
        charge(bodies, gaps, lattice, cell, content.drho);
    }
}

/// Fills the cells that joined the fluid; see `refill`.
pub fn refill<T: Real>(
    lattice: &LatticeState<T>,
    bodies: &mut MovingBodies,
    gaps: &GapModel,
    budget: &mut Budget,
    exec: &mut Execution,
) {
    let mut refills = std::mem::take(&mut bodies.refills);
    refills.clear();
    let empty = |&vacated: &Vacated| Filled { vacated, near: None, content: Content::default() };
    refills.extend(lattice.flags.vacated.iter().map(empty));
    let (before, flags, list) = (lattice.before(), &lattice.flags, &bodies.list);
    exec.team.for_each(&mut refills, |_, refill| {
        refill.near = before.mean_near(flags, refill.vacated.cell);
    });
    let far = refills.iter().filter(|refill| refill.near.is_none()).map(|refill| {
        let Vacated { cell, handle } = refill.vacated;
        // Inside a body that was removed fluid is as far away as its surface.
        let farthest = list.any_with_handle(handle).radius.ceil() as i32 + 2;
        FarCell { cell, farthest }
    });
    let means = far_means(&before, flags, &lattice.numbers, far, exec);
    exec.team.for_each(&mut refills, |_, refill| {
        let Vacated { cell, handle } = refill.vacated;
        let alone = || gaps.modelled.drho_at(cell);
        let drho = refill.near.or_else(|| means.get(&cell).copied()).unwrap_or_else(alone);
        refill.content = before.refill(flags, cell, list.any_with_handle(handle), drho);
    });
    let own = |filled: &&Filled| lattice.layout.is_own(filled.vacated.cell);
    for &Filled { vacated, content, .. } in refills.iter().filter(own) {
        budget.changed.uncovered.add(&content);
        credit(bodies, vacated.handle, content.drho);
    }
    bodies.refills = refills;
}
